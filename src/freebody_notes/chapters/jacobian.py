"""Section 2.1 and 2.2: Jacobians, and the kinematics of the arm of two links (2.1-2.26)."""

from __future__ import annotations

import re

import numpy as np

import freebody as fb
from freebody_notes.checks import ByFunction, Related, number
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import Outcome, parts
from freebody_textbook.relations.formula import parse
from freebody_textbook.relations.formula_values import value


def a_map():
    """Three functions of three variables, and their partial derivatives by finite differences."""
    rows = ("x1*x2", "sin(x3) + x1", "x1^2 + x3^3")
    f = fb.vector_function(rows, ["x1", "x2", "x3"])
    x, h = np.array([0.7, -1.3, 0.4]), 1e-3
    steps = h * np.eye(3)
    slopes = (8 * (f(x + steps) - f(x - steps)) - (f(x + 2 * steps) - f(x - 2 * steps))) / (12 * h)
    y = f(x)
    return {
        "x1": x[0], "x2": x[1], "x3": x[2], "y": y, "y1": y[0], "y2": y[1], "y3": y[2],
        "J": f.jacobian_at(x), "J_differences": slopes.T,
    }  # fmt: skip


def two_angles():
    """The tip's position and Jacobian of a two-link arm whose two angles are both measured from the
    x axis."""
    f = fb.vector_function(
        ["3*cos(theta1) + 2*cos(theta2)", "3*sin(theta1) + 2*sin(theta2)"], ["theta1", "theta2"]
    )
    theta1, theta2 = f.symbols
    x, y = f.rows
    return {"theta1": theta1, "theta2": theta2, "x": x, "y": y, "J": f.jacobian}


def poses(count: int = 2000):
    """Random poses of a two-link arm, and the position of its tip at each."""
    arm = fb.load("2R")
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (count, 2))
    tip = fb.forward_kinematics(arm, q)[:, :2, 2]
    return arm, q, tip


def recovered(printed: str, angle: int) -> tuple[int, int]:
    """(hits, count): the number of random poses at which a formula returns the pose's joint angle
    from the tip's position; formulas with several branches count if one does."""
    arm, q, tip = poses()
    lengths = {"l1": arm.parameters["l1"], "l2": arm.parameters["l2"]}
    forms = [parse(part.partition("=")[2]) for part in parts(printed)]
    hits = 0
    for row, (x, y) in zip(q, tip, strict=True):
        at = lengths | {"x": x, "y": y, "theta2": row[1]}
        found = np.array([value(form, at) for form in forms], dtype=float)
        hits += bool(np.any(np.abs(np.angle(np.exp(1j * (found - row[angle])))) < 1e-6))
    return hits, len(q)


def elbow(printed: str) -> Outcome:
    """Outcome of checking a formula for θ₂ from the position of the tip."""
    hits, count = recovered(printed, 1)
    arm, q, tip = poses(1)
    both = fb.inverse_kinematics(arm, tip[0])
    far = fb.inverse_kinematics(arm, [5.0, 0.0])
    lines = (
        f"In {hits} of {count} random poses the formula returns θ₂ of the pose.",
        f"fb.inverse_kinematics at the tip of q = {number(q[0])}: {_branches(both)}.",
        f"At [5, 0]: {' '.join(far.notes)}",
    )
    return Outcome(hits == count, lines)


def shoulder(printed: str) -> Outcome:
    """Outcome of checking a formula for θ₁ from the position of the tip and θ₂."""
    hits, count = recovered(printed, 0)
    _, q, _ = poses()
    ahead = int(np.sum(np.cos(q[:, 0]) > 0))
    line = (
        f"In {hits} of {count} random poses the formula returns θ₁ of the pose; "
        f"cos θ₁ > 0 in {ahead}."
    )
    return Outcome(hits == count, (line,))


def _branches(found) -> str:
    return "; ".join(
        f"{name}: {number(row)}" for name, row in zip(found.branches, found.q, strict=True)
    )


def inverse_rates():
    arm = fb.load("2R")
    q, qd, qdd = np.array([0.4, 0.9]), np.array([1.2, -0.7]), np.array([2.0, 1.5])
    r_d = fb.velocity(arm, q, qd)[:2]
    r_dd = fb.acceleration(arm, q, qd, qdd)[:2]
    return {
        "qd": fb.inverse_velocity(arm, q, r_d), "qdd": fb.inverse_acceleration(arm, q, qd, r_dd),
        "r_d": r_d, "r_dd": r_dd, "J": fb.jacobian(arm, q)[:2],
        "J_d": fb.jacobian_dot(arm, q, qd)[:2],
    }  # fmt: skip


def stretched():
    """The Jacobian and the singularity measure of the two-link arm when folded, θ₂ = π."""
    arm = fb.load("2R")
    q = [0.7, np.pi]
    return {"J": fb.jacobian(arm, q)[:2], "sigma": fb.singularities(arm).measure(q)}


def where_singular(printed: str) -> Outcome:
    """Outcome of checking singular configurations: solves for the zeros of the determinant's
    factors."""
    found = fb.singularities(fb.planar("RR"))
    solutions = {equation for condition in found.conditions for equation in condition.solutions}
    said = {parse(part) for part in parts(printed)}
    return Outcome(
        said == solutions, (f"det J = {found.determinant}; singular where {found.conditions[0]}.",)
    )


def which_figure(form: str) -> Outcome:
    """Whether the figure that the text names has the vectors s_1, s_2 and r."""
    number = re.findall(r"\d\.\d", form)[0]
    there = {
        element.name for drawing in notes_figure(number).drawings for element in drawing.elements
    }
    missing = {"s_1", "s_2", "r"} - there
    words = f"has no {', '.join(sorted(missing))}" if missing else "has s_1, s_2 and r"
    return Outcome(not missing, (f"Figure {number} {words}.",))


CHECKS = {
    "a_map": Related(a_map),
    "two_angles": Related(two_angles),
    "elbow": ByFunction(
        elbow,
        calls='fb.inverse_kinematics(fb.load("2R"), [x, y])  # at the tips of random poses',
    ),
    "shoulder": ByFunction(
        shoulder,
        calls='fb.forward_kinematics(fb.load("2R"), q)[:2, 2]  '
        "# at random poses; the formula has to give q back",
    ),
    "which_figure": ByFunction(which_figure, calls='fb.notes_figure("2.1").named("s_1")'),
    "stretched": Related(stretched),
    "where_singular": ByFunction(where_singular, calls='print(fb.singularities(fb.planar("RR")))'),
    "inverse_rates": Related(inverse_rates),
}
