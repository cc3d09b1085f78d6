"""Section 2.1 and 2.2: Jacobians, and the kinematics of the arm of two links (2.1-2.26)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.formula import parse
from freebody.derivations.values import value
from freebody_notes.checks import ARM, Related, Run, number, parts
from freebody_notes.item import Item, Outcome


def a_map():
    """Three functions of three variables, and their derivatives by differences."""
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
    """Both angles count from the x axis here."""
    f = fb.vector_function(
        ["3*cos(theta1) + 2*cos(theta2)", "3*sin(theta1) + 2*sin(theta2)"], ["theta1", "theta2"]
    )
    theta1, theta2 = f.symbols
    x, y = f.rows
    return {"theta1": theta1, "theta2": theta2, "x": x, "y": y, "J": f.jacobian}


def poses(count: int = 2000):
    """Random poses of an arm, and where its tip is."""
    arm = fb.load("2R")
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (count, 2))
    tip = fb.forward_kinematics(arm, q)[:, :2, 2]
    return arm, q, tip


def recovered(printed: str, angle: int) -> tuple[int, int]:
    """How often a formula for one angle, at the tip of a random pose, gives back that pose's angle;
    branches count."""
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
    """θ₂ from the tip."""
    hits, count = recovered(printed, 1)
    arm, q, tip = poses(1)
    both = fb.inverse_kinematics(arm, tip[0])
    far = fb.inverse_kinematics(arm, [5.0, 0.0])
    lines = (
        f"In {hits} of {count} random poses the formula gives back the θ₂ of the pose.",
        f"fb.inverse_kinematics at the tip of q = {number(q[0])}: {_branches(both)}.",
        f"At [5, 0]: {' '.join(far.notes)}",
    )
    return Outcome(hits == count, lines)


def shoulder(printed: str) -> Outcome:
    """θ₁ from the tip and θ₂."""
    hits, count = recovered(printed, 0)
    _, q, _ = poses()
    ahead = int(np.sum(np.cos(q[:, 0]) > 0))
    line = f"In {hits} of {count} random poses the formula gives back the θ₁ of the pose; cos θ₁ > 0 in {ahead}."
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
        "r_d": r_d, "r_dd": r_dd, "J": fb.jacobian(arm, q)[:2], "J_d": fb.jacobian_dot(arm, q, qd)[:2],
    }  # fmt: skip


def stretched():
    """The arm at a pose where fb.singularities says it is singular."""
    arm = fb.load("2R")
    q = [0.7, np.pi]
    return {"J": fb.jacobian(arm, q)[:2], "sigma": fb.singularities(arm).measure(q)}


def where_singular(printed: str) -> Outcome:
    """The factors of the determinant solved."""
    found = fb.singularities(fb.planar("RR"))
    solutions = {equation for condition in found.conditions for equation in condition.solutions}
    said = {parse(part) for part in parts(printed)}
    return Outcome(
        said == solutions, (f"det J = {found.determinant}; singular where {found.conditions[0]}.",)
    )


TIP = Related(f"fb.quantities({ARM})")
MAP, ANGLES, RATES = Related(a_map), Related(two_angles), Related(inverse_rates)


def _proved(also: str) -> Related:
    return Related(f"fb.quantities({ARM})", also=also)


_C = "(x^2 + y^2 - (l1^2 + l2^2))/(2*l1*l2)"
_ABOVE, _BELOW = (
    "-l2*sin(theta2)*x + (l1 + l2*cos(theta2))*y",
    "l2*sin(theta2)*y + (l1 + l2*cos(theta2))*x",
)

ITEMS = (
    Item(
        "eq-2.1", "2.1.1", "Vector function", "definition",
        "Several functions of several variables, written as one vector; here three of three.",
        "y = [x1*x2, sin(x3) + x1, x1^2 + x3^3]", MAP,
    ),
    Item("eq-2.2", "2.1.1", "First row", "definition", "The first function of the example.", "y1 = x1*x2", MAP),
    Item("eq-2.3", "2.1.1", "Second row", "definition", "The second function.", "y2 = sin(x3) + x1", MAP),
    Item(
        "eq-2.4", "2.1.1", "Rows between", "definition",
        "A row of dots that carries a number: all rows between the second and the last.", "y = [y1, y2, y3]", MAP,
    ),
    Item("eq-2.5", "2.1.1", "Last row", "definition", "The last function.", "y3 = x1^2 + x3^3", MAP),
    Item(
        "eq-2.6", "2.1.1", "Jacobian matrix", "definition",
        "Entry i, j of the Jacobian is the derivative of function i by variable j; here also found by differences.",
        "J = [[x2, x1, 0], [1, 0, cos(x3)], [2*x1, 0, 3*x3^2]]", Related(a_map, also="J = J_differences"),
    ),
    Item(
        "ex-2.1-jacobian", "2.1.1", "Example: two angles", "worked-example",
        "The Jacobian of a map of two angles, both counted from the x axis (unlike in 2.2, where θ₂ is relative).",
        "J = [[-3*sin(theta1), -2*sin(theta2)], [3*cos(theta1), 2*cos(theta2)]]", ANGLES,
    ),
    Item("eq-2.7", "2.1.1", "Given x", "worked-example", "The first function.", "x = 3*cos(theta1) + 2*cos(theta2)", ANGLES),
    Item("eq-2.8", "2.1.1", "Given y", "worked-example", "The second function.", "y = 3*sin(theta1) + 2*sin(theta2)", ANGLES),
    Item(
        "eq-2.9", "2.1.1", "Its Jacobian", "worked-example", "The derivatives by both angles.",
        "J = [[-3*sin(theta1), -2*sin(theta2)], [3*cos(theta1), 2*cos(theta2)]]", ANGLES,
    ),
    Item(
        "eq-2.10", "2.2.1", "Chain of vectors", "derivation", "The tip along both links.",
        "r = s1 + s2", TIP, figure="2.1",
    ),
    Item(
        "eq-2.11", "2.2.1", "Link by link", "derivation", "Each link by its length and its angle with x.",
        "[x, y] = [l1*cos(theta1), l1*sin(theta1)] + [l2*cos(theta1+theta2), l2*sin(theta1+theta2)]", TIP, figure="2.1",
    ),
    Item(
        "eq-2.12", "2.2.1", "x of the tip", "derivation", "The first component.",
        "x = l1*cos(theta1) + l2*cos(theta1+theta2)", TIP, figure="2.1",
    ),
    Item(
        "eq-2.13", "2.2.1", "y of the tip", "derivation", "The second component.",
        "y = l1*sin(theta1) + l2*sin(theta1+theta2)", TIP, figure="2.1",
    ),
    Item(
        "eq-2.14", "2.2.1", "The elbow's angle from the tip", "derivation",
        "The law of cosines gives cos θ₂.",
        f"theta2 = arccos({_C})", Run(elbow, calls='fb.inverse_kinematics(fb.load("2R"), [x, y])  # at the tips of random poses'), "incomplete",
        f"theta2 = arccos({_C}); theta2 = -arccos({_C})",
        "The arc cosine gives angles from 0 to π only: the arm with its elbow on the other side is lost. There are two "
        "branches, real for |l₁ − l₂| ≤ √(x² + y²) ≤ l₁ + l₂ only, and one where the arm is stretched or folded.",
    ),
    Item(
        "eq-2.15", "2.2.1", "The shoulder's angle from the tip", "derivation",
        "With θ₂ known, two linear equations in cos θ₁ and sin θ₁.",
        f"theta1 = arctan(({_ABOVE})/({_BELOW}))", Run(shoulder, calls='fb.forward_kinematics(fb.load("2R"), q)[:2, 2]  # at random poses; the formula has to give q back'), "incomplete",
        f"theta1 = atan2({_ABOVE}, {_BELOW})",
        "The signs are right, but the plain arc tangent loses the quadrant: it is off by π wherever cos θ₁ < 0. atan2 of "
        "numerator and denominator, once for each θ₂, is right except at x = y = 0, where θ₁ is free.",
    ),
    Item(
        "eq-2.16", "2.2.2", "Velocity of the tip, x", "derivation", "The position differentiated.",
        "x_d = -l1*theta1_d*sin(theta1) - l2*(theta1_d+theta2_d)*sin(theta1+theta2)", _proved("x_d = d_dt(x)"),
    ),
    Item(
        "eq-2.17", "2.2.2", "Velocity of the tip, y", "derivation", "The position differentiated.",
        "y_d = l1*theta1_d*cos(theta1) + l2*(theta1_d+theta2_d)*cos(theta1+theta2)", _proved("y_d = d_dt(y)"),
    ),
    Item(
        "eq-2.18", "2.2.2", "Velocity as a linear map", "derivation",
        "The velocity of the tip is the Jacobian times the joint rates.", "r_d = J*qd", TIP,
    ),
    Item(
        "eq-2.19", "2.2.2", "The arm's Jacobian", "derivation", "The derivatives of the tip's position by both angles.",
        "J = [[-l1*sin(theta1) - l2*sin(theta1+theta2), -l2*sin(theta1+theta2)], "
        "[l1*cos(theta1) + l2*cos(theta1+theta2), l2*cos(theta1+theta2)]]", TIP,
    ),
    Item(
        "eq-2.20", "2.2.3", "Singular", "definition",
        "Where the determinant of the Jacobian vanishes, the tip cannot move in every direction; so with the arm folded.",
        "det(J) = 0; sigma = 0", Related(stretched),
    ),
    Item(
        "eq-2.21", "2.2.3", "The determinant written out", "derivation", "Two products of entries.",
        "det(J) = -sin(theta1)*cos(theta1+theta2)*l1*l2 + sin(theta1+theta2)*cos(theta1)*l1*l2", TIP,
    ),
    Item(
        "eq-2.22", "2.2.3", "The determinant simplified", "derivation", "Sine of a difference of angles.",
        "det(J) = l1*l2*sin(theta2)", TIP,
    ),
    Item(
        "eq-2.23", "2.2.3", "Singular poses", "derivation", "The zeros of sin θ₂.",
        "theta2 = 0; theta2 = pi", Run(where_singular, calls='print(fb.singularities(fb.planar("RR")))'),
    ),
    Item(
        "uf-2.23-collinear", "2.2.3", "Links in line", "identity",
        "The arm is singular where its links lie on one line: their cross product is the determinant.",
        "cross(s1, s2) = l1*l2*sin(theta2) = det(J)", TIP,
    ),
    Item(
        "eq-2.24", "2.2.4", "Acceleration", "derivation",
        "The velocity differentiated; the Jacobian changes too.", "r_dd = J*qdd + J_d*qd", TIP,
    ),
    Item(
        "eq-2.25", "2.2.4", "Rates from the tip's velocity", "derivation",
        "Away from singular poses the map can be inverted.", "qd = J^-1*r_d", RATES,
    ),
    Item(
        "eq-2.26", "2.2.4", "Joint accelerations from the tip's acceleration", "derivation",
        "The same one derivative further.", "qdd = J^-1*(r_dd - J_d*qd)", RATES,
    ),
)  # fmt: skip
