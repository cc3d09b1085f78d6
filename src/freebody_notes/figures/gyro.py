"""Figure 6.2: the bundled gyro, rolling about X' and yawing about Z', and the moment that this
takes about Y'."""

from __future__ import annotations

import math

import numpy as np

from freebody.any_chain.dynamics import joint_wrenches
from freebody.arrays import Array
from freebody.figures.drawing import Drawing, Label, Line, Mark, Prism, point
from freebody.figures.figure import Figure
from freebody.figures.snapshot import snapshot
from freebody.figures.view import axonometric
from freebody.formats.loading import load

_RING = 0.62
_RATES = (3.0, 5.0)
"""Rates of yaw and roll, rad/s."""


def gyro() -> Figure:
    """Figure 6.2: rotor, shaft along X', yaw axis Z', the components of ω at 5 and 3 rad/s, and the
    moment n about Y' on the rotor. With constant rates the axis that carries n turns with the
    ring."""
    seen = snapshot(load("gyro"), (0.3, 0.0), _RATES, (0.0, 0.0))
    yaw, roll = seen.pose.bodies
    if roll.axis is None or yaw.axis is None:
        raise ValueError("the gyro turns about two axes")
    x, z, y = roll.axis, yaw.axis, np.cross(yaw.axis, roll.axis)
    view = axonometric(-35.0, 20.0)
    drawing = Drawing(view, "A gyro with its roll and yaw axes")
    half = _ring(x, z)
    for part, points in zip(("ring, behind", "ring"), half, strict=True):
        drawing.add(Line(tuple(map(point, points)), part, "link", width=6.0, far=part != "ring"))
    for end, name in ((1.0, "yaw pivot above"), (-1.0, "yaw pivot below")):
        ends = point(end * _RING * z), point(end * (_RING + 0.16) * z)
        drawing.add(Line(ends, name, "link", width=8.0))
    drawing.add(Line((point(-_RING * x), point(_RING * x)), "shaft", "link", width=6.0))
    drawing.add(Prism((0.0, 0.0, 0.0), point(x), 0.4, 0.07, "rotor", "joint", 40))
    drawing.add(Line((point(0.07 * x), point(_RING * x)), "shaft, in front", "link", width=6.0))
    foot = -(_RING + 0.16) * z
    drawing.add(Mark(point(foot), "ground", "ground", "ground", (0.0, 0.0, 1.0), 9.0))
    for axis, name in ((x, "X′"), (y, "Y′"), (z, "Z′")):
        drawing.add(Line((point(-0.2 * axis), point(1.15 * axis)), f"axis {name}", "axisline"))
        drawing.add(Label(point(1.15 * axis), name, name, direction=point(axis)))
    rate = 0.45 / max(abs(float(v)) for v in _RATES)
    for axis, value, name in ((x, seen.qd[1], "ω_{x′}"), (z, seen.qd[0], "ω_{z′}")):
        start = (_RING + 0.04) * axis
        drawing.arrow(
            start,
            start + rate * value * axis,
            name,
            "velocity",
            value * axis,
            "rad/s",
            heads=2,
        )
    moment = _moment(seen.model, seen.q, seen.qd, seen.qdd)
    end = 0.9 * moment / np.linalg.norm(moment)
    drawing.arrow(np.zeros(3), end, "n_{y′}", "moment", moment, "N m", heads=2)
    drawing.add(Mark((0.0, 0.0, 0.0), "com", "C", "com", size=5.0))
    spin, turn, n = (
        f"{abs(v):g}" for v in (seen.qd[1], seen.qd[0], round(float(np.linalg.norm(moment)), 6))
    )
    drawing.notes = [
        f"roll {spin} rad/s along X′, yaw {turn} rad/s along Z′; moment on the rotor {n} N m"
    ]
    return Figure("A gyro", (drawing,), 1, 480.0, 430.0)


def _moment(model, q: Array, qd: Array, qdd: Array) -> Array:
    """The moment on the rotor from its shaft, (3,) N m, world axes."""
    return np.asarray(joint_wrenches(model, q, qd, qdd))[1, 3:]


def _ring(x: Array, z: Array) -> tuple[Array, Array]:
    """Points (k, 3) of the gyro's ring: the half behind the rotor and the half in front."""
    angles = np.linspace(0.0, 2 * math.pi, 81)
    ring = _RING * (np.outer(np.cos(angles), x) + np.outer(np.sin(angles), z))
    return ring[20:61], np.concatenate([ring[60:], ring[:21]])
