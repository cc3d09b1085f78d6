"""Chapter 4: velocities by geometry, and the recursive method in the plane (4.1-4.15)."""

from __future__ import annotations

import re

import freebody as fb
from freebody_notes.checks import ByFunction, Related
from freebody_notes.item import Outcome


def two_links():
    """The two links of figure 4.1: OB turns at ω₀, BA at θ̇ relative to it; s leads from B to A."""
    free = fb.quantities(fb.planar("RR"))
    meaning = {
        "omega0": "omega1", "omega0_d": "omega1_d", "omega": "omega2", "omega_d": "omega2_d",
        "theta_d": "theta2_d", "theta_dd": "theta2_dd", "v_B": "v2", "v_B_d": "v2_d", "v_A": "r_d",
        "v_A_d": "r_dd", "r_A": "r", "s": "s2",
    }  # fmt: skip
    return free | {new: free[old] for new, old in meaning.items()}


def as_vectors():
    """The two links of figure 4.1 with ω and ω̇ as vectors along z."""
    free = two_links()
    z = (0.0, 0.0, 1.0)
    flat = free["omega"]
    vectors = {
        name: tuple(k * free[name] if k else flat * 0 + 0.0 for k in z)
        for name in ("omega", "omega_d")
    }
    return free | vectors | {"w": flat}


def which_are_vectors(printed: str) -> Outcome:
    """Outcome of checking which numbered equations are equations between vectors, by the sides of
    each."""
    forms = {"4.1": "omega", "4.2": "omega_d", "4.3": "v_A", "4.5": "v_A_d"}
    free = two_links()
    lines, holds = [], True
    for equation in re.findall(r"4\.\d", printed):
        vector = isinstance(free[forms[equation]], tuple)
        holds = holds and vector
        lines.append(f"({equation}) is an equation between {'vectors' if vector else 'scalars'}.")
    return Outcome(holds, tuple(lines))


def with_weights(form: str) -> Outcome:
    """Outcome of a formula with v̇₀ = 0, with a note whether the printed formula holds for v̇₀ =
    −g."""
    outcome = EXPLICIT.run(form)
    printed = {
        "f": "f_hi = fc_i + f_ik",
        "M": "M_i = Mc_i + M_k + cross(sc_i, fc_i) + cross(s_i, f_ik)",
    }[form[0]]
    accelerated = "holds" if BASE.run(printed).holds else "fails"
    line = f"Started with v̇₀ = −g instead of 0, the form without weights {accelerated}."
    return Outcome(outcome.holds, (*outcome.lines, line), outcome.example)


def loaded_start():
    """Quantities of the planar RR arm with the base accelerated by −g and a force f on the tip."""
    return fb.quantities(fb.planar("RR"), load=True, gravity="base")


def both_ways():
    """The torques from the recursion and from Lagrange's equations."""
    arm = fb.planar("RR")
    swept = fb.quantities(arm, gravity="base")
    return swept | {"tau_L": fb.derive(arm, "lagrange").tau}


THREE = 'fb.planar("RRR")'
EXPLICIT = Related(f"fb.quantities({THREE})", links=(1, 2, 3))
BASE = Related(f'fb.quantities({THREE}, gravity="base")', links=(1, 2, 3))


CHECKS = {
    "two_links": Related(two_links),
    "as_vectors": Related(as_vectors),
    "which_are_vectors": ByFunction(
        which_are_vectors, calls='fb.quantities(fb.planar("RR"))["omega2_d"]  # a scalar'
    ),
    "accelerated_base": Related(f'fb.quantities({THREE}, gravity="base")'),
    "three_links": EXPLICIT,
    "with_weights": ByFunction(
        with_weights,
        ("f_hi", "fc_i", "f_ik", "sc_i", "s_i"),
        calls='fb.relation(fb.quantities(fb.planar("RRR")), form)  '
        '# i = 1, 2, 3; and with gravity="base"',
    ),
    "loaded_start": Related(loaded_start),
    "both_ways": Related(both_ways),
}
