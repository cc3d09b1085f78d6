"""Layers of free bodies: one body with all loads on it, or one with all bodies that it carries."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from freebody.arrays import Array
from freebody.figures.body_loads import BodyLoads, Load
from freebody.figures.colours import FORCES
from freebody.figures.drawing import SAME, Arrow, Drawing, Turn, point
from freebody.figures.layers import geometry, structure
from freebody.figures.layers.structure import Layer, of_each, view_of
from freebody.figures.skeleton import BodyPlace, DrawnJoint
from freebody.figures.snapshot import Snapshot
from freebody.figures.view import View, best_view

_BESIDE = geometry.BESIDE + 2
_AXIS, _ANGLE = 0.45, 0.4  # the longest axis and arc beside the forces, of the size of the body
_LONGEST, _SHORTEST = 0.75, 0.12  # the longest arrow, of the size of the body; the shortest, of it
_ALIKE = 3.0  # bodies whose sizes differ by less than this factor are drawn to one scale
_LANE = 9.0  # pixels between arrows that would lie on each other
_LOADS: tuple[str, str] = ("N", "N m")  # units of forces and moments
_SEEN = 0.7  # of its length: what a view has to show of a body


# ---------------------------------------------------------------- how long arrows are
@dataclass(frozen=True)
class Scale:
    """The scale of loads in a drawing: the largest force (N) and moment (N m), and the length at
    which these are drawn (m)."""

    force: float
    moment: float
    longest: float

    def end(self, place: Array, value: Array, turning: bool = False) -> Array:
        """The end of the arrow of a force or moment at a place."""
        size, largest = float(np.linalg.norm(value)), self.moment if turning else self.force
        share = max(size / largest, _SHORTEST) * (0.75 if turning else 1.0)
        return place + share * self.longest * value / size

    def lengthened(self, arrows: Iterable[Arrow]) -> list[str]:
        """Names of the forces and moments that are drawn longer than to scale so that they can be
        seen."""
        largest = dict(zip(_LOADS, (self.force, self.moment), strict=True))
        loads = [arrow for arrow in arrows if arrow.unit in largest]
        return [x.name for x in loads if np.linalg.norm(x.value) < _SHORTEST * largest[x.unit]]


def scale_of(bodies: Iterable[BodyLoads], longest: float) -> Scale:
    """The scale on which the forces of all given bodies are drawn; longest: the length of the
    largest one (m)."""
    loads = [load for body in bodies for load in body.loads]
    force = max((float(np.linalg.norm(load.force)) for load in loads), default=0.0)
    moment = max((float(np.linalg.norm(load.moment)) for load in loads), default=0.0)
    return Scale(force, moment, longest)


def scales_of(bodies: Sequence[BodyLoads]) -> tuple[Scale, ...]:
    """One scale for each of several bodies that are drawn alone: forces compare on the page, and
    lengths too where the bodies' sizes allow it."""
    sizes, whole = [size_of(body) for body in bodies], scale_of(bodies, 1.0)
    if max(sizes) <= _ALIKE * min(sizes):
        sizes = [max(sizes)] * len(sizes)
    return tuple(replace(whole, longest=_LONGEST * size) for size in sizes)


def size_of(loads: BodyLoads) -> float:
    """The size of a body as it is drawn, with the points where forces act on it, metres."""
    drawn = structure.bars(loads.body, rod=len(loads.body.origin) == 3)
    ends = [place for _, segment in drawn for place in segment]
    places = np.array([*(load.place for load in loads.loads), *ends])
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return size if size > 1e-3 else 0.1


# ---------------------------------------------------------------- one body
@of_each
def _points(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Write the names of a body's joints and of the tip."""
    along, names = seen.heading(body), seen.names
    drawing.write(body.origin, names.point(seen.pose, body.number), -along)
    for child in _children(seen, body):
        drawing.write(child.origin, names.point(seen.pose, child.number), along)
    for end in body.ends:
        if end.child is None and end.name == seen.model.tip and names.tip:
            drawing.mark(end.place, "dot", names.tip, "position-head", 3.5)
            drawing.write(end.place, names.tip, along)


@of_each
def _axes(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw the axes of a body's joints."""
    longest = _AXIS * size_of(seen.loads[body.index])
    geometry.axes(drawing, seen, (body, *_children(seen, body)), longest=longest)


@of_each
def _angles(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw the angle of a body's joint."""
    geometry.angles(drawing, seen, (body,), longest=_ANGLE * size_of(seen.loads[body.index]))


PARTS: dict[str, Layer] = {
    "points": _points,
    "centres": geometry.centres,
    "angles": _angles,
    "lengths": partial(geometry.all_lengths, least=0.0),
    "s": partial(geometry.links, aside=_BESIDE, least=0.0),
    "r": partial(geometry.links, aside=_BESIDE, letter="r", least=0.0),
    "sc": partial(geometry.to_centres, aside=-_BESIDE),
    "axes": _axes,
}
"""Parts of a free body that may be shown beside the forces: its geometry, and the vectors s_i (or
r_i) and s_ci."""
BOOK = {2: ("points", "centres", "s", "sc"), 3: ("axes", "centres", "s", "sc")}
"""Parts that books show, in the plane and in space."""


def alone(
    seen: Snapshot, body: BodyPlace, show: Sequence[str], scale: Scale, inertia: bool = False
) -> Drawing:
    """A drawing of a body in its pose, with the forces on it. show: names of `PARTS`; inertia: with
    m a_c, the sum of the forces."""
    title = f"Free-body diagram of body {body.number}, {body.name}"
    drawing, loads = Drawing(_view(seen, body), title), seen.loads[body.index]
    _stick(drawing, seen, body)
    for part in show:
        PARTS[part](drawing, seen, (body,))
    if body.mass > 0 and "centres" not in show:
        drawing.mark(body.com, "com", seen.names.on("C", body.number), "com", 6.0)
    for load in loads.loads:
        _reach(drawing, body, load)
    act(drawing, seen, body, scale=scale)
    value = loads.inertial_force
    if inertia and np.linalg.norm(value) > 0.01 * scale.force:
        mass, end = loads.mass_name, scale.end(body.com, value)
        label = f"{mass} *a*_{body.number}"
        drawing.arrow(body.com, end, f"{mass} a_{body.number}", "inertia", value, "N", label=label)
    _side_by_side(drawing, scale.longest)
    return drawing


def _view(seen: Snapshot, body: BodyPlace) -> View:
    """The view of a body: that of the whole robot, if it shows the body in its length; else the
    body's own."""
    view, loads = view_of(seen), seen.loads[body.index].loads
    places = [body.origin, *(end.place for end in body.ends), *(load.place for load in loads)]
    ways = [(a, b) for k, a in enumerate(places) for b in places[:k]]
    if seen.model.dim == 2 or not ways:
        return view
    longest = max(ways, key=lambda way: float(np.linalg.norm(way[1] - way[0])))
    return view if view.shown(*longest) >= _SEEN else best_view([longest])


def _stick(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw a body and the joints at which it is cut free."""
    closing = _closing(seen, body)
    if seen.model.dim == 2:
        drawing.add(*structure.link(body), *structure.joint(body))
        for child in _children(seen, body):
            drawing.mark(child.origin, "joint", child.symbol, "joint", 5.0)
        for loop in closing:
            drawing.add(*structure.joint(loop))
        return
    radius = 0.05 * size_of(seen.loads[body.index])
    parts = structure.solids_of(body, radius)
    for place in (*_children(seen, body), *closing):
        parts += structure.joint(place, radius)
    drawing.add(*sorted(parts, key=lambda e: structure.depth(e, drawing.view)))


def _closing(seen: Snapshot, body: BodyPlace) -> list[DrawnJoint]:
    """The loops that close at a body, at the places where they meet it."""
    loops = seen.pose.loops
    first = [replace(loop, origin=loop.carrier) for loop in loops if loop.parent == body.index]
    return [*first, *(replace(x, carrier=x.origin) for x in loops if x.index == body.index)]


def _children(seen: Snapshot, body: BodyPlace) -> list[BodyPlace]:
    """The children of a body whose joints are elsewhere than its own."""
    below = [child for child in seen.pose.bodies if child.parent == body.index]
    return [child for child in below if np.linalg.norm(child.origin - body.origin) > SAME]


def _reach(drawing: Drawing, body: BodyPlace, load: Load) -> None:
    """Draw a guide line to a force that acts beside the body's bar, such as on a slider along its
    rail."""
    ends = [body.origin, body.com, *(end.place for end in body.ends)]
    nearest = min(ends, key=lambda place: float(np.linalg.norm(place - load.place)))
    if np.linalg.norm(nearest - load.place) > SAME:
        drawing.line((nearest, load.place), f"reach {load.name}", "guide")


def _side_by_side(drawing: Drawing, longest: float) -> None:
    """Move apart forces and moments that would lie on each other on the page, across their common
    line."""
    lanes: list[tuple[complex, complex, int]] = []

    def aside(arrow: Arrow) -> float:
        a, b = map(drawing.view.on_page, (arrow.start, arrow.end))
        if abs(b - a) < SAME * longest:
            return arrow.aside
        along = (b - a) / abs(b - a)

        def on(c: complex, d: complex) -> bool:
            seen = (c - a) / along, (d - a) / along
            low, high = sorted(place.real for place in seen)
            overlap = min(high, abs(b - a)) - max(low, 0.0)
            across = max(abs(place.imag) for place in seen)
            beside = across < 0.04 * longest and overlap > 0.06 * longest
            return beside or abs(d - b) < 0.05 * longest  # or head to head

        taken = {lane for c, d, lane in lanes if on(c, d)}
        outwards = sorted(range(-len(lanes), len(lanes) + 1), key=abs)
        lane = next(k for k in outwards if k not in taken)
        lanes.append((a, b, lane))
        ahead = 1.0 if (round(along.real, 6), -round(along.imag, 6)) > (0.0, 0.0) else -1.0
        return ahead * lane * _LANE + 0.0

    for k, element in enumerate(drawing.elements):
        if isinstance(element, Arrow) and element.unit in _LOADS:
            drawing.elements[k] = replace(element, aside=aside(element))


# ---------------------------------------------------------------- what acts
def act(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, roles: Sequence[str] = tuple(FORCES),
    scale: Scale | None = None,
) -> None:  # fmt: skip
    """Draw the forces and moments on a body that have the given roles: of its parent, its children,
    its weight, from outside. The default scale is one for all bodies of a robot."""
    scale = scale_of(seen.loads, 0.38 * seen.size) if scale is None else scale
    for load in seen.loads[body.index].loads:
        if load.role not in roles or (load.role == "weight" and not seen.names.weights):
            continue
        name, moment_name = seen.names.acting(load, body)
        if any(load.force):
            label = f"{name.removesuffix('g')}*g*" if load.role == "weight" else None
            end, role = scale.end(load.place, load.force), FORCES[load.role]
            drawing.arrow(load.place, end, name, role, load.force, "N", label=label)
        if moment_name and any(load.moment):
            role, unit = FORCES["moment"], "N m"
            if seen.model.dim == 2:
                facing = _facing(seen, body, load)
                value = float(load.moment[0])
                turn = Turn(point(load.place), value, moment_name, role, moment_name, unit, *facing)
                drawing.add(turn)
            else:
                end = scale.end(load.place, load.moment, turning=True)
                drawing.arrow(load.place, end, moment_name, role, load.moment, unit, heads=2)


def _facing(seen: Snapshot, body: BodyPlace, load: Load) -> tuple[float, float]:
    """The radius (pixels) and the direction (degrees) of the arc of a moment in the plane, on the
    outer side of the body's end."""
    at_joint = np.linalg.norm(load.place - body.origin) < SAME
    outward = seen.heading(body) * (-1.0 if at_joint and load.role != "counter" else 1.0)
    radius = 27.0 if at_joint and load.role == "counter" else 19.0
    return radius, math.degrees(math.atan2(outward[1], outward[0]))


# ---------------------------------------------------------------- several bodies
def carried(seen: Snapshot, first: BodyPlace) -> Drawing:
    """A drawing of a planar body with all that it carries as one system: the reaction at its joint,
    all weights, and the loads on the tip."""
    drawing = Drawing(view_of(seen), f"All that joint {first.number} of {seen.model.name} carries")
    system = _subtree(seen, first)
    for body in system:
        if body.kind.slides and body is not first:
            drawing.line((body.carrier, body.origin), f"rod {body.number}", "rail")
        _stick(drawing, seen, body)
    for body in system:
        _points(drawing, seen, (body,))
        geometry.centres(drawing, seen, (body,))
        reactions = ("reaction",) if body is first else ()
        act(drawing, seen, body, (*reactions, "weight", "external"))
        if body is not first and body.mass > 0:
            drawing.position(first.origin, body.com, f"r_{{{first.number},c{body.number}}}")
    geometry.to_centres(drawing, seen, (first,), aside=-_BESIDE)
    _side_by_side(drawing, 0.38 * seen.size)
    return drawing


def _subtree(seen: Snapshot, first: BodyPlace) -> list[BodyPlace]:
    """A body and all bodies that it carries."""
    below = [b for b in seen.pose.bodies if b.parent == first.index]
    return [first, *(b for child in below for b in _subtree(seen, child))]


# ---------------------------------------------------------------- bodies that nothing holds
def pushed(seen: Snapshot, body: BodyPlace, thrusts: Mapping[str, str], mass: str) -> Drawing:
    """A drawing of a body that nothing holds, with its axes, its weight and thrusts along the z
    axes of frames on it, by name, drawn so long that they carry the weight; mass: its printed
    name."""
    drawing = Drawing(view_of(seen), f"Body {body.number}, {body.name}, that nothing holds")
    _stick(drawing, seen, body)
    size = 0.5 * size_of(seen.loads[body.index])
    structure.triad(drawing, body.origin, body.rotation, size, "xyz")
    drawing.centre(body.com, "C", (0.0, -1.0, -1.0))
    weight = body.mass * seen.model.gravity
    largest = float(np.linalg.norm(weight)) or 1.0
    for k, (name, frame) in enumerate(thrusts.items(), 1):
        _, turned, at = seen.model.tree.frames[frame]
        place = body.origin + body.rotation @ np.asarray(at, dtype=float)
        value = body.rotation @ np.asarray(turned, dtype=float)[:, 2] * largest / len(thrusts)
        end = place + 1.6 * size * value / largest
        drawing.arrow(body.com, place, f"s_{k}", "position", place - body.com, "m", beside=0.5)
        drawing.arrow(place, end, name, FORCES["external"], value, "N", label=name)
    if seen.names.weights and any(weight):
        end = body.com + 1.6 * size * weight / largest
        label = f"{mass} *g*"
        drawing.arrow(body.com, end, f"{mass} g", FORCES["weight"], weight, "N", label=label)
    drawing.notes = ["Thrusts that carry the weight" if thrusts else "Axes and weight"]
    return drawing
