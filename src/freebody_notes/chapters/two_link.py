"""Section 3.3: Newton and Euler for the arm of two links, to the closed form (3.10-3.29)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import ARM, Answer, ByFunction, Related, number
from freebody_notes.item import Outcome, parts
from freebody_textbook.relations.formula import parse
from freebody_textbook.relations.formula_values import value
from freebody_textbook.relations.quantities import Quantities


def closed_form():
    """The arm's equations of motion in closed form, with h, the coefficient of θ̇₁² in τ₂, and H21
    = H12, which the notes do not define."""
    free = fb.quantities(fb.planar("RR"))
    h = free["c"][1] / free["theta1_d"] ** 2
    rates = {name: free[f"{name}_d"] for name in ("theta1", "theta2")}
    N = tuple(
        tuple(m.along(rates) - 2 * c for m, c in zip(*rows, strict=True))
        for rows in zip(free["M"], free["C"], strict=True)
    )
    return free | {"h": h, "H21": free["H12"], "v": free["c"], "theta_dd": free["qdd"], "N": N}


def as_defined():
    """The quantities that (3.22)–(3.27) define, without the others of the arm."""
    free = closed_form()
    known = (
        "M",
        "H11",
        "H12",
        "H22",
        "h",
        "v",
        "G",
        "G1",
        "G2",
        "tau",
        "tau1",
        "tau2",
        "theta1_d",
        "theta2_d",
        "N",
    )
    return Quantities({name: free[name] for name in known}, free.layout)


def numbers():
    arm = fb.load("2R")
    q, qd, tau = [0.4, 0.9], [1.2, -0.7], np.array([3.0, -1.0])
    return {
        "theta_dd": fb.forward_dynamics(arm, q, qd, tau), "M": fb.mass_matrix(arm, q), "tau": tau,
        "v": fb.coriolis_matrix(arm, q, qd) @ qd, "G": fb.gravity_torque(arm, q),
    }  # fmt: skip


def unit_rods(printed: str) -> Outcome:
    """Outcome of checking the mass matrix, with its eigenvalues for two stretched uniform rods of 1
    m and 1 kg."""
    outcome = Answer(ARM).run(printed)
    rods = {
        f"{letter}{i}": x
        for i in (1, 2)
        for letter, x in (("m", 1), ("l", 1), ("lc", 0.5), ("I", 1 / 12))
    }
    sides = dict(part.split("=") for part in parts(printed))
    H11, H12, H22 = (
        value(parse(sides[f"H{ij} "]), rods | {"theta2": 0.0}) for ij in ("11", "12", "22")
    )
    eigenvalues = np.linalg.eigvalsh(np.array([[H11, H12], [H12, H22]], dtype=float))
    line = (
        "For two rods of 1 m and 1 kg, stretched, this M has the eigenvalues "
        f"{number(eigenvalues, 4)} kg m²."
    )
    return Outcome(
        outcome.holds and bool(eigenvalues[0] > 0), (line, *outcome.lines), outcome.example
    )


UNIT_RODS = ByFunction(
    unit_rods, calls='fb.check(fb.planar("RR"), "H11 = …"); np.linalg.eigvalsh(M)'
)

CHECKS = {
    "unit_rods": UNIT_RODS,
    "closed_form": Related(closed_form),
    "as_defined": Related(as_defined),
    "numbers": Related(numbers),
}
