"""Section 1.1 and 1.2.1: position, velocity and acceleration of a point (1.1-1.14)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import ByFunction, Related
from freebody_notes.item import Outcome
from freebody_textbook.relations.formula import parse
from freebody_textbook.relations.formula_values import value
from freebody_textbook.relations.relation import printed_numbers


def round_trip():
    """Torques from accelerations by inverse dynamics, and the accelerations from these by forward
    dynamics."""
    arm = fb.load("2R")
    q, qd, qdd = [0.4, 0.9], [1.2, -0.7], [2.0, 1.5]
    tau = fb.inverse_dynamics(arm, q, qd, qdd)
    return {"qdd": qdd, "qdd_back": fb.forward_dynamics(arm, q, qd, tau)}


def curve():
    """An arbitrary path, to check the definitions of velocity and acceleration."""
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
    """Outcome of checking velocity and acceleration on a circle whose amplitudes are printed to
    three digits; compared at many times, within one unit of the last digit."""
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
            f"[{entries}]; printed and computed differ by {miss:.2g} at most, "
            f"one unit of the last digit is {unit:g}."
        )
    return Outcome(fits, tuple(lines))


CHECKS = {
    "round_trip": Related(round_trip),
    "curve": Related(curve),
    "circle": Related(circle),
    "rounded_circle": ByFunction(
        rounded_circle,
        ("r_d", "r_dd"),
        calls='fb.trajectory("5*cos(3.14*t)", "5*sin(3.14*t)").velocity.expressions',
    ),
    "cubic": Related(cubic),
}
