"""The layers of a robot without names of its geometry: ground, links, joints, the world's axes. In
the plane as textbooks draw it, in space as an axonometric picture with joints as short solids."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import SAME, Drawing, Element, Line, Mark, Prism, point, round_down
from freebody.figures.drawing_names import is_letter
from freebody.figures.skeleton import BodyPlace, DrawnJoint, LoopPlace, Skeleton
from freebody.figures.snapshot import Snapshot
from freebody.figures.view import FLAT, View, WorldPoint, best_view
from freebody.model.joints.kind import Solid

_AXIS = 0.3
"""Length of the world's axes in the plane, of the drawing's size."""
RING, _SIDES = 0.09, 40
"""Radius of the ring that a body without extent is drawn as, of the drawing's size."""
_FAR = 0.33  # of the depth: what is farther is paler
_CROWDED = 12  # bodies; more are drawn thinner
_TURNS, _COIL = 9, 0.012  # of a strut's coil: the number, their half width of the drawing's size
_PIN, _LARGER = 6.0, 8.0  # pixels: the mark of a joint, and those of others


Layer = Callable[..., None]
"""layer(drawing, seen, bodies=None, **how): draws one kind of thing, of all bodies or of some."""


def of_each(layer: Callable[..., None]) -> Layer:
    """A layer for all bodies, from a function that draws one: layer(drawing, seen, body, **how)."""

    @wraps(layer)
    def drawn(
        drawing: Drawing, seen: Snapshot, bodies: Sequence[BodyPlace] | None = None, **how: Any
    ) -> None:
        for body in seen.drawn if bodies is None else bodies:
            layer(drawing, seen, body, **how)

    return drawn


def drawn(seen: Snapshot, title: str, layers: Sequence[Layer] = (), faint: bool = False) -> Drawing:
    """A drawing of a robot with layers on it; faint: in pale lines, for vectors that lie on the
    links."""
    drawing = Drawing(view_of(seen), f"{seen.model.name}: {title}")
    structure(drawing, seen, faint)
    for layer in layers:
        layer(drawing, seen)
    return drawing


def view_of(seen: Snapshot) -> View:
    """The view in which the links and the joint axes of a robot are seen best."""
    if seen.model.dim == 2:
        return FLAT
    reach = 0.3 * seen.size
    axes = [(b.origin, b.origin + reach * b.axis) for b in seen.pose.bodies if b.axis is not None]
    return best_view([*sticks(seen.pose), *axes])


def structure(drawing: Drawing, seen: Snapshot, faint: bool = False) -> None:
    """Draw the parts of a robot, its joints, the world's axes and the tip."""
    (_flat_structure if seen.model.dim == 2 else _solid_structure)(drawing, seen, faint)


# ---------------------------------------------------------------- links and joints
def bars(body: BodyPlace, rod: bool = True) -> list[tuple[str, tuple[Array, Array]]]:
    """Names and ends of a link's bars; rod: with the bar along which its slide has moved."""
    away = body.kind.holds and np.linalg.norm(body.origin - body.carrier) > SAME
    ends = [(body.carrier, body.origin)] if rod and away else []
    more = [f"link {body.number}.{k}" for k in range(2, len(body.outline) + 2)]
    return list(zip([f"link {body.number}", *more], [*ends, *body.outline], strict=False))


def sticks(pose: Skeleton) -> list[tuple[Array, Array]]:
    """Ends of all bars that stand for links."""
    return [ends for body in pose.bodies for _, ends in bars(body)]


def link(body: BodyPlace, width: float = 11.0, rod: bool = False) -> list[Line]:
    """A link as bars; rod: with the bar along which its slide has moved."""
    return [
        Line((point(a), point(b)), name, "link", width=width) for name, (a, b) in bars(body, rod)
    ]


def joint(place: DrawnJoint, radius: float = 0.0) -> list[Element]:
    """A joint's symbol, as its kind describes it: in the plane a mark, in space solids of about a
    radius in metres, or a mark that looks alike from everywhere."""
    kind, at, name = place.kind, point(place.origin), place.symbol
    if len(at) == 2 or not kind.solids:
        size = _PIN if kind.mark == "joint" else _LARGER
        direction = None if place.axis is None else point(place.axis)
        apart = np.linalg.norm(place.origin - place.carrier) > SAME
        both = apart and isinstance(place, LoopPlace) and not kind.slides
        ends = (point(place.carrier), at) if both else (at,)
        return [Mark(end, kind.mark, name, "joint", direction, size) for end in ends if kind.mark]
    return [
        Prism(
            at if part.moves else point(place.carrier), point(way), part.radius * radius,
            part.half * radius, name, "joint", part.sides,
        )
        for part in kind.solids
        if (way := along(place, part)) is not None
    ]  # fmt: skip


def along(place: DrawnJoint, part: Solid) -> Array | None:
    """The direction of a part of a joint's symbol, in world axes; None where it is left open."""
    if part.along == "axis":
        return place.axis
    axes = place.rotation if part.moves else place.carrier_rotation
    return axes[:, "xyz".index(part.along)]


def _rings(drawing: Drawing, seen: Snapshot) -> None:
    """Draw a ring about the axis of each wheel."""
    for body in filter(lambda body: body.wheel, seen.drawn):
        u, v = np.eye(seen.model.dim)[:2]
        if body.axis is not None:
            u = _across(body.axis)
            v = np.cross(body.axis, u)
        angles = 2 * math.pi * np.arange(_SIDES) / _SIDES
        rim = RING * seen.size * (np.outer(np.cos(angles), u) + np.outer(np.sin(angles), v))
        drawing.line(body.origin + rim, f"ring {body.number}", "rail", closed=True)


def _rods(drawing: Drawing, seen: Snapshot) -> None:
    """Draw the rods of loops that keep two points at a distance."""
    for loop in seen.pose.loops:
        if np.linalg.norm(loop.origin - loop.carrier) > SAME:
            drawing.line((loop.carrier, loop.origin), loop.symbol, "rail")


def _struts(drawing: Drawing, seen: Snapshot) -> None:
    """Draw a coil between the ends of each strut."""
    for strut in seen.pose.struts:
        a, b = strut.ends
        length = float(np.linalg.norm(b - a))
        if length <= SAME:
            continue
        x = (b - a) / length
        side = np.array([-x[1], x[0]]) if len(x) == 2 else _across(x)
        middle = [
            a + (0.25 + 0.5 * k / _TURNS) * (b - a) + (-1) ** k * _COIL * seen.size * side
            for k in range(_TURNS + 1)
        ]
        drawing.line((a, a + 0.2 * (b - a), *middle, a + 0.8 * (b - a), b), strut.name, "rail")


def _across(x: Array) -> Array:
    """A direction (3,) at right angles to the unit vector x."""
    found = np.asarray(np.cross(x, np.eye(3)[int(np.argmin(abs(x)))]), dtype=float)
    return found / np.linalg.norm(found)


# ---------------------------------------------------------------- the plane
def _flat_structure(drawing: Drawing, seen: Snapshot, faint: bool) -> None:
    for root in seen.pose.roots:
        if root in seen.drawn:
            _support(drawing, root, seen.size)
    axes(drawing, seen.size, share=_axis_share(seen))
    for body in seen.drawn:
        if body.kind.slides and body.parent >= 0:
            drawing.line((body.carrier, body.origin), f"rod {body.number}", "rail")
        if faint:
            for ends in body.outline:
                drawing.line(ends, f"link {body.number}", "ghost")
        else:
            drawing.add(*link(body))
    for body in filter(seen.is_held, seen.drawn):
        drawing.add(*joint(body))
    _rings(drawing, seen)
    _rods(drawing, seen)
    _struts(drawing, seen)
    for loop in seen.pose.loops:
        drawing.add(*joint(loop))
    if seen.pose.tip is not None:
        drawing.mark(seen.pose.tip, "dot", seen.names.tip, "position-head", 3.5)
    _points(drawing, seen)


def _axis_share(seen: Snapshot) -> float:
    """The length of the world's axes as a fraction of the drawing's size; where the base's slide
    lies along one, its head stays clear of the block."""
    slides = [float(np.linalg.norm(r.origin)) for r in seen.pose.roots if r.kind.slides]
    return min([_AXIS, *(0.65 * d / seen.size for d in slides if d > 0.15 * seen.size)])


def axes(
    drawing: Drawing, size: float, origin: WorldPoint = (0.0, 0.0), share: float = _AXIS
) -> None:
    """Draw world axes x and y from the origin."""
    for name, way in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
        end = np.add(origin, np.multiply(share * size, way))
        drawing.arrow(origin, end, name, "soft", label="")
        drawing.write(end, name, way)


def _support(drawing: Drawing, root: BodyPlace, size: float) -> None:
    """Draw the ground under a robot's first joint: a pedestal under a turn, a hatched guide under a
    slide, nothing under a body that moves freely."""
    if not root.kind.holds:
        return
    if root.axis is None or not root.kind.slides:
        drawing.add(Mark(point(root.carrier), "ground", "ground", "ground", (0.0, 1.0), 9.0))
        return
    half = 0.5 * float(np.linalg.norm(root.origin - root.carrier)) + 0.12 * size
    middle = (root.origin + root.carrier) / 2
    x, y = root.axis if root.axis[0] >= 0 else -root.axis
    ends = middle - half * root.axis, middle + half * root.axis
    drawing.line(ends, "ground", "rail")
    strokes = max(int(2 * half / (0.03 * size) / 0.9), 2)
    back = 0.03 * size * (np.array([y, -x]) - 0.7 * root.axis)
    for k in range(1, strokes + 1):
        foot = ends[0] + k / strokes * (ends[1] - ends[0])
        drawing.line((foot, foot + back), "hatch", "hatch")


def _points(drawing: Drawing, seen: Snapshot) -> None:
    """Write the names of the joints and of the tip, away from the links that meet there; one name
    at each place, the tip's first."""
    pose, names = seen.pose, seen.names
    taken = [] if pose.tip is None else [pose.tip]

    def write(place: Array, text: str, direction: WorldPoint) -> None:
        if all(np.linalg.norm(place - other) > SAME for other in taken):
            drawing.write(place, text, direction)
            taken.append(place)

    for body in seen.drawn:
        write(body.origin, names.point(pose, body.number), clear_way(seen, body))
    for name, place in pose.frames.items():
        if is_letter(name):
            write(place, name, (-0.6, 0.8))
    if pose.tip is not None and names.tip:
        away = pose.tip - pose.bodies[-1].origin
        drawing.write(pose.tip, names.tip, away if np.linalg.norm(away) > SAME else (1.0, 1.0))


def clear_way(seen: Snapshot, body: BodyPlace) -> WorldPoint:
    """The direction from a body's joint in which no part of the arm lies."""
    after = seen.heading(body)
    if body.parent < 0:  # between the link and the foot of the pedestal that is farther from it
        at = math.degrees(math.atan2(after[1], after[0])) % 360
        foot = 240.0 if at < 90 or at > 270 else -60.0
        middle = math.radians(((at if at <= 270 else at - 360) + foot) / 2)
        return (math.cos(middle), math.sin(middle))
    away = seen.heading(seen.pose.bodies[body.parent]) - after
    return point(away) if np.linalg.norm(away) > 0.1 else (-float(after[1]), float(after[0]))


# ---------------------------------------------------------------- space
def _solid_structure(drawing: Drawing, seen: Snapshot, faint: bool) -> None:
    pose, crowded = seen.pose, len(seen.pose.bodies) > _CROWDED
    width, radius = (6.0, 0.014 * seen.size) if crowded else (9.0, 0.022 * seen.size)
    elements: list[Element] = [
        Line(((0.0, 0.0, 0.0), point(root.carrier)), "link 0", "link", width=width)
        for root in pose.roots
        if root.kind.holds and np.linalg.norm(root.carrier) > SAME
    ]
    for body in pose.bodies:
        elements += solids_of(body, radius, width)
    for loop in pose.loops:
        elements += joint(loop, radius)
    drawing.add(*_by_depth(elements, drawing.view))
    _rings(drawing, seen)
    _rods(drawing, seen)
    _struts(drawing, seen)
    triad(drawing, np.zeros(3), np.eye(3), 0.16 * seen.size, ("X", "Y", "Z"))
    if pose.tip is not None:
        drawing.mark(pose.tip, "dot", seen.names.tip, "position-head", 3.5)
        drawing.write(pose.tip, seen.names.tip, (1.0, 0.0, 0.5))


def solids_of(body: BodyPlace, radius: float, width: float = 9.0) -> list[Element]:
    """The links of one body and the joint that carries it."""
    return [*link(body, width, rod=True), *joint(body, radius)]


def _by_depth(elements: Sequence[Element], view: View) -> list[Element]:
    """Elements sorted by distance from the viewer, the farthest first and drawn paler; joints come
    before the links that meet in them."""
    depths = [depth(element, view) for element in elements]
    low, high = min(depths, default=0.0), max(depths, default=0.0)
    limit = low + _FAR * (high - low) if high - low > 1e-9 else low
    order = sorted(range(len(elements)), key=lambda k: depths[k])
    return [_paler(elements[k]) if depths[k] < limit else elements[k] for k in order]


def depth(element: Element, view: View) -> float:
    """How near an element is to the viewer; joints a little nearer than the links that meet in
    them."""
    if isinstance(element, Line):
        return view.depth(element.points)
    at = element.at if isinstance(element, Prism | Mark) else (0.0, 0.0, 0.0)
    return view.depth([at]) + (2.5 * element.radius if isinstance(element, Prism) else 0.0)


def _paler(element: Element) -> Element:
    return replace(element, far=True) if isinstance(element, Line | Prism) else element


def triad(
    drawing: Drawing, origin: Array, rotation: Array, length: float, names: Sequence[str],
    label: str | None = None,
) -> None:  # fmt: skip
    """Draw three axes of a frame in red, green and blue, with their names or one label."""
    for name, role, axis in zip(names, "xyz", rotation.T, strict=True):
        said = name if label is None else label
        drawing.arrow(origin, origin + length * axis, name, role, axis, label=said)


def _level(poses: Sequence[Skeleton]) -> float:
    """The height of the floor under all poses: the base's, or that of the lowest joint."""
    return min(0.0, min(float(pose.places[:, 2].min()) for pose in poses))


def floor(drawing: Drawing, poses: Sequence[Skeleton], size: float) -> None:
    """Draw a floor under all poses of a robot of a size (m): grid lines a round distance apart."""
    level = _level(poses)
    flat = np.concatenate([pose.places[:, :2] for pose in poses])
    step = round_down(size / 4)
    (x0, y0), (x1, y1) = np.floor(flat.min(0) / step - 0.15), np.ceil(flat.max(0) / step + 0.15)
    rows = [((k, y0), (k, y1)) for k in np.arange(x0, x1 + 1)]
    columns = [((x0, k), (x1, k)) for k in np.arange(y0, y1 + 1)]
    for ends in rows + columns:
        drawing.line([(*(step * np.array(end)), level) for end in ends], "grid", "grid")
    if level < -1e-9:
        drawing.line(((0.0, 0.0, 0.0), (0.0, 0.0, level)), "plumb line", "guide")


def shadow(drawing: Drawing, seen: Snapshot, poses: Sequence[Skeleton]) -> None:
    """Draw the shadow of a robot on the floor under all poses."""
    level = _level(poses)
    feet = [(np.zeros(3), r.carrier) for r in seen.pose.roots if r.kind.holds]
    for ends in feet + sticks(seen.pose):
        drawing.line([(*end[:2], level) for end in ends], "shadow", "shadow")
