"""Section 2.3: the parallel robot with five bars (2.27-2.40)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.forms import Layout
from freebody.derivations.kinematics import Kinematics
from freebody.derivations.quantities import Quantities
from freebody_notes.checks import Related
from freebody_notes.item import Item

CRANKS = (2.0, 0.9)
"""θ₁ and θ₂, counted from x (rad)."""


def robot():
    """The bundled robot as section 2.3 writes it, P held by rods, with limbs of different lengths;
    closed at CRANKS."""
    model = fb.load("five_bar_rods").bind(l2=0.45, l3=0.62, l4=0.55)
    start = {"theta1": CRANKS[0], "theta2": CRANKS[1], "x": 0.0, "y": 0.8}
    return model, fb.assemble(model, start, free=["x", "y"])


def limbs():
    """Both limbs in symbols, from the model's loop equations: A at (−d/2, 0), C at (d/2, 0) as in
    figure 2.2."""
    loops = fb.loop_equations(fb.load("five_bar_rods"))
    symbols = loops.symbols
    known = {name: symbols.ring[name] for name in symbols.ring.names}
    b, zero = known["b"], symbols.zero()
    places = {"A": (-b, zero), "C": (b, zero), "P": (known["x"], known["y"])}
    places |= {name: tuple(Kinematics(symbols, name).position) for name in "BD"}
    arms = {
        p + q: tuple(y - x for x, y in zip(places[p], places[q], strict=True))
        for p, q in ("AB", "CD", "AP", "CP")
    }
    J_a, J_b = loops.J_a(), loops.J_b()
    more = {
        "d": 2 * b,
        "Phi": tuple(loops.Phi),
        "J_a": J_a,
        "J_b": J_b,
        "j_b1": J_b[0][0],
        "j_b2": J_b[1][1],
    }
    return Quantities(known | arms | more, Layout(symbols))


def closed_pose():
    """A pose in which the rods have their lengths, found from the cranks' angles; A and C are b =
    d/2 from the middle."""
    model, q = robot()
    lengths = model.parameters
    A, C, P = np.array([-lengths["b"], 0.0]), np.array([lengths["b"], 0.0]), q[2:]
    B, D = (fb.forward_kinematics(model, q, name)[:2, 2] for name in "BD")
    arms = {"AB": B - A, "CD": D - C, "AP": P - A, "CP": P - C}
    known = {name: lengths[name] for name in ("l1", "l2", "l3", "l4")}
    return (
        known | arms | {"d": 2 * lengths["b"], "theta1": q[0], "theta2": q[1], "x": q[2], "y": q[3]}
    )


def moving():
    """The same in motion: rates that keep the loops closed, the Jacobian from numbers, J_a and J_b
    from closed forms."""
    model, q = robot()
    rates = fb.loop_velocity(model, q, {"theta1": 0.7, "theta2": -1.2})
    loops = fb.loop_equations(model)
    J_a, J_b = (loops.symbols.evaluate(x, q) for x in (loops.J_a(), loops.J_b()))
    return {
        "J": fb.input_output(model, q).J,
        "J_a": J_a,
        "J_b": J_b,
        "theta_d": rates[:2],
        "x_d": rates[2:],
    }


LIMBS, POSE, MOVING = Related(limbs), Related(closed_pose), Related(moving)
_SIGN = "By figure 2.2, (2.29) and (2.31) A is at −d/2 and C at +d/2; the printed sign of d exchanges them."
_HALF = "In the numbers b is d/2."

ITEMS = (
    Item(
        "eq-2.27", "2.3", "Right limb", "definition", "The bar DP keeps its length.", "CP - CD = l4", POSE, "inconsistent",
        "norm(CP - CD) = l4", "The left side is a vector, the right side a length: the length of CP − CD is meant.", figure="2.2",
    ),
    Item(
        "eq-2.28", "2.3", "Left limb", "definition", "The bar BP keeps its length.", "AP - AB = l3", POSE, "inconsistent",
        "norm(AP - AB) = l3", "As (2.27): a vector on the left, a length on the right.", figure="2.2",
    ),
    Item("eq-2.29", "2.3", "From C to P", "definition", "C is at half the base on the right.", "CP = [x - d/2, y]", LIMBS, figure="2.2"),
    Item(
        "eq-2.30", "2.3", "From C to D", "definition", "The right crank.", "CD = [l3*cos(theta2), l3*sin(theta2)]", LIMBS, "misprint",
        "CD = [l2*cos(theta2), l2*sin(theta2)]", "The crank CD has the length l₂; l₃ is the bar BP.", figure="2.2",
    ),
    Item("eq-2.31", "2.3", "From A to P", "definition", "A is at half the base on the left.", "AP = [x + d/2, y]", LIMBS, figure="2.2"),
    Item("eq-2.32", "2.3", "From A to B", "definition", "The left crank.", "AB = [l1*cos(theta1), l1*sin(theta1)]", LIMBS, figure="2.2"),
    Item(
        "eq-2.33", "2.3", "Left limb squared", "derivation", "(2.28) squared; here at a pose in which the bars meet.",
        "(d/2 + l1*cos(theta1) - x)^2 + (l1*sin(theta1) - y)^2 - l3^2 = 0", POSE, "inconsistent",
        "(-d/2 + l1*cos(theta1) - x)^2 + (l1*sin(theta1) - y)^2 - l3^2 = 0", _SIGN,
    ),
    Item(
        "eq-2.34", "2.3", "Right limb squared", "derivation", "(2.27) squared; here at a pose in which the bars meet.",
        "(-d/2 + l2*cos(theta2) - x)^2 + (l2*sin(theta2) - y)^2 - l4^2 = 0", POSE, "inconsistent",
        "(d/2 + l2*cos(theta2) - x)^2 + (l2*sin(theta2) - y)^2 - l4^2 = 0", _SIGN,
    ),
    Item(
        "eq-2.35", "2.3", "Velocities", "derivation", "Both constraints differentiated.", "J_a*x_d + J_b*theta_d = 0", MOVING,
    ),
    Item("eq-2.36", "2.3", "The robot's Jacobian", "derivation", "(2.35) solved for the velocity of P.", "J = -J_a^-1*J_b", MOVING),
    Item(
        "eq-2.37", "2.3", "J_a", "derivation", "Derivatives of the constraints by x and y.",
        "J_a = [[-d - 2*l1*cos(theta1) + 2*x, -2*l1*sin(theta1) + 2*y], [d - 2*l2*cos(theta2) + 2*x, -2*l2*sin(theta2) + 2*y]]", LIMBS,
        "inconsistent",
        "J_a = [[d - 2*l1*cos(theta1) + 2*x, -2*l1*sin(theta1) + 2*y], [-d - 2*l2*cos(theta2) + 2*x, -2*l2*sin(theta2) + 2*y]]",
        f"{_SIGN} {_HALF} (It fits the printed (2.33) and (2.34), which have the same fault.)",
    ),
    Item(
        "eq-2.38", "2.3", "J_b", "derivation", "Each crank moves its own limb only.", "J_b = [[j_b1, 0], [0, j_b2]]", LIMBS,
    ),
    Item(
        "eq-2.39", "2.3", "First entry of J_b", "derivation", "Derivative of the left limb's constraint by θ₁.",
        "j_b1 = -l1*sin(theta1)*d + 2*l1*sin(theta1)*x - 2*l1*cos(theta1)*y", LIMBS, "inconsistent",
        "j_b1 = l1*sin(theta1)*d + 2*l1*sin(theta1)*x - 2*l1*cos(theta1)*y", f"{_SIGN} {_HALF}",
    ),
    Item(
        "eq-2.40", "2.3", "Second entry of J_b", "derivation", "Derivative of the right limb's constraint by θ₂.",
        "j_b2 = l2*sin(theta2)*d + 2*l2*sin(theta2)*x - 2*l2*cos(theta2)*y", LIMBS, "inconsistent",
        "j_b2 = -l2*sin(theta2)*d + 2*l2*sin(theta2)*x - 2*l2*cos(theta2)*y", f"{_SIGN} {_HALF}",
    ),
)  # fmt: skip
