"""Free bodies: one alone with all that acts on it, one with all that it carries, or all pulled
apart at the joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from freebody.arrays import Array
from freebody.figures.body_loads import BodyLoads, Load
from freebody.figures.colours import FORCES
from freebody.figures.drawing import SAME, Arrow, Dimension, Drawing, Element, Line, Turn, point
from freebody.figures.joint_symbols import flat_joint, solid_joint
from freebody.figures.layers import axes, geometry, space, vectors
from freebody.figures.layers.force_scale import (
    Scale,
    common_or_own_scales,
    extent_with_forces,
    scale_of,
)
from freebody.figures.layers.plane import add_body, letter
from freebody.figures.layers.structure import Layer, of_each, view_of
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

_GAP = 0.34
_BESIDE = vectors.BESIDE + 2
_AXIS, _ANGLE = 0.45, 0.4  # the longest axis and arc beside the forces, of the size of the body


# ---------------------------------------------------------------- one body
@of_each
def _points(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """Names of a body's joints and of the tip."""
    along = seen.heading(body)
    drawing.write(body.origin, letter(seen, names, body.number), -along)
    for child in _children(seen, body):
        drawing.write(child.origin, letter(seen, names, child.number), along)
    for end in body.ends:
        if end.child is None and end.name == seen.model.tip and names.tip:
            drawing.mark(end.place, "dot", names.tip, "position-head", 3.5)
            drawing.write(end.place, names.tip, along)


@of_each
def _axes(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """The axes of a body's joints."""
    longest = _AXIS * extent_with_forces(seen.loads[body.index])
    axes.joint_axes(drawing, seen, names, (body, *_children(seen, body)), longest=longest)


@of_each
def _angles(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """The angle of a body's joint."""
    longest = _ANGLE * extent_with_forces(seen.loads[body.index])
    geometry.angles(drawing, seen, names, (body,), longest=longest)


PARTS: dict[str, Layer] = {
    "points": _points,
    "centres": geometry.centres,
    "angles": _angles,
    "lengths": partial(geometry.all_lengths, least=0.0),
    "s": partial(vectors.links, aside=_BESIDE, least=0.0),
    "r": partial(vectors.links, aside=_BESIDE, letter="r", least=0.0),
    "sc": partial(vectors.to_centres, aside=-_BESIDE),
    "axes": _axes,
}
"""What may be shown of a free body beside the forces: its geometry, and the vectors s_i (or r_i)
and s_ci."""
BOOK = {2: ("points", "centres", "s", "sc"), 3: ("axes", "centres", "s", "sc")}
"""What books show, in the plane and in space."""


def alone(
    seen: Snapshot,
    body: BodyPlace,
    names: Names,
    show: Sequence[str],
    scale: Scale | None = None,
) -> Drawing:
    """One body where it is; show: of `PARTS`. Default scale: that of `common_or_own_scales`."""
    drawing = Drawing(view_of(seen), f"Free-body diagram of body {body.number}, {body.name}")
    scale = common_or_own_scales(seen.loads)[body.index] if scale is None else scale
    _stick(drawing, seen, body)
    for part in show:
        PARTS[part](drawing, seen, names, (body,))
    if body.mass > 0 and "centres" not in show:
        drawing.mark(body.com, "com", names.on("C", body.number), "com", 6.0)
    for load in seen.loads[body.index].loads:
        _reach(drawing, body, load)
    act(drawing, seen, body, names, scale=scale)
    return drawing


def _stick(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """A body and the joints that it is cut at."""
    if seen.model.dim == 2:
        add_body(drawing, body)
        drawing.add(*flat_joint(body))
        for child in _children(seen, body):
            drawing.mark(child.origin, "joint", f"joint {child.number}", "joint", 5.0)
        return
    radius = 0.05 * extent_with_forces(seen.loads[body.index])
    parts = [*space.solids_of(body, radius)]
    for child in _children(seen, body):
        parts += solid_joint(child, radius)
    drawing.add(*sorted(parts, key=lambda e: space.depth(e, drawing.view)))


def _children(seen: Snapshot, body: BodyPlace) -> list[BodyPlace]:
    """Those whose joints are elsewhere than the body's own."""
    below = [child for child in seen.pose.bodies if child.parent == body.index]
    return [child for child in below if np.linalg.norm(child.origin - body.origin) > SAME]


def _reach(drawing: Drawing, body: BodyPlace, load: Load) -> None:
    """A guide to where a force acts off the stick: on a slider along its rail, on a frame beside
    it."""
    ends = [body.origin, body.com, *(end.place for end in body.ends)]
    nearest = min(ends, key=lambda place: float(np.linalg.norm(place - load.place)))
    if np.linalg.norm(nearest - load.place) > SAME:
        drawing.line((nearest, load.place), f"reach {load.name}", "guide")


# ---------------------------------------------------------------- what acts
def act(
    drawing: Drawing,
    seen: Snapshot,
    body: BodyPlace,
    names: Names,
    roles: Sequence[str] = tuple(FORCES),
    scale: Scale | None = None,
) -> None:
    """The forces and moments on a body: of its parent, its children, its weight, from outside;
    default scale: one for all bodies of a robot."""
    scale = scale_of(seen.loads, 0.38 * seen.size) if scale is None else scale
    for load in seen.loads[body.index].loads:
        if load.role not in roles or (load.role == "weight" and not names.weights):
            continue
        name, moment_name = names.acting(load, body)
        if any(load.force):
            label = f"{name.removesuffix('g')}*g*" if load.role == "weight" else None
            end = scale.arrow(load.place, load.force, scale.force)
            role = FORCES[load.role]
            drawing.arrow(load.place, end, name, role, load.force, "N", label=label)
        if moment_name and any(load.moment):
            if seen.model.dim == 2:
                _turn(drawing, seen, body, load, moment_name)
            else:
                end = scale.arrow(load.place, load.moment, scale.moment, 0.75)
                role, unit = FORCES["moment"], "N m"
                drawing.arrow(load.place, end, moment_name, role, load.moment, unit, heads=2)


def _turn(drawing: Drawing, seen: Snapshot, body: BodyPlace, load: Load, name: str) -> None:
    """A moment in the plane, on the outer side of the body's end."""
    at_joint = np.linalg.norm(load.place - body.origin) < SAME
    outward = seen.heading(body) * (-1.0 if at_joint and load.role != "counter" else 1.0)
    facing = math.degrees(math.atan2(outward[1], outward[0]))
    radius = 27.0 if at_joint and load.role == "counter" else 19.0
    value = float(load.moment[0])
    turn = Turn(point(load.place), value, name, FORCES["moment"], name, "N m", radius, facing)
    drawing.add(turn)


def inertia(drawing: Drawing, loads: BodyLoads, scale: Scale) -> None:
    """m a_c, dashed: what the forces add up to."""
    value, com, n = loads.inertial_force, loads.body.com, loads.body.number
    if np.linalg.norm(value) > 0.01 * scale.force:
        end, label = scale.arrow(com, value, scale.force), f"{loads.mass_name} *a*_{n}"
        drawing.arrow(com, end, f"{loads.mass_name} a_{n}", "inertia", value, "N", label=label)


# ---------------------------------------------------------------- several bodies
def carried(seen: Snapshot, first: BodyPlace, names: Names) -> Drawing:
    """A body of a planar robot with all that hangs on it as one system: the reaction at its joint,
    all weights, what acts on the tip."""
    drawing = Drawing(view_of(seen), f"All that joint {first.number} of {seen.model.name} carries")
    system = _subtree(seen, first)
    for body in system:
        if body.kind.slides and body is not first:
            drawing.line((body.carrier, body.origin), f"rod {body.number}", "rail")
        _stick(drawing, seen, body)
    for body in system:
        _points(drawing, seen, names, (body,))
        geometry.centres(drawing, seen, names, (body,))
        reactions = ("reaction",) if body is first else ()
        act(drawing, seen, body, names, (*reactions, "weight", "external"))
        if body is not first and body.mass > 0:
            name = f"r_{{{names.index(first.number)},c{names.index(body.number)}}}"
            drawing.position(first.origin, body.com, name)
    vectors.to_centres(drawing, seen, names, (first,), aside=-_BESIDE)
    return drawing


def _subtree(seen: Snapshot, first: BodyPlace) -> list[BodyPlace]:
    """A body and all that hangs on it."""
    below = [b for b in seen.pose.bodies if b.parent == first.index]
    return [first, *(b for child in below for b in _subtree(seen, child))]


def apart(
    seen: Snapshot, names: Names, show: Sequence[str] = ("s", "sc"), scaled: bool = False
) -> Drawing:
    """All bodies of a planar robot, drawn apart by a gap at each joint; `drawing.moved` says how
    far each is moved.

    show: of `PARTS`, beside points and centres. scaled: with a bar for the forces.
    """
    drawing = Drawing(view_of(seen), f"Free-body diagrams of the links of {seen.model.name}")
    shift: dict[int, Array] = {-1: np.zeros(2)}
    scale = scale_of(seen.loads, 0.38 * seen.size)
    for body in seen.pose.bodies:
        gap = np.zeros(2) if body.parent < 0 else _gap(seen, body)
        shift[body.index] = shift[body.parent] + gap
        part = alone(seen, body, names, ("points", "centres", *show), scale)
        drawing.add(*(moved(element, shift[body.index]) for element in part.elements))
        drawing.moved[body.number] = point(shift[body.index])
    if scaled:
        drawing.rulers.append(scale.bar("reaction"))
    return drawing


def _gap(seen: Snapshot, body: BodyPlace) -> Array:
    """From a body to its child, along both, or across them where they are folded together."""
    before, after = seen.heading(seen.pose.bodies[body.parent]), seen.heading(body)
    way = before + after
    if np.linalg.norm(way) < 0.3:
        way = np.array([-before[1], before[0]])
    return _GAP * seen.size * way / np.linalg.norm(way)


def moved(element: Element, by: Array) -> Element:
    """An element elsewhere in the plane."""
    if isinstance(element, Line):
        return replace(element, points=tuple(point(np.add(p, by)) for p in element.points))
    fields = ("start", "end") if isinstance(element, Arrow | Dimension) else ("at",)
    return replace(element, **{f: point(np.add(getattr(element, f), by)) for f in fields})
