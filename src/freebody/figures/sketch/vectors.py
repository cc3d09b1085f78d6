"""Position vectors of a planar arm: s_i from joint to joint, r to the tip, s_ci and r_ci to the
centres of mass."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Drawing, point
from freebody.figures.names import Names, bold
from freebody.figures.sketch.snapshot import Snapshot

BESIDE = 15.0
"""How far a vector is drawn beside the link it lies on, pixels."""
_NEAR = 1e-6


def links(
    drawing: Drawing, seen: Snapshot, names: Names, aside: float = 0.0, letter: str = "s"
) -> None:
    """s_i, from the joint of body i to the next, or to the tip."""
    for body in seen.pose.bodies:
        for end, place in seen.reaches(body):
            position(drawing, body.origin, place, names.reach(body, end, letter), aside)


def to_centres(drawing: Drawing, seen: Snapshot, names: Names, aside: float = -BESIDE) -> None:
    """s_ci, from the joint of body i to its centre of mass."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            position(drawing, body.origin, body.com, names.on("s", body.number, "c"), aside)


def directions(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Unit vectors along the slides."""
    for body in seen.pose.bodies:
        if body.kind.slides and body.axis is not None:
            name, end = names.axis(body), body.origin + 0.16 * seen.size * body.axis
            arrow(drawing, body.origin, end, name, "z", body.axis, "", aside=-2 * BESIDE)


def of_centres(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """r_ci, from the origin to the centre of mass of body i; beside the link where it lies on
    it."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            along = body.parent < 0 and np.linalg.norm(body.origin) < _NEAR
            name = names.on("r", body.number, "c")
            position(drawing, np.zeros(2), body.com, name, -BESIDE if along else 0.0)


def to_tip(drawing: Drawing, seen: Snapshot, name: str = "r") -> None:
    """r, from the origin to the tip."""
    if seen.pose.tip is not None:
        position(drawing, np.zeros(seen.model.dim), seen.pose.tip, name)


def position(drawing: Drawing, start: Array, end: Array, name: str, aside: float = 0.0) -> None:
    """A position vector, its label beside its middle; none where it has no length."""
    if np.linalg.norm(end - start) > _NEAR:
        arrow(drawing, start, end, name, "position", end - start, "m", beside=0.5, aside=aside)


def arrow(
    drawing: Drawing,
    start: Array,
    end: Array,
    name: str,
    role: str,
    value: Array,
    unit: str,
    *,
    label: str | None = None,
    **how: Any,
) -> None:
    """The vector `value` from start to end, labelled with its name in bold; how: heads, aside,
    beside of `Arrow`."""
    text = bold(name) if label is None else label
    drawing.add(Arrow(point(start), point(end), name, role, text, point(value), unit, **how))
