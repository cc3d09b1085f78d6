"""Joint axes z_i (of slides u_i) in space, the joints' variables, and what lies between the axes:
common normals a_i and offsets d_i."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Drawing
from freebody.figures.layers.structure import of_each
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

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


@of_each
def joint_axes(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, longest: float = np.inf
) -> None:
    """z_i along the axis of each joint, from where it is, at most `longest` metres, and a thin line
    back."""
    if body.axis is not None:
        name, reach = names.axis(body), min(0.17 * seen.size, longest) * body.axis
        start = body.carrier if body.kind.slides else body.origin
        drawing.line((start - 0.6 * reach, start), f"axis {body.number}", "axisline")
        drawing.arrow(start, start + reach, name, "z", body.axis, label=name)


@of_each
def variables(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """The joints' variables behind their axes."""
    if body.axis is not None:
        end = body.carrier - 0.1 * seen.size * body.axis
        drawing.write(end, names.coordinate(body), -body.axis)


def normals(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """a_i along the common normal of the axes of joints i and i+1, d_{i+1} along the axis between
    two normals."""
    heads: dict[int, Array] = {}

    def span(start: Array, end: Array, name: str, role: str) -> None:
        if np.linalg.norm(end - start) > _VISIBLE * seen.size:
            drawing.arrow(start, end, name, role, end - start, "m", label=name, beside=0.5)

    for after in seen.pose.bodies:
        body = seen.pose.bodies[after.parent] if after.parent >= 0 else None
        if after.axis is None:
            continue
        if body is None or body.axis is None:
            heads[after.index] = after.carrier
            continue
        normal = common_normal(body.carrier, body.axis, after.carrier, after.axis)
        span(heads[body.index], normal.foot, names.on("d", body.number), "moment")
        span(normal.foot, normal.head, names.on("a", body.number), "external")
        heads[after.index] = normal.head
