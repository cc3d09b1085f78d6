"""A planar arm without numbers: ground, bars, joints, centres of mass, angles, slides, lengths,
axes."""

from __future__ import annotations

import math
from itertools import count, islice

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import (
    FLAT,
    Arc,
    Arrow,
    Dimension,
    Drawing,
    Label,
    Line,
    Mark,
    Point,
    point,
)
from freebody.figures.joints import flat_joint
from freebody.figures.names import Names
from freebody.figures.plane import add_body
from freebody.figures.skeleton import BodyPlace
from freebody.figures.sketch.snapshot import Snapshot
from freebody.trees.kinematics import forward_kinematics

_AXIS = 0.3
"""Length of the world's axes, of the drawing's size."""
_ARC = 0.15
"""Radius of an angle's arc, of the drawing's size."""
_NEAR = 1e-6  # metres: places nearer than this are one


def blank(title: str) -> Drawing:
    """A drawing in the plane with formulas for labels."""
    return Drawing(FLAT, title, formulas=True)


def structure(drawing: Drawing, seen: Snapshot, names: Names, faint: bool = False) -> None:
    """Ground, links and joints of an arm, its axes x and y, and the names of its joints; faint:
    vectors lie on it."""
    for root in seen.pose.roots:
        support(drawing, root, seen.size)
    axes(drawing, seen.size, share=_axis_share(seen))
    for body in seen.pose.bodies:
        rod(drawing, body)
        if faint:
            outline = [
                Line((point(a), point(b)), f"link {body.number}", "ghost") for a, b in body.outline
            ]
            drawing.add(*outline)
        else:
            add_body(drawing, body)
    for body in seen.pose.bodies:
        drawing.add(*flat_joint(body))
    closures(drawing, seen)
    if seen.pose.tip is not None:
        drawing.add(Mark(point(seen.pose.tip), "dot", names.tip, "position-head", size=3.5))
    points(drawing, seen, names)


def _axis_share(seen: Snapshot) -> float:
    """Length of the axes, of the drawing's size; where the base's slide lies on one, its head stays
    off the block."""
    slides = [float(np.linalg.norm(r.origin)) for r in seen.pose.roots if r.kind.slides]
    return min([_AXIS, *(0.65 * d / seen.size for d in slides if d > 0.15 * seen.size)])


def axes(drawing: Drawing, size: float, origin: Point = (0.0, 0.0), share: float = _AXIS) -> None:
    """World axes x and y from the origin."""
    for name, (u, v) in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
        end = (origin[0] + share * size * u, origin[1] + share * size * v)
        drawing.add(
            Arrow(origin, end, name, "soft"), Label(end, name, f"label {name}", direction=(u, v))
        )


def support(drawing: Drawing, root: BodyPlace, size: float) -> None:
    """The ground: a pedestal under a turn, a hatched guide under a slide; nothing holds what moves
    freely."""
    if not root.kind.holds:
        return
    if root.kind.slides and root.axis is not None:
        half = 0.5 * float(np.linalg.norm(root.origin - root.carrier)) + 0.12 * size
        middle = (root.origin + root.carrier) / 2
        below = point(root.axis if root.axis[0] >= 0 else -root.axis)
        ends = point(middle - half * root.axis), point(middle + half * root.axis)
        drawing.add(Line(ends, "ground", "rail"))
        drawing.add(
            *hatch(
                np.array(ends[0]), np.array(ends[1]), np.array([below[1], -below[0]]), 0.03 * size
            )
        )
    else:
        drawing.add(Mark(point(root.carrier), "ground", "ground", "ground", (0.0, 1.0), 9.0))


def hatch(a: Array, b: Array, into: Array, depth: float) -> list[Line]:
    """Strokes from a line into the ground."""
    count = max(int(np.linalg.norm(b - a) / depth / 0.9), 2)
    along = (b - a) / count
    back = depth * (into - 0.7 * along / np.linalg.norm(along))
    return [
        Line((point(a + k * along), point(a + k * along + back)), "hatch", "hatch")
        for k in range(1, count + 1)
    ]


def rod(drawing: Drawing, body: BodyPlace) -> None:
    """What a slide runs on, from where it begins; the ground's guide is drawn by `support`."""
    if body.kind.slides and body.parent >= 0:
        drawing.add(Line((point(body.carrier), point(body.origin)), f"rod {body.number}", "rail"))


def points(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Names of the joints and of the tip, away from the links that meet there; one name a place,
    the tip's first."""
    bodies = seen.pose.bodies
    taken = [] if seen.pose.tip is None else [seen.pose.tip]
    for body in bodies:
        if all(np.linalg.norm(body.origin - place) > _NEAR for place in taken):
            text = letter(seen, names, body.number)
            drawing.add(
                Label(point(body.origin), text, f"label {text}", direction=clear_way(seen, body))
            )
            taken.append(body.origin)
    for name in filter(_is_letter, seen.model.frame_names):
        place = np.asarray(forward_kinematics(seen.model, seen.q, name))[:2, 2]
        if all(np.linalg.norm(place - other) > _NEAR for other in taken):
            drawing.add(Label(point(place), name, f"label {name}", direction=(-0.6, 0.8)))
            taken.append(place)
    if seen.pose.tip is not None and names.tip:
        last = bodies[-1]
        away = seen.pose.tip - last.origin
        direction = point(away) if np.linalg.norm(away) > _NEAR else (1.0, 1.0)
        drawing.add(
            Label(point(seen.pose.tip), names.tip, f"label {names.tip}", direction=direction)
        )


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
    at_origin = float(np.linalg.norm(seen.pose.bodies[0].origin)) < _NEAR
    free = (name for k in count(1 if at_origin else 2) if (name := names.point(k)) not in taken)
    before = sum(body.number not in given for body in seen.pose.bodies if body.number < n)
    return next(islice(free, before, None))


def _is_letter(name: str) -> bool:
    return len(name) == 1 and name.isupper()


def closures(drawing: Drawing, seen: Snapshot) -> None:
    """Where loops are closed: a pin, or a rod between two places."""
    for loop in seen.model.loops:
        a, b = (forward_kinematics(seen.model, seen.q, name)[:2, 2] for name in loop.frames)
        if np.linalg.norm(b - a) > _NEAR:
            drawing.add(Line((point(a), point(b)), loop.name, "rail"))
        for place in (a, b):
            drawing.add(Mark(point(place), "joint", loop.name, "joint", size=6.0))


def clear_way(seen: Snapshot, body: BodyPlace) -> Point:
    """The direction from a joint in which nothing of the arm lies."""
    after = heading(seen, body)
    if body.parent < 0:  # between the link and the foot of the pedestal that is farther from it
        at = math.degrees(math.atan2(after[1], after[0])) % 360
        foot = 240.0 if at < 90 or at > 270 else -60.0
        middle = math.radians(((at if at <= 270 else at - 360) + foot) / 2)
        return (math.cos(middle), math.sin(middle))
    before = -heading(seen, seen.pose.bodies[body.parent])
    away = -(after + before)
    return point(away) if np.linalg.norm(away) > 0.1 else (-float(after[1]), float(after[0]))


def heading(seen: Snapshot, body: BodyPlace) -> Array:
    """Unit vector along a body, from its joint outwards."""
    end = seen.end(body)
    for place in (end, body.com):
        if place is not None and np.linalg.norm(place - body.origin) > _NEAR:
            return (place - body.origin) / np.linalg.norm(place - body.origin)
    return body.rotation[:, 0]


def centres(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """Centres of mass with their names."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            name, along = names.on("C", body.number), heading(seen, body)
            right = (float(along[1]), -float(along[0]))
            drawing.add(Mark(point(body.com), "com", name, "com", size=6.0))
            drawing.add(Label(point(body.com), name, f"label {name}", direction=right))


def angles(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """θ_1 from the x axis, further ones from the line of the link before."""
    for body in seen.pose.bodies:
        if body.kind.turns:
            name = names.coordinate(body)
            if name:
                angle(drawing, body, _ARC * seen.size, name)


def angle(drawing: Drawing, body: BodyPlace, reach: float, name: str) -> None:
    """A joint's angle: dashed where it starts, an arc with a head where it ends."""
    before = math.atan2(body.carrier_rotation[1, 0], body.carrier_rotation[0, 0])
    now = math.atan2(body.rotation[1, 0], body.rotation[0, 0])
    turned = math.remainder(now - before, 2 * math.pi)
    end = body.origin + 1.5 * reach * np.array([math.cos(before), math.sin(before)])
    drawing.add(Line((point(body.origin), point(end)), f"reference {name}", "guide"))
    drawing.add(Arc(point(body.origin), reach, before, turned, name, label=name))


def slides(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """d_i, from where a slide begins to the joint's block."""
    for body in seen.pose.bodies:
        if body.kind.slides and np.linalg.norm(body.origin - body.carrier) > _NEAR:
            name = names.coordinate(body)
            ends = point(body.carrier), point(body.origin)
            drawing.add(Dimension(*ends, name, label=name, aside=-_clear_side(seen, body) * 20.0))


def lengths(drawing: Drawing, seen: Snapshot, names: Names, aside: float = 14.0) -> None:
    """l_i, on the side where no angle is."""
    for body in seen.pose.bodies:
        for end in body.ends[:1]:
            _length(drawing, seen, body, end.place, names.length(body, end), aside)


def all_lengths(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """l_ci next to each link, l_i farther out."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            _length(drawing, seen, body, body.com, names.centre_length(body), 12.0)
    lengths(drawing, seen, names, 27.0)


def _length(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, place: Array, name: str, aside: float
) -> None:
    if name and np.linalg.norm(place - body.origin) > 0.05 * seen.size:
        side = _clear_side(seen, body) * aside
        drawing.add(Dimension(point(body.origin), point(place), name, label=name, aside=side))


def _clear_side(seen: Snapshot, body: BodyPlace) -> float:
    """1: left of a body, -1: right of it; an angle is drawn behind the turn that made it."""
    if body.kind.slides:
        return 1.0 if not body.parent >= 0 else _clear_side(seen, seen.pose.bodies[body.parent])
    turned = float(
        body.carrier_rotation[0, 0] * body.rotation[1, 0]
        - body.carrier_rotation[1, 0] * body.rotation[0, 0]
    )
    return 1.0 if turned >= 0 else -1.0


def inertias(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """(m_i, I_i) beside the links."""
    for body in seen.pose.bodies:
        if body.mass > 0:
            text = f"{names.mass(body.number)}, {names.inertia(body.number)}"
            along = heading(seen, body)
            place = body.com + 0.1 * seen.size * along
            right = (float(along[1]), -float(along[0]))
            drawing.add(Label(point(place), text, text, direction=right))
