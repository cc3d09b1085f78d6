"""A robot in space: an axonometric picture with joint axes as short solids, frames, the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import (
    SAME,
    Drawing,
    Element,
    Line,
    Mark,
    Prism,
    View,
    best_view,
    point,
)
from freebody.figures.joint_symbols import solid_joint
from freebody.figures.layers.plane import bars, closures
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace, Skeleton
from freebody.figures.snapshot import Snapshot

_FAR = 0.33  # of the depth: what is farther is paler


def viewed(seen: Snapshot) -> View:
    """From where the links and the joint axes are seen best."""
    reach = 0.3 * seen.size
    axes = [(b.origin, b.origin + reach * b.axis) for b in seen.pose.bodies if b.axis is not None]
    return best_view([*sticks(seen.pose), *axes] or [(np.zeros(3), np.ones(3))])


def sticks(pose: Skeleton) -> list[tuple[Array, Array]]:
    """Ends of all bars."""
    return [ends for body in pose.bodies for _, ends in bars(body, rod=True)]


def structure(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Links, joints as short solids, the world's axes and the tip."""
    drawing.add(*by_depth(solids(seen.pose, seen.size), drawing.view))
    closures(drawing, seen, "sphere")
    triad(drawing, np.zeros(3), np.eye(3), 0.16 * seen.size, ("X", "Y", "Z"))
    if seen.pose.tip is not None:
        drawing.mark(seen.pose.tip, "dot", names.tip, "position-head", 3.5)
        drawing.write(seen.pose.tip, names.tip, (1.0, 0.0, 0.5))


def solids(pose: Skeleton, size: float) -> list[Element]:
    """Links and joints of all bodies and the base."""
    wide, radius = (9.0, 0.022 * size) if len(pose.bodies) <= 12 else (6.0, 0.014 * size)
    elements: list[Element] = [
        Line(((0.0, 0.0, 0.0), point(root.carrier)), "link 0", "link", width=wide)
        for root in pose.roots
        if root.kind.holds and np.linalg.norm(root.carrier) > SAME
    ]
    return elements + [element for body in pose.bodies for element in solids_of(body, radius, wide)]


def solids_of(body: BodyPlace, radius: float, wide: float = 9.0) -> list[Element]:
    """One body's links and the joint that carries it."""
    links = [
        Line((point(a), point(b)), name, "link", width=wide)
        for name, (a, b) in bars(body, rod=True)
    ]
    return [*links, *solid_joint(body, radius)]


def by_depth(elements: Sequence[Element], view: View) -> list[Element]:
    """Farthest first, the far ones marked so; joints before the links that meet in them."""
    depths = [depth(element, view) for element in elements]
    low, high = min(depths, default=0.0), max(depths, default=0.0)
    limit = low + _FAR * (high - low) if high - low > 1e-9 else low
    order = sorted(range(len(elements)), key=lambda k: depths[k])
    return [_paler(elements[k]) if depths[k] < limit else elements[k] for k in order]


def depth(element: Element, view: View) -> float:
    """How near the viewer an element is; joints a little nearer than the links that meet in
    them."""
    if isinstance(element, Line):
        return view.depth(element.points)
    at = element.at if isinstance(element, Prism | Mark) else (0.0, 0.0, 0.0)
    return view.depth([at]) + (2.5 * element.radius if isinstance(element, Prism) else 0.0)


def _paler(element: Element) -> Element:
    return replace(element, far=True) if isinstance(element, Line | Prism) else element


def triad(
    drawing: Drawing,
    origin: Array,
    rotation: Array,
    length: float,
    names: Sequence[str],
    label: str | None = None,
) -> None:
    """Three axes of a frame, red, green and blue, with their names or a label."""
    for name, role, axis in zip(names, "xyz", rotation.T, strict=True):
        said = name if label is None else label
        drawing.arrow(origin, origin + length * axis, name, role, axis, label=said)


def floor(drawing: Drawing, seen: Snapshot, poses: Sequence[Skeleton]) -> None:
    """Grid lines a round distance apart under all poses, on them the shadow of the one that is
    seen."""
    level = min(0.0, min(float(pose.places[:, 2].min()) for pose in poses))
    flat = np.concatenate([pose.places[:, :2] for pose in poses])
    step = round_down(seen.size / 4)
    (x0, y0), (x1, y1) = np.floor(flat.min(0) / step - 0.15), np.ceil(flat.max(0) / step + 0.15)
    rows = [((k, y0), (k, y1)) for k in np.arange(x0, x1 + 1)]
    columns = [((x0, k), (x1, k)) for k in np.arange(y0, y1 + 1)]
    for ends in rows + columns:
        drawing.line([(*(step * np.array(end)), level) for end in ends], "grid", "grid")
    if level < -1e-9:
        drawing.line(((0.0, 0.0, 0.0), (0.0, 0.0, level)), "plumb line", "guide")
    feet = [(np.zeros(3), r.carrier) for r in seen.pose.roots if r.kind.holds]
    for ends in feet + sticks(seen.pose):
        drawing.line([(*end[:2], level) for end in ends], "shadow", "shadow")


def round_down(value: float) -> float:
    """1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(k * power for k in (1, 2, 5) if k * power <= value * (1 + 1e-12))
