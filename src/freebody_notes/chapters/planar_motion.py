"""Section 1.1 and 1.2.1: position, velocity and acceleration of a point (1.1-1.14)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.formula import parse
from freebody.derivations.relation import printed_numbers
from freebody.derivations.values import value
from freebody_notes.checks import ARM, Reading, Related, Run
from freebody_notes.item import Item, Outcome


def round_trip():
    """Torques from accelerations, and back."""
    arm = fb.load("2R")
    q, qd, qdd = [0.4, 0.9], [1.2, -0.7], [2.0, 1.5]
    tau = fb.inverse_dynamics(arm, q, qd, qdd)
    return {"qdd": qdd, "qdd_back": fb.forward_dynamics(arm, q, qd, tau)}


def curve():
    """Any path will do for definitions."""
    path = fb.trajectory("3*t^3 + 2*t^2 + 1", "2*t^3 + 4*t")
    x, y = path.position.rows
    x_d, y_d = path.velocity.rows
    x_dd, y_dd = path.acceleration.rows
    return dict(path.values) | {"x": x, "y": y, "x_d": x_d, "y_d": y_d, "x_dd": x_dd, "y_dd": y_dd}


def circle():
    return fb.trajectory("5*cos(3.14*t)", "5*sin(3.14*t)").values


def cubic():
    return fb.trajectory("3*t^3 + 2*t^2 + 1", "2*t^3 + 4*t").values


def rounded_circle(printed: str) -> Outcome:
    """The amplitudes are printed to three digits: compared at many times, to one unit of the
    last."""
    t = np.linspace(0, 2, 201)
    path = fb.trajectory("5*cos(3.14*t)", "5*sin(3.14*t)")
    _, velocity, acceleration = path.at(t)
    computed = {"r_d": velocity, "r_dd": acceleration}
    exact = {"r_d": path.velocity, "r_dd": path.acceleration}
    lines, fits = [], True
    for form in printed.split(";"):
        left, right = form.split("=")
        unit = max(u for x, u in printed_numbers(right) if abs(x) != 3.14)
        rows = [value(parse(right), {"t": time}) for time in t]
        miss = np.abs(np.array(rows, dtype=float) - computed[left.strip()]).max()
        fits = fits and miss < unit
        entries = ", ".join(map(str, exact[left.strip()].expressions))
        lines.append(
            f"[{entries}]; printed and computed differ by {miss:.2g} at most, one unit of the last digit is {unit:g}."
        )
    return Outcome(fits, tuple(lines))


CIRCLE = 'fb.trajectory("5*cos(3.14*t)", "5*sin(3.14*t)").velocity.expressions'
TIP = Related(f"fb.quantities({ARM})")

ITEMS = (
    Item(
        "def-1.1-inverse-forward", "1.1", "Inverse and forward dynamics", "definition",
        "Inverse dynamics takes a motion to the joint forces that cause it, forward dynamics takes forces to accelerations: "
        "the one undoes the other.",
        "qdd_back = qdd", Related(round_trip),
    ),
    Item(
        "eq-1.1", "1.2.1", "Position of a point", "definition",
        "The position of a point in the plane is the vector of its two coordinates, both functions of time.",
        "r = [x, y]", Related(curve), figure="1.1",
    ),
    Item(
        "eq-1.2", "1.2.1", "Velocity", "definition",
        "The velocity is the time derivative of the position, component by component.",
        "r_d = d_dt(r) = [x_d, y_d]", Related(curve), figure="1.1",
    ),
    Item(
        "eq-1.3", "1.2.1", "Acceleration", "definition",
        "The acceleration is the time derivative of the velocity.",
        "r_dd = d_dt(r_d) = [x_dd, y_dd]", Related(curve),
    ),
    Item(
        "eq-1.4", "1.2.1", "Dots", "definition",
        "A dot over a letter is a time derivative.",
        "[x_d, y_d] = [d_dt(x), d_dt(y)]", Related(curve),
    ),
    Item(
        "eq-1.5", "1.2.1", "A number without an equation", "text", "An equation number on an empty line.",
        "(1.5), on a line by itself", Reading("", "the line between (1.4) and example 1 holds nothing but this number."), "incomplete", "",
        "The number (1.5) stands on an empty line; it can be deleted.",
    ),
    Item(
        "ex-1.1a", "1.2.1", "Example 1a: motion on a circle", "worked-example",
        "Velocity and acceleration of x = 5 cos 3.14 t, y = 5 sin 3.14 t (m, s).",
        "r_d = [-15.7*sin(3.14*t), 15.7*cos(3.14*t)]; r_dd = [-49.3*cos(3.14*t), -49.3*sin(3.14*t)]",
        Run(rounded_circle, ("r_d", "r_dd"), calls=CIRCLE),
    ),
    Item(
        "eq-1.6", "1.2.1", "Velocity on the circle", "worked-example",
        "The amplitude of the velocity is radius times angular rate, 5 · 3.14.",
        "r_d = [-15.7*sin(3.14*t), 15.7*cos(3.14*t)]", Related(circle),
    ),
    Item(
        "eq-1.7", "1.2.1", "Acceleration on the circle", "worked-example",
        "The amplitude of the acceleration is radius times the square of the rate, 49.298, rounded to three digits.",
        "r_dd = [-49.3*cos(3.14*t), -49.3*sin(3.14*t)]", Run(rounded_circle, ("r_dd",), calls=CIRCLE),
    ),
    Item(
        "ex-1.1b", "1.2.1", "Example 1b: a polynomial path", "worked-example",
        "Velocity and acceleration of x = 3t³ + 2t² + 1, y = 2t³ + 4t (m, s).",
        "r_d = [9*t^2 + 4*t, 6*t^2]; r_dd = [18*t + 4, 12*t]", Related(cubic),
        "misprint", "r_d = [9*t^2 + 4*t, 6*t^2 + 4]; r_dd = [18*t + 4, 12*t]",
        "The derivative of 4t is missing in the second component of the velocity; the acceleration is right.",
    ),
    Item(
        "eq-1.8", "1.2.1", "Velocity on the polynomial path", "worked-example",
        "Velocity of x = 3t³ + 2t² + 1, y = 2t³ + 4t.",
        "r_d = [9*t^2 + 4*t, 6*t^2]", Related(cubic),
        "misprint", "r_d = [9*t^2 + 4*t, 6*t^2 + 4]",
        "The derivative of 4t is 4; as printed the point would start with speed 0, where it has 4 m/s.",
    ),
    Item(
        "eq-1.9", "1.2.1", "Acceleration on the polynomial path", "worked-example",
        "Acceleration of the same motion.",
        "r_dd = [18*t + 4, 12*t]", Related(cubic),
    ),
    Item(
        "ex-1.2", "1.2.1", "Example 2: tip of the arm", "worked-example",
        "Position and velocity of the tip P of an arm with two links; θ₂ counts from the first link.",
        "r = [l1*cos(theta1) + l2*cos(theta1+theta2), l1*sin(theta1) + l2*sin(theta1+theta2)]; "
        "r_d = [-l1*theta1_d*sin(theta1) - l2*(theta1_d+theta2_d)*sin(theta1+theta2), "
        "l1*theta1_d*cos(theta1) + l2*(theta1_d+theta2_d)*cos(theta1+theta2)]",
        TIP, figure="1.2",
    ),
    Item(
        "eq-1.10", "1.2.1", "Chain of vectors", "derivation",
        "The way to the tip leads along the links: O to A, then A to P.",
        "r = s1 + s2", TIP, figure="1.2",
    ),
    Item(
        "eq-1.11", "1.2.1", "Link by link", "derivation",
        "Each link vector by its length and the angle it makes with x.",
        "r = [l1*cos(theta1), l1*sin(theta1)] + [l2*cos(theta1+theta2), l2*sin(theta1+theta2)]", TIP, figure="1.2",
    ),
    Item(
        "eq-1.12", "1.2.1", "Position of the tip", "derivation",
        "Both link vectors added up.",
        "r = [l1*cos(theta1) + l2*cos(theta1+theta2), l1*sin(theta1) + l2*sin(theta1+theta2)]", TIP, figure="1.2",
    ),
    Item(
        "eq-1.13", "1.2.1", "Velocity as a column", "definition",
        "The velocity of the tip has the components ẋ and ẏ.",
        "r_d = [x_d, y_d]", Related(f"fb.quantities({ARM})", also="x_d = d_dt(x); y_d = d_dt(y)"),
    ),
    Item(
        "eq-1.14", "1.2.1", "Velocity of the tip", "derivation",
        "The position differentiated; the second link turns at the rate θ̇₁ + θ̇₂.",
        "r_d = [-l1*theta1_d*sin(theta1) - l2*(theta1_d+theta2_d)*sin(theta1+theta2), "
        "l1*theta1_d*cos(theta1) + l2*(theta1_d+theta2_d)*cos(theta1+theta2)]",
        TIP,
    ),
    Item(
        "ex-1.2-acceleration", "1.2.1", "Exercise: acceleration of the tip", "derivation",
        "The acceleration of the tip is left to the reader, to be found by differentiating the velocity (1.14).",
        "", TIP, "incomplete",
        "r_dd = [-l1*(theta1_dd*sin(theta1) + theta1_d^2*cos(theta1)) - l2*((theta1_dd+theta2_dd)*sin(theta1+theta2) "
        "+ (theta1_d+theta2_d)^2*cos(theta1+theta2)), l1*(theta1_dd*cos(theta1) - theta1_d^2*sin(theta1)) "
        "+ l2*((theta1_dd+theta2_dd)*cos(theta1+theta2) - (theta1_d+theta2_d)^2*sin(theta1+theta2))]",
        "An exercise; its answer is worked out here.",
    ),
)  # fmt: skip
