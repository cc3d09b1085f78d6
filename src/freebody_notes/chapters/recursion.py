"""Chapter 4: velocities by geometry, and the recursive method in the plane (4.1-4.15)."""

from __future__ import annotations

import re

import freebody as fb
from freebody_notes.checks import Related, Run
from freebody_notes.item import Item, Outcome


def two_links():
    """Figure 4.1: OB turns at ω₀, BA by θ̇ relative to it; s leads from B to A."""
    free = fb.quantities(fb.planar("RR"))
    meaning = {
        "omega0": "omega1", "omega0_d": "omega1_d", "omega": "omega2", "omega_d": "omega2_d", "theta_d": "theta2_d",
        "theta_dd": "theta2_dd", "v_B": "v2", "v_B_d": "v2_d", "v_A": "r_d", "v_A_d": "r_dd", "r_A": "r", "s": "s2",
    }  # fmt: skip
    return free | {new: free[old] for new, old in meaning.items()}


def as_vectors():
    """The same with ω and ω̇ as vectors along z."""
    free = two_links()
    z = (0.0, 0.0, 1.0)
    flat = free["omega"]
    vectors = {
        name: tuple(k * free[name] if k else flat * 0 + 0.0 for k in z)
        for name in ("omega", "omega_d")
    }
    return free | vectors | {"w": flat}


def which_are_vectors(printed: str) -> Outcome:
    """The printed numbers name equations; each side of those is looked at."""
    forms = {"4.1": "omega", "4.2": "omega_d", "4.3": "v_A", "4.5": "v_A_d"}
    free = two_links()
    lines, holds = [], True
    for equation in re.findall(r"4\.\d", printed):
        vector = isinstance(free[forms[equation]], tuple)
        holds = holds and vector
        lines.append(f"({equation}) is an equation between {'vectors' if vector else 'scalars'}.")
    return Outcome(holds, tuple(lines))


def with_weights(form: str) -> Outcome:
    """With v̇₀ = 0; and whether the form printed in the notes holds with v̇₀ = −g."""
    outcome = EXPLICIT.run(form)
    printed = {
        "f": "f_hi = fc_i + f_ik",
        "M": "M_i = Mc_i + M_k + cross(sc_i, fc_i) + cross(s_i, f_ik)",
    }[form[0]]
    accelerated = "holds" if BASE.run(printed).holds else "fails"
    line = f"Started with v̇₀ = −g instead of 0, the form without weights {accelerated}."
    return Outcome(outcome.holds, (*outcome.lines, line), outcome.example)


def loaded_start():
    """The recursion with the base accelerated by −g, and a force f on the tip."""
    return fb.quantities(fb.planar("RR"), load=True, gravity="base")


def both_ways():
    """The torques of the recursion, and of Lagrange's equations."""
    arm = fb.planar("RR")
    swept = fb.quantities(arm, gravity="base")
    return swept | {"tau_L": fb.derive(arm, "lagrange").tau}


VECTORIAL = ("f_hi", "fc_i", "f_ik", "sc_i", "s_i")
WEIGHTS = (
    'fb.relation(fb.quantities(fb.planar("RRR")), form)  # i = 1, 2, 3; and with gravity="base"'
)
THREE = 'fb.planar("RRR")'
TWO, VECTORS = Related(two_links), Related(as_vectors)
EXPLICIT = Related(f"fb.quantities({THREE})", links=(1, 2, 3))
BASE = Related(f'fb.quantities({THREE}, gravity="base")', links=(1, 2, 3))

ITEMS = (
    Item(
        "eq-4.1", "4.2.1", "Relative turning", "definition", "The rate of the second link is that of the first and its own.",
        "omega = omega0 + theta_d", TWO, figure="4.1",
    ),
    Item(
        "eq-4.2", "4.2.1", "Relative angular acceleration", "definition", "The same differentiated.",
        "omega_d = omega0_d + theta_dd", TWO, figure="4.1",
    ),
    Item(
        "eq-4.3", "4.2.2", "Velocity from point to point", "derivation", "Two points of one body differ in velocity by ω × s.",
        "v_A = v_B + cross(omega, s)", VECTORS, figure="4.1",
    ),
    Item(
        "eq-4.4", "4.2.2", "Angular velocity as a vector", "definition", "In the plane it points along z.",
        "omega = w*[0, , 0, 1]", VECTORS, "misprint", "omega = w*[0, 0, 1]",
        "z is printed with an empty entry; it is the unit vector [0, 0, 1].",
    ),
    Item(
        "uf-4.4-crossref", "4.2.2", "Which equations are vectorial", "definition",
        "Two equations are said to be between three-dimensional vectors.",
        "(4.2) and (4.3)", Run(which_are_vectors, calls='fb.quantities(fb.planar("RR"))["omega2_d"]  # a scalar'), "misprint", "(4.3) and (4.5)",
        "(4.2) is between the scalars of the plane; the vectorial ones are (4.3) and (4.5).",
    ),
    Item(
        "eq-4.5", "4.2.2", "Acceleration from point to point", "derivation",
        "Two points of one body differ in acceleration by what changes ω × s.",
        "v_A_d = v_B_d + cross(omega_d, s) + cross(omega, cross(omega, s))", VECTORS,
    ),
    Item(
        "ex-4.5-verify", "4.2.2", "Exercise: the same by algebra", "derivation",
        "The position of A differentiated twice by time, component by component, gives the right side of (4.5).",
        "d_dt(d_dt(r_A)) = v_B_d + cross(omega_d, s) + cross(omega, cross(omega, s))", VECTORS,
    ),
    Item(
        "alg-4.3-two-passes", "4.3", "Out and in", "algorithm",
        "Velocities and accelerations are carried from the base outwards, forces from the last link inwards; what comes out "
        "is what the closed form gives.",
        "tau = M*qdd + c + G", Related(f'fb.quantities({THREE}, gravity="base")'),
    ),
    Item("eq-4.6", "4.3.1", "Outward: ω", "algorithm", "Each joint adds its rate.", "omega_i = omega_h + theta_i_d", EXPLICIT, figure="4.2"),
    Item(
        "eq-4.7", "4.3.1", "Outward: velocity of the joint", "algorithm", "Joint i is a point of link i−1.",
        "v_i = v_h + cross(omega_h*z, s_h)", EXPLICIT, figure="4.2",
    ),
    Item(
        "eq-4.8", "4.3.1", "Outward: velocity of the centre", "algorithm", "The centre of mass is a point of link i.",
        "vc_i = v_i + cross(omega_i*z, sc_i)", EXPLICIT, figure="4.2",
    ),
    Item("eq-4.9", "4.3.1", "Outward: ω̇", "algorithm", "(4.6) differentiated.", "omega_i_d = omega_h_d + theta_i_dd", EXPLICIT),
    Item(
        "eq-4.10", "4.3.1", "Outward: acceleration of the joint", "algorithm", "(4.7) differentiated.",
        "v_i_d = v_h_d + cross(omega_h_d*z, s_h) + cross(omega_h*z, cross(omega_h*z, s_h))", EXPLICIT,
    ),
    Item(
        "eq-4.11", "4.3.1", "Outward: acceleration of the centre", "algorithm", "(4.8) differentiated.",
        "vc_i_d = v_i_d + cross(omega_i_d*z, sc_i) + cross(omega_i*z, cross(omega_i*z, sc_i)) = d_dt(vc_i)", EXPLICIT,
    ),
    Item("eq-4.12", "4.3.1", "Force of inertia", "definition", "What the forces on the body add up to.", "fc_i = m_i*vc_i_d", EXPLICIT),
    Item("eq-4.13", "4.3.1", "Moment of inertia", "definition", "What their moments add up to.", "Mc_i = I_i*omega_i_d", EXPLICIT),
    Item(
        "eq-4.14", "4.3.1", "Inward: joint force", "algorithm", "A joint carries what accelerates its link, and what the next one needs.",
        "f_hi = fc_i + f_ik", Run(with_weights, VECTORIAL, WEIGHTS), "incomplete", "f_hi = fc_i - m_i*gravity + f_ik",
        "Without the weights this is right only if the base is given the acceleration v̇₀ = −g, which the notes do not say; "
        "with v̇₀ = 0 the arm weighs nothing.",
        figure="4.2",
    ),
    Item(
        "eq-4.15", "4.3.1", "Inward: joint moment", "algorithm", "The same for moments about the joint.",
        "M_i = Mc_i + M_k + cross(sc_i, fc_i) + cross(s_i, f_ik)", Run(with_weights, VECTORIAL, WEIGHTS), "incomplete",
        "M_i = Mc_i + M_k + cross(sc_i, fc_i - m_i*gravity) + cross(s_i, f_ik)",
        "As (4.14): right with v̇₀ = −g; with v̇₀ = 0 exactly the gravity torques are missing. The motor's torque is M_i.",
        figure="4.2",
    ),
    Item(
        "uf-4.15-boundary", "4.3.1", "Where the sweeps start", "definition",
        "Values at the base and at the tip, which the notes do not give.",
        "", Related(loaded_start), "incomplete",
        "omega0 = 0; omega0_d = 0; v0 = 0; s0 = 0; v0_d = -gravity; f23 = -f; M3 = 0",
        "The base rests, ω₀ = ω̇₀ = 0, v₀ = 0, joint 1 at its origin, s₀ = 0; gravity enters by v̇₀ = −g. Behind the last "
        "link stands what it exerts on its surroundings, f₂₃ = −f for a force f on the tip.",
    ),
    Item(
        "ex-4.3-2dof", "4.3.1", "The arm of two links by recursion", "worked-example",
        "Out over both links and in again; the torques are those of Lagrange's equations.",
        "tau1 = M1; tau2 = M2; tau = tau_L", Related(both_ways), figure="4.3",
    ),
)  # fmt: skip
