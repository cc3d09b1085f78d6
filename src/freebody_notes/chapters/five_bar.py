"""Section 2.3: the five-bar parallel robot (2.27-2.40)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.textbook_form import Layout
from freebody_notes.checks import Related
from freebody_textbook.relations.quantities import Quantities

CRANKS = (2.0, 0.9)
"""θ₁ and θ₂, counted from x (rad)."""


def robot():
    """The bundled five-bar robot with limbs of different lengths, P being held by rods as in
    section 2.3, closed at the crank angles CRANKS."""
    model = fb.load("five_bar_rods").bind(l2=0.45, l3=0.62, l4=0.55)
    start = {"theta1": CRANKS[0], "theta2": CRANKS[1], "x": 0.0, "y": 0.8}
    return model, fb.assemble(model, start, free=["x", "y"])


def limbs():
    """Both limbs of the five-bar robot in symbols, from the model's loop equations: A at (−d/2, 0),
    C at (d/2, 0) as in figure 2.2."""
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
    """A closed pose of the five-bar robot for the given crank angles, in which the rods have their
    lengths; A and C are b = d/2 from the middle."""
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
    """The five-bar robot in motion: rates that keep the loops closed, its numeric Jacobian J, and
    J_a and J_b from closed forms."""
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


CHECKS = {
    "limbs": Related(limbs),
    "closed_pose": Related(closed_pose),
    "moving": Related(moving),
}
