"""A robot in space without numbers: joint axes z_i, vectors s_i, common normals a_i and offsets
d_i."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.figures import space
from freebody.figures.drawing import Arrow, Drawing, Label, Line, Mark, View, best_view, point
from freebody.figures.names import Names
from freebody.figures.sketch.snapshot import Snapshot
from freebody.figures.sketch.vectors import arrow

_PARALLEL = 1e-6
_VISIBLE = 0.025
"""Lengths below this part of the robot's size are not drawn."""


@dataclass(frozen=True)
class Normal:
    """The common normal of two joint axes: from `foot` on the first to `head` on the second, places
    (3,)."""

    foot: Array
    head: Array

    @property
    def length(self) -> float:
        """a_i, metres."""
        return float(np.linalg.norm(self.head - self.foot))


def common_normal(p: Array, u: Array, q: Array, v: Array) -> Normal:
    """Of the axes p + s u and q + t v (unit vectors); of parallel ones that through q."""
    w, cosine = q - p, float(u @ v)
    sine2 = 1.0 - cosine**2
    if sine2 < _PARALLEL:
        return Normal(p + (w @ u) * u, q)
    s = float(w @ u - cosine * (w @ v)) / sine2
    t = float(cosine * (w @ u) - w @ v) / sine2
    return Normal(p + s * u, q + t * v)


def blank(title: str, view: View) -> Drawing:
    """A drawing in space with formulas for labels."""
    return Drawing(view, title, formulas=True)


def viewed(seen: Snapshot) -> View:
    """From where the links and the joint axes are seen best."""
    sticks = [stick for body in seen.pose.bodies for stick in body.outline]
    reach = 0.3 * seen.size
    axes = [(b.origin, b.origin + reach * b.axis) for b in seen.pose.bodies if b.axis is not None]
    return best_view([*sticks, *axes] or [(np.zeros(3), np.ones(3))])


def structure(drawing: Drawing, seen: Snapshot) -> None:
    """Links, joints as short solids, the world's axes and the tip's."""
    drawing.add(*space.by_depth(space.solids(seen.pose, seen.size), drawing.view))
    triad(drawing, np.zeros(3), np.eye(3), 0.16 * seen.size, ("X", "Y", "Z"))
    if seen.pose.tip is not None:
        drawing.add(Mark(point(seen.pose.tip), "dot", "P", "position-head", size=3.5))
        drawing.add(Label(point(seen.pose.tip), "P", "label P", direction=(1.0, 0.0, 0.5)))


def triad(
    drawing: Drawing, origin: Array, rotation: Array, length: float, names: tuple[str, str, str]
) -> None:
    """Three axes of a frame, red, green and blue."""
    for k, (name, role) in enumerate(zip(names, "xyz", strict=True)):
        end = origin + length * rotation[:, k]
        drawing.add(Arrow(point(origin), point(end), name, role, name, point(rotation[:, k])))


def joint_axes(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """z_i along the axis of each joint, from where it is, and a thin line back."""
    for body in seen.pose.bodies:
        if body.axis is not None:
            slides = body.kind.slides
            name = names.axis(body)
            reach = 0.17 * seen.size * body.axis
            start = body.carrier if slides else body.origin
            drawing.add(
                Line((point(start - 0.6 * reach), point(start)), f"axis {body.number}", "axisline")
            )
            drawing.add(
                Arrow(point(start), point(start + reach), name, "z", name, point(body.axis))
            )


def variables(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """The joints' variables beside their axes' heads."""
    for body in seen.pose.bodies:
        if body.axis is not None:
            name = names.coordinate(body)
            end = body.carrier - 0.1 * seen.size * body.axis
            drawing.add(Label(point(end), name, f"label {name}", direction=point(-body.axis)))


def links(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """s_i from joint i to the next, or to the tip."""
    for body in seen.pose.bodies:
        for end, place in seen.reaches(body):
            way = place - body.origin
            if np.linalg.norm(way) > _VISIBLE * seen.size:
                arrow(
                    drawing,
                    body.origin,
                    place,
                    names.reach(body, end),
                    "position",
                    way,
                    "m",
                    beside=0.5,
                )


def centres(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Centres of mass with their names."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            name = names.on("C", body.number)
            drawing.add(Mark(point(body.com), "com", name, "com", size=5.0))
            drawing.add(Label(point(body.com), name, f"label {name}", direction=(0.0, 0.0, -1.0)))


def normals(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """a_i along the common normal of the axes of joints i and i+1, d_{i+1} along the axis between
    two normals."""
    heads: dict[int, Array] = {}
    for after in seen.pose.bodies:
        if after.axis is None:
            continue
        body = seen.pose.bodies[after.parent] if after.parent >= 0 else None
        if body is None or body.axis is None:
            heads[after.index] = after.carrier
            continue
        normal = common_normal(body.carrier, body.axis, after.carrier, after.axis)
        _offset(drawing, heads[body.index], normal.foot, names.on("d", body.number), seen.size)
        if normal.length > _VISIBLE * seen.size:
            name = names.on("a", body.number)
            arrow(
                drawing,
                normal.foot,
                normal.head,
                name,
                "external",
                normal.head - normal.foot,
                "m",
                label=name,
                beside=0.5,
            )
        heads[after.index] = normal.head


def _offset(drawing: Drawing, start: Array, end: Array, name: str, size: float) -> None:
    if np.linalg.norm(end - start) > _VISIBLE * size:
        arrow(drawing, start, end, name, "moment", end - start, "m", label=name, beside=0.5)
