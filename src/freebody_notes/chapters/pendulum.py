"""Section 3.1 and 3.2: the laws again, and the arm of one link (3.1-3.9)."""

from __future__ import annotations

import freebody as fb
from freebody_notes.chapters.planar_body import thrown_body
from freebody_notes.checks import Related
from freebody_notes.item import Item


def pendulum():
    """A bar of length l = 2 r on a hinge A, with its centre of mass C in the middle."""
    bar = fb.planar("R", lc=["r"], m=["m"], I=["I_c"], l=["l"])
    free = fb.quantities(bar)
    meaning = {
        "theta": "theta1", "theta_d": "theta1_d", "theta_dd": "theta1_dd", "omega": "omega1", "omega_d": "omega1_d",
        "tau": "tau1", "v_c": "vc1", "v_c_d": "vc1_d", "r_c": "sc1",
    }  # fmt: skip
    m, I_c, r = free["m"], free["I_c"], fb.quantities(bar)["theta1"].ring["r"]
    named = {new: free[old] for new, old in meaning.items()}
    return (
        free | named | {"r": r, "l": r * 2, "I_A": I_c + m * r * r, "I_o": I_c + m * r * r, "m": m}
    )


def bodies():
    """How many coordinates a body has, free, on a pin, and on slides; and what a pin transmits."""
    pinned = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1])
    return {
        "n_free": fb.planar("PPR").nv, "n_pin": pinned.nv, "n_slides": fb.planar("PP").nv,
        "n_all": fb.joint_wrenches(pinned, [0.3], [1.0], [2.0]).size,
    }  # fmt: skip


BODY, BAR = Related(thrown_body), Related(pendulum)

ITEMS = (
    Item("eq-3.1", "3.1", "Newton", "identity", "As (1.21).", "sum(F_i) = m*a_G", BODY),
    Item("eq-3.2", "3.1", "Euler", "identity", "As (1.22).", "sum(cross(rho_i, F_i)) = I_G*alpha", BODY),
    Item(
        "uf-3.1-equation-count", "3.1", "How many equations", "definition",
        "A body in the plane has three; on a pin one is enough, on slides two; with the reactions again all three.",
        "n_free = 3; n_pin = 1; n_slides = 2; n_all = 3", Related(bodies),
    ),
    Item(
        "ex-3.1-pendulum", "3.2", "Example 1: an arm of one link", "worked-example",
        "The equation of motion on two ways: by moments about the hinge, and by forces and moments about the centre of mass.",
        "tau = I_A*omega_d - 1/2*m*g*l*cos(theta); tau - cross(r_c, m*v_c_d - m*gravity) = I_c*omega_d", BAR,
        "inconsistent",
        "tau = I_A*omega_d + 1/2*m*g*l*cos(theta); tau - cross(r_c, m*v_c_d - m*gravity) = I_c*omega_d",
        "The two ways contradict each other by m g l cos θ. The second, (3.5)–(3.9), is right, and agrees with chapter 5.",
        figure="3.1",
    ),
    Item(
        "eq-3.3", "3.2", "Moments about the hinge", "derivation", "The motor and the weight turn the bar about A.",
        "tau + m*g*l/2*cos(theta) = I_A*omega_d", BAR, "misprint", "tau - m*g*l/2*cos(theta) = I_A*omega_d",
        "The weight's moment about A is r_c × (0, −m g) = −m g (l/2) cos θ.", figure="3.1",
    ),
    Item(
        "eq-3.4", "3.2", "The torque", "derivation", "(3.3) solved for the torque.",
        "tau = I_A*omega_d - 1/2*m*g*l*cos(theta)", BAR, "misprint", "tau = I_A*omega_d + 1/2*m*g*l*cos(theta)",
        "The sign of (3.3) is carried along: a motor has to hold the weight up, not to be helped by it.",
    ),
    Item(
        "eq-3.5", "3.2", "Forces", "derivation", "The hinge's force and the weight accelerate the centre of mass.",
        "f01 + m*gravity = m*v_c_d", BAR, figure="3.1",
    ),
    Item(
        "eq-3.6", "3.2", "Moments about the centre of mass", "derivation", "The motor, and the hinge's force at its arm −r_c.",
        "tau + cross(-r_c, f01) = I_c*omega_d", BAR, figure="3.1",
    ),
    Item(
        "eq-3.7", "3.2", "Without the hinge's force", "derivation", "(3.5) put into (3.6).",
        "tau - cross(r_c, m*v_c_d - m*gravity) = I_c*omega_d", BAR,
    ),
    Item(
        "eq-3.8", "3.2", "Velocity of the centre of mass", "derivation", "It moves on a circle about the hinge.",
        "v_c = [-r*omega*sin(theta), r*omega*cos(theta)]", BAR, figure="3.1",
    ),
    Item(
        "eq-3.9", "3.2", "Acceleration of the centre of mass", "derivation", "Along the circle, and towards its centre.",
        "v_c_d = [-r*omega_d*sin(theta), r*omega_d*cos(theta)] + [-r*omega^2*cos(theta), -r*omega^2*sin(theta)]", BAR,
    ),
    Item(
        "uf-3.9-r-omega", "3.2", "r and ω", "definition", "r is half the length, ω the rate of the angle.",
        "r = l/2; omega = theta_d; dot(r_c, r_c) = r^2", BAR,
    ),
)  # fmt: skip
