"""Section 2.4: statics of the arm of two links (2.41-2.52)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import Digits, Related
from freebody_notes.item import Item


def resting_arm():
    """Links without weight, and a force f = (u, v) on the tip; f1 is the base's force on link 1, f2
    link 1's on link 2."""
    arm = fb.planar("RR", g=[0, 0])
    free = fb.quantities(arm, load=True, at_rest=True)
    u, v = free["f"]
    return free | {"f1": free["f01"], "f2": free["f12"], "u": u, "v": v}


def loaded_arm():
    """The example: l = 3.5 m and 3 m, both angles 30°, a force on the tip."""
    arm = fb.planar("RR", l=[3.5, 3], lc=[0, 0], m=[0, 0], I=[0, 0])
    q, f = np.array([np.pi / 6, np.pi / 6]), np.array([-4.5, -3.0])
    tau = fb.static_torque(arm, q, wrenches={"tip": [*f, 0]})
    return {"f": f, "tau": tau, "J": fb.jacobian(arm, q)[:2], "f_e": fb.tip_wrench(arm, q, tau)[:2]}


def planar_product():
    a, b = (0.3, -1.2), (2.1, 0.7)
    return {"a": a, "b": b, "A": (*a, 0.0), "B": (*b, 0.0), "z": (0.0, 0.0, 1.0)}


REST, EXAMPLE = Related(resting_arm), Digits(loaded_arm)
_F = "By the free bodies of figure 2.3 f acts on the arm, and the torques that hold it are −Jᵀ f, as (2.45)–(2.48) say. Jᵀ f is the torque for the arm to exert f on its surroundings."

ITEMS = (
    Item(
        "eq-2.41", "2.4", "Forces on link 1", "derivation",
        "The base's force on link 1, and link 2's on it, cancel.", "f1 - f2 = 0", REST, figure="2.3",
    ),
    Item(
        "eq-2.42", "2.4", "Moments on link 1", "derivation",
        "About the base's joint: both motors and the force at the elbow.",
        "tau1 - tau2 + cross(s1, -f2) = 0", REST, figure="2.3",
    ),
    Item(
        "eq-2.43", "2.4", "Forces on link 2", "derivation",
        "The load and the force at the elbow cancel.", "f + f2 = 0", REST, figure="2.3",
    ),
    Item(
        "eq-2.44", "2.4", "Moments on link 2", "derivation", "About the elbow.",
        "tau2 + cross(s2, f) = 0", REST, figure="2.3",
    ),
    Item(
        "uf-2.44-planar-cross", "2.4", "Cross product in the plane", "definition",
        "Of two vectors in the plane the cross product has one entry that is not zero; it is taken for the product.",
        "cross(a, b) = dot(z, cross(A, B))", Related(planar_product),
    ),
    Item(
        "eq-2.45", "2.4", "Torque at the elbow", "derivation", "(2.44) solved.", "tau2 = -cross(s2, f)", REST,
    ),
    Item(
        "eq-2.46", "2.4", "Torque at the base", "derivation", "Put into (2.42).", "tau1 = -cross(s1 + s2, f)", REST,
    ),
    Item(
        "eq-2.47", "2.4", "Torque at the base, written out", "derivation",
        "With f = (u, v); the notes do not introduce u and v.",
        "tau1 = -(l1*cos(theta1) + l2*cos(theta1+theta2))*v + (l1*sin(theta1) + l2*sin(theta1+theta2))*u", REST,
    ),
    Item(
        "eq-2.48", "2.4", "Torque at the elbow, written out", "derivation", "With f = (u, v).",
        "tau2 = -l2*cos(theta1+theta2)*v + l2*sin(theta1+theta2)*u", REST,
    ),
    Item(
        "eq-2.49", "2.4", "As a matrix", "derivation", "Both torques as a linear map of the load.",
        "tau = [[-l1*sin(theta1) - l2*sin(theta1+theta2), l1*cos(theta1) + l2*cos(theta1+theta2)], "
        "[-l2*sin(theta1+theta2), l2*cos(theta1+theta2)]]*f", REST, "inconsistent",
        "tau = [[l1*sin(theta1) + l2*sin(theta1+theta2), -(l1*cos(theta1) + l2*cos(theta1+theta2))], "
        "[l2*sin(theta1+theta2), -l2*cos(theta1+theta2)]]*f",
        "The signs are those of Jᵀ, opposite to (2.47) and (2.48), from which the matrix is read off.",
    ),
    Item(
        "eq-2.50", "2.4", "Statics by the Jacobian", "identity", "The matrix is a transposed Jacobian.",
        "tau = transpose(J)*f", REST, "inconsistent", "tau = -transpose(J)*f", _F,
    ),
    Item(
        "eq-2.51", "2.4", "Force from torques", "identity",
        "Which force at the tip belongs to given torques.",
        "f = transpose(J)^-1*tau", Related(loaded_arm), "inconsistent",
        "f_e = transpose(J)^-1*tau; f = -transpose(J)^-1*tau",
        "J⁻ᵀ τ is the force f_e that the arm exerts on its surroundings; the f of figure 2.3 is its opposite.",
    ),
    Item(
        "ex-2.4-statics", "2.4", "Example: a force on the tip", "worked-example",
        "The torques that keep an arm with links of 3.5 m and 3 m, both angles 30°, in equilibrium under f = (−4.5, −3) N.",
        "tau = [5.97, 7.19]", EXAMPLE, "inconsistent", "tau = [-5.9731, -7.1913]",
        "The numbers are those of Jᵀ f. The torques that hold the arm against f have the other sign. " + _F,
        figure="2.3",
    ),
    Item(
        "eq-2.52", "2.4", "Its result", "worked-example", "The torques in N m.",
        "tau = [5.97, 7.19]", EXAMPLE, "inconsistent", "tau = [-5.9731, -7.1913]",
        "The arithmetic of Jᵀ f is right; held against (2.45)–(2.48) the sign is wrong. " + _F,
    ),
)  # fmt: skip
