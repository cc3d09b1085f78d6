"""Free bodies of a planar arm with the names of the forces: one alone, or all pulled apart at the
joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Drawing, Element, Label, Line, Mark, Turn, places, point
from freebody.figures.joints import flat_joint
from freebody.figures.loads import Load
from freebody.figures.names import Names, bold
from freebody.figures.plane import add_body, round_down
from freebody.figures.skeleton import BodyPlace
from freebody.figures.sketch import vectors
from freebody.figures.sketch.arm import blank, heading, letter, rod
from freebody.figures.sketch.snapshot import Snapshot
from freebody.figures.text import number

_LONGEST, _SHORTEST = 0.38, 0.09  # of the drawing's size
_GAP = 0.34
_NOTHING = 1e-6
_ROLES = {"reaction": "reaction", "counter": "reaction", "weight": "weight", "external": "external"}


def apart(
    seen: Snapshot, names: Names, show: Sequence[str] = ("s", "sc"), scaled: bool = False
) -> Drawing:
    """All bodies, drawn apart by a gap at each joint; `drawing.moved` says how far each is moved.

    show: "s" vectors from joint to joint, "sc" to the centres of mass. scaled: with a bar for the
    forces.
    """
    drawing = blank(f"Free-body diagrams of the links of {seen.model.name}")
    shift: dict[int, Array] = {}
    for body in seen.pose.bodies:
        shift[body.index] = (
            np.zeros(2) if body.parent < 0 else shift[body.parent] + _gap(seen, body)
        )
        part = _parts(seen, body, names, show)
        drawing.add(*(moved(element, shift[body.index]) for element in part.elements))
        drawing.moved[body.number] = point(shift[body.index])
    if scaled:
        _force_bar(drawing, seen)
    return drawing


def alone(
    seen: Snapshot, body: BodyPlace, names: Names, show: Sequence[str] = ("s", "sc")
) -> Drawing:
    """One body where it is."""
    return _parts(seen, body, names, show)


def carried(seen: Snapshot, first: BodyPlace, names: Names) -> Drawing:
    """A body with all that hangs on it as one system: the reaction at its joint, all weights, what
    acts on the tip."""
    drawing = blank(f"All that joint {first.number} of {seen.model.name} carries")
    system = subtree(seen, first)
    for body in system:
        rod(drawing, body)
        add_body(drawing, body)
    for body in system:
        _joints(drawing, seen, body, names)
    for body in system:
        reactions = ("reaction",) if body is first else ()
        act(drawing, seen, body, names, (*reactions, "weight", "external"))
        if body is not first and body.mass > 0:
            name = f"r_{{{names.index(first.number)},c{names.index(body.number)}}}"
            vectors.position(drawing, first.origin, body.com, name)
    vectors.position(
        drawing, first.origin, first.com, names.on("s", first.number, "c"), -vectors.BESIDE - 2
    )
    return drawing


def subtree(seen: Snapshot, first: BodyPlace) -> list[BodyPlace]:
    """A body and all that hangs on it."""
    below = [b for b in seen.pose.bodies if b.parent == first.index]
    return [first, *(b for child in below for b in subtree(seen, child))]


def _gap(seen: Snapshot, body: BodyPlace) -> Array:
    """From a body to its child, along both, or across them where they are folded together."""
    before, after = heading(seen, seen.pose.bodies[body.parent]), heading(seen, body)
    way = before + after
    if np.linalg.norm(way) < 0.3:
        way = np.array([-before[1], before[0]])
    return _GAP * seen.size * way / np.linalg.norm(way)


def _parts(seen: Snapshot, body: BodyPlace, names: Names, show: Sequence[str]) -> Drawing:
    drawing = blank(f"Free-body diagram of body {body.number} of {seen.model.name}")
    add_body(drawing, body)
    _joints(drawing, seen, body, names)
    _vectors(drawing, seen, body, names, show)
    for load in seen.loads[body.index].loads:
        _reach(drawing, body, load)
    act(drawing, seen, body, names)
    return drawing


def act(
    drawing: Drawing,
    seen: Snapshot,
    body: BodyPlace,
    names: Names,
    roles: Sequence[str] = ("reaction", "counter", "weight", "external"),
) -> None:
    """The forces and moments on a body: of its parent, its children, its weight, from outside."""
    scale = _scale(seen)
    for load in seen.loads[body.index].loads:
        if load.role in roles and (names.weights or load.role != "weight"):
            _force(drawing, seen, body, load, names, scale)


def _joints(drawing: Drawing, seen: Snapshot, body: BodyPlace, names: Names) -> None:
    drawing.add(*flat_joint(body))
    _named(drawing, body.origin, letter(seen, names, body.number), -heading(seen, body))
    for end in body.ends:
        if end.child is not None:
            child = seen.pose.bodies[end.child]
            if np.linalg.norm(child.origin - body.origin) > _NOTHING:
                if child.kind.slides:
                    drawing.add(
                        Line(
                            (point(end.place), point(child.origin)), f"rod {child.number}", "guide"
                        )
                    )
                drawing.add(
                    Mark(point(child.origin), "joint", f"joint {child.number}", "joint", size=5.0)
                )
                _named(
                    drawing, child.origin, letter(seen, names, child.number), heading(seen, body)
                )
        elif end.name == seen.model.tip and names.tip:
            drawing.add(Mark(point(end.place), "dot", names.tip, "position-head", size=3.5))
            _named(drawing, end.place, names.tip, heading(seen, body))
    if body.mass > 0:
        name = names.on("C", body.number)
        drawing.add(Mark(point(body.com), "com", name, "com", size=6.0))
        _named(drawing, body.com, name, np.array([-1.0, 1.0]))


def _named(drawing: Drawing, place: Array, text: str, direction: Array) -> None:
    drawing.add(Label(point(place), text, f"label {text}", direction=point(direction)))


def _vectors(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, names: Names, show: Sequence[str]
) -> None:
    for symbol in {"s", "r"} & set(show):
        for end, place in seen.reaches(body):
            vectors.position(
                drawing, body.origin, place, names.reach(body, end, symbol), vectors.BESIDE + 2
            )
    if "sc" in show and body.mass > 0:
        name = names.on("s", body.number, "c")
        vectors.position(drawing, body.origin, body.com, name, -vectors.BESIDE - 2)


def _reach(drawing: Drawing, body: BodyPlace, load: Load) -> None:
    """A guide to where an external force acts off the stick."""
    ends = [body.origin, body.com, *(end.place for end in body.ends)]
    nearest = min(ends, key=lambda place: float(np.linalg.norm(place - load.place)))
    if load.role == "external" and np.linalg.norm(nearest - load.place) > _NOTHING:
        drawing.add(Line((point(nearest), point(load.place)), f"reach {load.name}", "guide"))


def _force(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, load: Load, names: Names, scale: float
) -> None:
    """The arrow of a force, and that of the moment that goes with it."""
    name, moment_name = called(seen, body, load, names)
    size = float(np.linalg.norm(load.force))
    if size:
        length = max(size * scale, _SHORTEST * seen.size)
        end = load.place + load.force / size * length
        label = weight_label(name) if load.role == "weight" else bold(name)
        drawing.add(
            Arrow(
                point(load.place),
                point(end),
                name,
                _ROLES[load.role],
                label,
                point(load.force),
                "N",
            )
        )
    value = float(load.moment[0])
    if moment_name and value:
        outward = heading(seen, body) * (1.0 if load.role == "counter" else -1.0)
        facing = math.degrees(math.atan2(outward[1], outward[0]))
        radius = (
            27.0
            if load.role == "counter" and np.linalg.norm(load.place - body.origin) < _NOTHING
            else 19.0
        )
        drawing.add(
            Turn(
                point(load.place), value, moment_name, "moment", moment_name, "N m", radius, facing
            )
        )


def weight_label(name: str) -> str:
    """m_1 g with g as the vector it is."""
    return name.removesuffix("g") + "*g*"


def called(seen: Snapshot, body: BodyPlace, load: Load, names: Names) -> tuple[str, str]:
    """Names of a force and of its moment."""
    joint = load.joint
    kind = (
        seen.pose.bodies[joint].kind
        if joint is not None and joint < len(seen.pose.bodies)
        else None
    )
    return names.acting(load, body, kind)


def _scale(seen: Snapshot) -> float:
    """Metres a newton, one for all bodies."""
    longest = _most(seen)
    return _LONGEST * seen.size / longest if longest else 0.0


def _most(seen: Snapshot) -> float:
    return max((float(np.linalg.norm(x.force)) for b in seen.loads for x in b.loads), default=0.0)


def _force_bar(drawing: Drawing, seen: Snapshot) -> None:
    bar = round_down(max(_most(seen) / 2.5, 1e-9))
    drawing.rulers.append((bar * _scale(seen), f"{number(bar, 1)} N", "reaction"))


def moved(element: Element, by: Array) -> Element:
    """An element elsewhere in the plane."""

    def there(place: tuple[float, ...]) -> tuple[float, ...]:
        return point(np.asarray(place) + by)

    match element:
        case Line():
            return replace(element, points=tuple(map(there, places(element))))
        case Arrow():
            return replace(element, start=there(element.start), end=there(element.end))
        case Turn() | Mark() | Label():
            return replace(element, at=there(element.at))
        case _:
            raise TypeError(f"a free body has no {type(element).__name__}")
