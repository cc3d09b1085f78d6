"""One body of a robot in space with the names of all that acts on it, its vectors and its joints'
axes."""

from __future__ import annotations

import numpy as np

from freebody.figures import space
from freebody.figures.drawing import Arrow, Drawing, Element, Label, Line, Mark, View, point
from freebody.figures.joints import solid_joint
from freebody.figures.loads import BodyLoads
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.sketch import frames
from freebody.figures.sketch.forces import called
from freebody.figures.sketch.snapshot import Snapshot
from freebody.figures.sketch.vectors import arrow, position

_FORCE, _MOMENT, _AXIS = 0.6, 0.5, 0.34  # of the body's size: the longest of each
_SHORTEST = 0.12


def alone(
    seen: Snapshot, body: BodyPlace, names: Names, view: View, rates: bool = False
) -> Drawing:
    """A body between its joints, with s_i, s_ci, forces, moments; rates: with those of its
    joints."""
    drawing = frames.blank(f"Free-body diagram of body {body.number} of {seen.model.name}", view)
    size = extent(seen, body)
    children = [b for b in seen.pose.bodies if b.parent == body.index]
    parts: list[Element] = [*space.solids_of(body, 0.045 * size, 10.0)]
    for child in children:
        parts += [*_stub(child, size), *solid_joint(child, 0.045 * size)]
    drawing.add(*sorted(parts, key=lambda e: space.depth(e, view)))
    for link in (body, *children):
        axis(drawing, seen, link, names, size, rates)
    if body.mass > 0:
        name = names.on("C", body.number)
        drawing.add(Mark(point(body.com), "com", name, "com", size=6.0))
        drawing.add(Label(point(body.com), name, f"label {name}", direction=(0.0, 0.0, 1.0)))
        position(drawing, body.origin, body.com, names.on("s", body.number, "c"))
    for end, place in seen.reaches(body):
        position(drawing, body.origin, place, names.reach(body, end))
    act(drawing, seen, seen.loads[body.index], names, size)
    return drawing


def extent(seen: Snapshot, body: BodyPlace) -> float:
    """How large a body is: to its ends and its centre of mass; a share of the robot where it is
    smaller."""
    places = [end.place for end in body.ends] + [body.com]
    return max(0.25 * seen.size, *(float(np.linalg.norm(place - body.origin)) for place in places))


def _stub(child: BodyPlace, size: float) -> list[Line]:
    """The beginning of what hangs on a body, thin."""
    stubs = []
    for a, b in child.outline[:1]:
        reach = min(1.0, 0.25 * size / float(np.linalg.norm(b - a)))
        stubs.append(Line((point(a), point(a + reach * (b - a))), f"link {child.number}", "ghost"))
    return stubs


def axis(
    drawing: Drawing, seen: Snapshot, link: BodyPlace, names: Names, size: float, rate: bool
) -> None:
    """The axis of a joint with its unit vector; rate: and the joint's rate along it."""
    if link.axis is None:
        return
    slides = link.kind.slides
    at, along = link.origin, _AXIS * size * link.axis
    name = names.axis(link)
    drawing.add(Line((point(at - 0.8 * along), point(at)), f"axis {name}", "axisline"))
    drawing.add(Arrow(point(at), point(at + along), name, "z", name, point(link.axis)))
    if rate:
        value = float(seen.qd[seen.model.coordinates[link.index].v[0]])
        start, end = at + 1.2 * along, at + (1.2 + np.copysign(0.4, value)) * along
        name, (unit, heads) = names.coordinate(link, 1), ("m/s", 1) if slides else ("rad/s", 2)
        arrow(
            drawing, start, end, name, "velocity", value * link.axis, unit, label=name, heads=heads
        )


def act(drawing: Drawing, seen: Snapshot, loads: BodyLoads, names: Names, size: float) -> None:
    """Forces with one head and moments with two, each kind to its own scale."""
    longest = max((float(np.linalg.norm(x.force)) for x in loads.loads), default=0.0)
    peak = max((float(np.linalg.norm(x.moment)) for x in loads.loads), default=0.0)
    for load in loads.loads:
        if load.role == "weight" and not names.weights:
            continue
        force, moment = called(seen, loads.body, load, names)
        role = "reaction" if load.role in ("reaction", "counter") else load.role
        label = force.removesuffix("g") + "*g*" if load.role == "weight" else None
        value = float(np.linalg.norm(load.force))
        if value:
            end = load.place + max(value / longest, _SHORTEST) * _FORCE * size * load.force / value
            arrow(drawing, load.place, end, force, role, load.force, "N", label=label)
        value = float(np.linalg.norm(load.moment))
        if moment and value:
            end = load.place + max(value / peak, _SHORTEST) * _MOMENT * size * load.moment / value
            arrow(drawing, load.place, end, moment, "moment", load.moment, "N m", heads=2)
