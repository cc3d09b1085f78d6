"""A robot in space: an axonometric picture with joint axes as short cylinders, ground grid, shadow,
frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import (
    Arrow,
    Drawing,
    Element,
    Label,
    Line,
    Mark,
    Prism,
    View,
    best_view,
    point,
)
from freebody.figures.joints import solid_joint
from freebody.figures.plane import round_down, ruler, sticks
from freebody.figures.skeleton import BodyPlace, Skeleton, extent
from freebody.model.model import Model

_FAR = 0.33  # of the depth: what is farther is paler


def draw(model: Model, pose: Skeleton, ghosts: Sequence[Skeleton], path: Array | None) -> Drawing:
    """The drawing of one pose, with fainter ones behind it."""
    every = [pose, *ghosts]
    size = extent(every, path)
    view = best_view(
        [stick for p in every for body in p.bodies for stick in sticks(body)]
        or [(np.zeros(3), np.ones(3))]
    )
    drawing = Drawing(view, f"{model.name}: stick drawing with joint axes")
    floor = min(0.0, min(float(p.places[:, 2].min()) for p in every))
    _ground(drawing, every, floor, size)
    for segment in _segments(pose):
        drawing.add(
            Line(tuple((float(p[0]), float(p[1]), floor) for p in segment), "shadow", "shadow")
        )
    for ghost in ghosts:
        for a, b in _segments(ghost):
            drawing.add(Line((point(a), point(b)), "ghost", "ghost"))
    if path is not None:
        drawing.add(Line(tuple(map(point, path)), "tip path", "tippath"))
        drawing.add(Mark(point(path[0]), "dot", "path start", "tipdot", size=3.0))
    drawing.add(*by_depth(solids(pose, size), view))
    triad(drawing, np.zeros(3), np.eye(3), 0.13 * size, "base")
    if pose.tip is not None and pose.tip_rotation is not None:
        triad(drawing, pose.tip, pose.tip_rotation, 0.1 * size, "tip")
    crowded = len(pose.bodies) > 12
    for body in pose.bodies:
        if not crowded:
            drawing.add(
                Label(
                    point(body.origin),
                    str(body.number),
                    f"label {body.number}",
                    "name",
                    (0.0, 0.0, -1.0),
                )
            )
    drawing.rulers.append(ruler(size))
    return drawing


def solids(pose: Skeleton, size: float) -> list[Element]:
    """Links and joints of all bodies and the base."""
    wide, radius = (9.0, 0.022 * size) if len(pose.bodies) <= 12 else (6.0, 0.014 * size)
    elements: list[Element] = [
        Line(((0.0, 0.0, 0.0), point(root.carrier)), "link 0", "link", width=wide)
        for root in pose.roots
        if root.kind.holds and np.linalg.norm(root.carrier) > 1e-6
    ]
    return elements + [element for body in pose.bodies for element in solids_of(body, radius, wide)]


def solids_of(body: BodyPlace, radius: float, wide: float = 9.0) -> list[Element]:
    """One body's links and the joint that carries it."""
    bars = [
        Line(
            (point(a), point(b)),
            f"link {body.number}" + ("" if k == 0 else f".{k + 1}"),
            "link",
            width=wide,
        )
        for k, (a, b) in enumerate(sticks(body))
    ]
    return [*bars, *solid_joint(body, radius)]


def by_depth(elements: Sequence[Element], view: View) -> list[Element]:
    """Farthest first, the far ones marked so; joints before the links that meet in them."""
    depths = [depth(element, view) for element in elements]
    low, high = min(depths, default=0.0), max(depths, default=0.0)
    limit = low + _FAR * (high - low)
    spread = high - low
    order = sorted(range(len(elements)), key=lambda k: depths[k])
    return [
        _paler(elements[k]) if spread > 1e-9 and depths[k] < limit else elements[k] for k in order
    ]


def triad(drawing: Drawing, origin: Array, rotation: Array, length: float, owner: str) -> None:
    """Three axes of a frame, red, green and blue."""
    for k, name in enumerate("xyz"):
        end = origin + length * rotation[:, k]
        drawing.add(Arrow(point(origin), point(end), f"{owner} {name}", name))
        if owner == "base":
            drawing.add(
                Label(point(end), name, f"label {owner} {name}", name, point(rotation[:, k]))
            )


def depth(element: Element, view: View) -> float:
    """How near the viewer an element is; joints a little nearer than the links that meet in
    them."""
    if isinstance(element, Line):
        return view.depth(element.points)
    at = element.at if isinstance(element, Prism | Mark) else (0.0, 0.0, 0.0)
    return view.depth([at]) + (2.5 * element.radius if isinstance(element, Prism) else 0.0)


def _paler(element: Element) -> Element:
    return replace(element, far=True) if isinstance(element, Line | Prism) else element


def _segments(pose: Skeleton) -> list[tuple[Array, Array]]:
    base = [(np.zeros(3), r.carrier) for r in pose.roots if r.kind.holds]
    return base + [stick for body in pose.bodies for stick in sticks(body)]


def _ground(drawing: Drawing, poses: Sequence[Skeleton], floor: float, size: float) -> None:
    """Grid lines under everything, a round distance apart."""
    flat = np.concatenate([pose.places[:, :2] for pose in poses])
    step = round_down(size / 4)
    low = np.floor((flat.min(axis=0) - 0.15 * step) / step)
    high = np.ceil((flat.max(axis=0) + 0.15 * step) / step)
    for axis in (0, 1):
        for k in range(int(low[axis]), int(high[axis]) + 1):
            ends = []
            for other in (low[1 - axis], high[1 - axis]):
                at = (
                    (k * step, float(other) * step)
                    if axis == 0
                    else (float(other) * step, k * step)
                )
                ends.append((*at, floor))
            drawing.add(Line(tuple(ends), "grid", "grid"))
    if math.isclose(floor, 0.0, abs_tol=1e-9):
        return
    drawing.add(Line(((0.0, 0.0, 0.0), (0.0, 0.0, floor)), "plumb line", "guide"))
