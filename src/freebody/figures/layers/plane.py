"""A planar robot as textbooks draw it: ground, bars, joints, the names of places."""

from __future__ import annotations

import math
from itertools import count, islice

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import SAME, Drawing, Line, Mark, Point, point
from freebody.figures.joint_symbols import flat_joint
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

_AXIS = 0.3
"""Length of the world's axes, of the drawing's size."""


def structure(drawing: Drawing, seen: Snapshot, names: Names, faint: bool = False) -> None:
    """Ground, links and joints of a robot, the axes x and y, and the names of its joints; faint:
    vectors lie on the links."""
    for root in seen.pose.roots:
        support(drawing, root, seen.size)
    axes(drawing, seen.size, share=_axis_share(seen))
    for body in seen.pose.bodies:
        if body.kind.slides and body.parent >= 0:
            drawing.line((body.carrier, body.origin), f"rod {body.number}", "rail")
        if faint:
            for ends in body.outline:
                drawing.line(ends, f"link {body.number}", "ghost")
        else:
            add_body(drawing, body)
    for body in seen.pose.bodies:
        drawing.add(*flat_joint(body))
    closures(drawing, seen, "joint")
    if seen.pose.tip is not None:
        drawing.mark(seen.pose.tip, "dot", names.tip, "position-head", 3.5)
    points(drawing, seen, names)


def closures(drawing: Drawing, seen: Snapshot, symbol: str) -> None:
    """Where loops are closed: a symbol, or one at both ends of a rod."""
    for loop in seen.pose.loops:
        if np.linalg.norm(np.subtract(*loop.places)) > SAME:
            drawing.line(loop.places, loop.name, "rail")
        for place in loop.places:
            drawing.mark(place, symbol, loop.name, "joint", 6.0)


def add_body(drawing: Drawing, body: BodyPlace) -> None:
    """The bars of a link."""
    for name, ends in bars(body):
        drawing.line(ends, name, "link", width=11.0)


def bars(body: BodyPlace, rod: bool = False) -> list[tuple[str, tuple[Array, Array]]]:
    """Names and ends of a link's bars; rod: with what its joint has moved along."""
    away = body.kind.holds and np.linalg.norm(body.origin - body.carrier) > SAME
    ends = [(body.carrier, body.origin)] if rod and away else []
    more = [f"link {body.number}.{k}" for k in range(2, len(body.outline) + 2)]
    return list(zip([f"link {body.number}", *more], [*ends, *body.outline], strict=False))


def _axis_share(seen: Snapshot) -> float:
    """Length of the axes, of the drawing's size; where the base's slide lies on one, its head stays
    off the block."""
    slides = [float(np.linalg.norm(r.origin)) for r in seen.pose.roots if r.kind.slides]
    return min([_AXIS, *(0.65 * d / seen.size for d in slides if d > 0.15 * seen.size)])


def axes(drawing: Drawing, size: float, origin: Point = (0.0, 0.0), share: float = _AXIS) -> None:
    """World axes x and y from the origin."""
    for name, way in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
        end = np.add(origin, np.multiply(share * size, way))
        drawing.arrow(origin, end, name, "soft", label="")
        drawing.write(end, name, way)


def support(drawing: Drawing, root: BodyPlace, size: float) -> None:
    """The ground: a pedestal under a turn, a hatched guide under a slide; nothing holds what moves
    freely."""
    if not root.kind.holds:
        return
    if root.kind.slides and root.axis is not None:
        half = 0.5 * float(np.linalg.norm(root.origin - root.carrier)) + 0.12 * size
        middle = (root.origin + root.carrier) / 2
        x, y = root.axis if root.axis[0] >= 0 else -root.axis
        ends = middle - half * root.axis, middle + half * root.axis
        drawing.line(ends, "ground", "rail")
        drawing.add(*hatch(*ends, np.array([y, -x]), 0.03 * size))
    else:
        at = point(root.carrier)
        drawing.add(Mark(at, "ground", "ground", "ground", (0.0, 1.0), 9.0))


def hatch(a: Array, b: Array, into: Array, depth: float) -> list[Line]:
    """Strokes from a line into the ground."""
    count = max(int(np.linalg.norm(b - a) / depth / 0.9), 2)
    along = (b - a) / count
    back = depth * (into - 0.7 * along / np.linalg.norm(along))
    feet = [a + k * along for k in range(1, count + 1)]
    return [Line((point(foot), point(foot + back)), "hatch", "hatch") for foot in feet]


def points(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Names of the joints and of the tip, away from the links that meet there; one name a place,
    the tip's first."""
    taken = [] if seen.pose.tip is None else [seen.pose.tip]

    def write(place: Array, text: str, direction: Point) -> None:
        if all(np.linalg.norm(place - other) > SAME for other in taken):
            drawing.write(place, text, direction)
            taken.append(place)

    for body in seen.pose.bodies:
        write(body.origin, letter(seen, names, body.number), clear_way(seen, body))
    for name, place in seen.pose.frames.items():
        if _is_letter(name):
            write(place, name, (-0.6, 0.8))
    if seen.pose.tip is not None and names.tip:
        away = seen.pose.tip - seen.pose.bodies[-1].origin
        direction = away if np.linalg.norm(away) > SAME else (1.0, 1.0)
        drawing.write(seen.pose.tip, names.tip, direction)


def letter(seen: Snapshot, names: Names, n: int) -> str:
    """The name of joint n: its own where that is a capital letter, else the next that nothing else
    in the model has.

    O is kept for the origin, so that letters start with A where joint 1 is elsewhere.
    """
    own = [body.joint.name for body in seen.model.bodies]
    given = {seen.pose.bodies[k].number: name for k, name in enumerate(own) if _is_letter(name)}
    if n in given:
        return given[n]
    taken = {*given.values(), *filter(_is_letter, seen.model.frame_names)}
    at_origin = float(np.linalg.norm(seen.pose.bodies[0].origin)) < SAME
    free = (name for k in count(1 if at_origin else 2) if (name := names.point(k)) not in taken)
    before = sum(body.number not in given for body in seen.pose.bodies if body.number < n)
    return next(islice(free, before, None))


def _is_letter(name: str) -> bool:
    return len(name) == 1 and name.isupper()


def clear_way(seen: Snapshot, body: BodyPlace) -> Point:
    """The direction from a joint in which nothing of the arm lies."""
    after = seen.heading(body)
    if body.parent < 0:  # between the link and the foot of the pedestal that is farther from it
        at = math.degrees(math.atan2(after[1], after[0])) % 360
        foot = 240.0 if at < 90 or at > 270 else -60.0
        middle = math.radians(((at if at <= 270 else at - 360) + foot) / 2)
        return (math.cos(middle), math.sin(middle))
    before = -seen.heading(seen.pose.bodies[body.parent])
    away = -(after + before)
    return point(away) if np.linalg.norm(away) > 0.1 else (-float(after[1]), float(after[0]))
