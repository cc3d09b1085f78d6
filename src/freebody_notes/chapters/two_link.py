"""Section 3.3: Newton and Euler for the arm of two links, to the closed form (3.10-3.29)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.formula import parse
from freebody.derivations.quantities import Quantities
from freebody.derivations.values import value
from freebody_notes.checks import ARM, Answer, Related, Run, number, parts
from freebody_notes.item import Item, Outcome


def closed_form():
    """The arm's equations sorted; h is what stands with θ̇₁² in τ₂. The notes define no H21."""
    free = fb.quantities(fb.planar("RR"))
    h = free["c"][1] / free["theta1_d"] ** 2
    rates = {name: free[f"{name}_d"] for name in ("theta1", "theta2")}
    N = tuple(
        tuple(m.along(rates) - 2 * c for m, c in zip(*rows, strict=True))
        for rows in zip(free["M"], free["C"], strict=True)
    )
    return free | {"h": h, "H21": free["H12"], "v": free["c"], "theta_dd": free["qdd"], "N": N}


def as_defined():
    """Only what (3.22)–(3.27) define."""
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
    """The mass matrix of the form as an answer; and its eigenvalues for two uniform rods of 1 m and
    1 kg, stretched."""
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
    line = f"For two rods of 1 m and 1 kg, stretched, this M has the eigenvalues {number(eigenvalues, 4)}."
    return Outcome(
        outcome.holds and bool(eigenvalues[0] > 0), (line, *outcome.lines), outcome.example
    )


FREE, FORM, DEFINED = Related(f"fb.quantities({ARM})"), Related(closed_form), Related(as_defined)

MATRIX = 'fb.check(fb.planar("RR"), "H11 = …"); np.linalg.eigvalsh(M)'
H11 = "H11 = m1*lc1^2 + I1 + {}m2*(l1^2 + lc2^2 + 2*l1*lc2*cos(theta2)) + I2"
PRINTED_M = (
    f"{H11.format('I2 + ')}; H22 = m1*lc2^2 + I2; H12 = m2*(lc2^2 + 2*l1*lc2*cos(theta2)) + I2"
)
RIGHT_M = f"{H11.format('')}; H22 = m2*lc2^2 + I2; H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2"
_REST = (
    "tau = [tau1, tau2]; v = [-h*theta2_d^2 - 2*h*theta1_d*theta2_d, h*theta1_d^2]; G = [G1, G2]"
)

ITEMS = (
    Item(
        "ex-3.2-2dof", "3.3", "Example: an arm of two links", "worked-example",
        "From the two free bodies to torques in closed form; its mass matrix.",
        PRINTED_M, Run(unit_rods, calls=MATRIX), "inconsistent", RIGHT_M,
        "Each of the three entries has a slip; with them the mass matrix is indefinite, so some motions would have a "
        "negative kinetic energy.",
        figure="3.2",
    ),
    Item(
        "eq-3.10", "3.3", "Forces on link 1", "derivation", "The base's force, link 2's, and the weight.",
        "f01 - f12 + m1*gravity = m1*vc1_d", FREE, figure="3.2",
    ),
    Item(
        "eq-3.11", "3.3", "Moments on link 1", "derivation", "About its centre of mass: both motors, both joint forces.",
        "tau1 - tau2 - cross(sc1, f01) + cross(s1 - sc1, -f12) = I1*omega1_d", FREE, figure="3.2",
    ),
    Item(
        "eq-3.12", "3.3", "Forces on link 2", "derivation", "Link 1's force and the weight.",
        "f12 + m2*gravity = m2*vc2_d", FREE, figure="3.2",
    ),
    Item(
        "eq-3.13", "3.3", "Moments on link 2", "derivation", "About its centre of mass.",
        "tau2 - cross(sc2, f12) = I2*omega2_d", FREE, figure="3.2",
    ),
    Item(
        "eq-3.14", "3.3", "Without the elbow's force", "derivation", "(3.12) put into (3.13).",
        "tau2 - cross(sc2, -m2*gravity + m2*vc2_d) = I2*omega2_d", FREE,
    ),
    Item(
        "eq-3.15", "3.3", "Without the base's force", "derivation", "(3.10) and (3.12) put into (3.11).",
        "tau1 - tau2 - cross(sc1, m1*vc1_d) - cross(s1, m2*vc2_d) + cross(sc1, m1*gravity) + cross(s1, m2*gravity) "
        "= I1*omega1_d", FREE,
    ),
    Item("eq-3.16", "3.3", "Rate of link 1", "definition", "The first angle is counted from the ground.", "omega1 = theta1_d", FREE),
    Item(
        "eq-3.17", "3.3", "Rate of link 2", "definition", "The second angle is counted from link 1, so the rates add up.",
        "omega2 = theta1_d + theta2_d", FREE,
    ),
    Item(
        "eq-3.18", "3.3", "Velocity of C₁", "derivation", "On a circle about the base's joint.",
        "vc1 = [-lc1*theta1_d*sin(theta1), lc1*theta1_d*cos(theta1)]", FREE,
    ),
    Item(
        "eq-3.19", "3.3", "Velocity of C₂", "derivation", "That of the elbow, and that of C₂ about the elbow.",
        "vc2 = [-l1*theta1_d*sin(theta1) - (theta1_d+theta2_d)*lc2*sin(theta1+theta2), "
        "l1*theta1_d*cos(theta1) + (theta1_d+theta2_d)*lc2*cos(theta1+theta2)]", FREE,
    ),
    Item(
        "eq-3.20", "3.3", "First torque", "derivation", "Sorted by accelerations, products of rates, and gravity.",
        "tau1 = H11*theta1_dd + H12*theta2_dd - h*theta2_d^2 - 2*h*theta1_d*theta2_d + G1", FORM,
    ),
    Item(
        "eq-3.21", "3.3", "Second torque", "derivation", "Sorted in the same way.",
        "tau2 = H21*theta1_dd + H22*theta2_dd + h*theta1_d^2 + G2", FORM,
    ),
    Item(
        "eq-3.22", "3.3", "H₁₁", "derivation", "Inertia that the first motor feels: of the whole arm about the base's joint.",
        H11.format("I2 + "), Answer(ARM), "misprint", H11.format(""),
        "I₂ is counted twice: once too often in front of the bracket.",
    ),
    Item(
        "eq-3.23", "3.3", "H₂₂", "derivation", "Inertia of the second link about the elbow.",
        "H22 = m1*lc2^2 + I2", Answer(ARM), "misprint", "H22 = m2*lc2^2 + I2",
        "It is the inertia of link 2 about the elbow, so the mass is m₂.",
    ),
    Item(
        "eq-3.24", "3.3", "H₁₂", "derivation", "What an acceleration of one joint asks of the other.",
        "H12 = m2*(lc2^2 + 2*l1*lc2*cos(theta2)) + I2", Answer(ARM), "misprint",
        "H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2",
        "The factor 2 belongs to H₁₁ only.",
    ),
    Item(
        "eq-3.25", "3.3", "h", "derivation", "The coefficient of all velocity terms.",
        "h = m2*l1*lc2*sin(theta2))", Answer(ARM), "misprint", "h = m2*l1*lc2*sin(theta2)",
        "A closing bracket that nothing opens; the value is right.",
    ),
    Item(
        "eq-3.26", "3.3", "G₁", "derivation", "Gravity at the first joint.",
        "G1 = m1*g*lc1*cos(theta1) + m2*g*(l1*cos(theta1) + lc2*cos(theta1+theta2))", Answer(ARM),
    ),
    Item(
        "eq-3.27", "3.3", "G₂", "derivation", "Gravity at the second joint.", "G2 = m2*g*lc2*cos(theta1+theta2)", Answer(ARM),
    ),
    Item(
        "eq-3.28", "3.3", "As matrices", "derivation", "Mass matrix times accelerations, velocity terms, gravity.",
        "tau = M*theta_dd + v + G", FORM,
    ),
    Item(
        "uf-3.28-matrices", "3.3", "What the matrices hold", "definition",
        "The entries of τ, M, v and G of (3.28).",
        f"M = [[H11, H12], [H21, H22]]; {_REST}", DEFINED, "incomplete",
        f"M = [[H11, H12], [H12, H22]]; {_REST}; N = -transpose(N)",
        "H₂₁ is used here and in (3.21) but never defined: H₂₁ = H₁₂, as M is symmetric. With Christoffel's matrix C, "
        "N = Ṁ − 2C is skew-symmetric.",
    ),
    Item(
        "eq-3.29", "3.3", "Forward dynamics", "derivation", "(3.28) solved for the accelerations; here in numbers.",
        "theta_dd = M^-1*(tau - (v + G))", Related(numbers),
    ),
)  # fmt: skip
