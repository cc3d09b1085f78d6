"""Layers of a robot's geometry: angles, slides and lengths in the plane, joint axes z_i (u_i of
slides) and what lies between them in space; centres of mass, and position vectors: s_i from joint
to joint, r to the tip, s_ci and r_ci to the centres."""

from __future__ import annotations

import math

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import SAME, Arc, Dimension, Drawing, point
from freebody.figures.layers.bare_robot import of_each
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

BESIDE = 15.0
"""Distance at which a vector in the plane is drawn beside the link it lies on, pixels."""
_BELOW = 34.0
"""Distance below the ground at which its lengths are drawn, pixels."""
_ARC = 0.15
"""Radius of an angle's arc, of the drawing's size."""
_VISIBLE, _VECTOR = 0.05, 0.025
"""Lengths, and vectors in space, below these parts of the robot's size are not drawn."""
_PARALLEL = 1e-6


@of_each
def centres(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw centres of mass with their names."""
    if body.mass > 0:
        along = seen.heading(body)
        away = (along[1], -along[0]) if seen.model.dim == 2 else (0.0, 0.0, -1.0)
        drawing.centre(body.com, seen.names.on("C", body.number), away)


# ---------------------------------------------------------------- the plane
@of_each
def angles(drawing: Drawing, seen: Snapshot, body: BodyPlace, longest: float = math.inf) -> None:
    """Draw joint angles: θ_1 from the x axis, further ones from the line of the link before, with a
    dashed line where the angle starts and an arc of at most `longest` metres radius."""
    name = seen.names.coordinate(body)
    if not body.kind.turns or not name:
        return
    before = _zero_of_angle(seen, body)
    now = math.atan2(body.rotation[1, 0], body.rotation[0, 0])
    turned, reach = math.remainder(now - before, 2 * math.pi), min(_ARC * seen.size, longest)
    end = body.origin + 1.5 * reach * np.array([math.cos(before), math.sin(before)])
    drawing.line((body.origin, end), f"reference {name}", "guide")
    drawing.add(Arc(point(body.origin), reach, before, turned, name, label=name))


def _zero_of_angle(seen: Snapshot, body: BodyPlace) -> float:
    """The direction in which the angle of a joint is 0: along the body before, or as its notation
    has it."""
    notation, at = seen.names.naming.letters.notation, body.index
    above, first = seen.model.bodies[at].parent, at
    while above >= 0:
        first = above if seen.model.bodies[above].kind.turns else first
        above = seen.model.bodies[above].parent
    carrier = seen.pose.bodies[first if notation.absolute else at].carrier_rotation
    turned = notation.absolute or first == at
    return math.atan2(carrier[1, 0], carrier[0, 0]) + turned * notation.quarter_turns * math.pi / 2


@of_each
def slides(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw slides' positions d_i, from where a slide begins to the joint's block; those that reach
    below the ground below the lengths of a closed chain."""
    if body.kind.slides:
        below = body.parent < 0 and bool(seen.pose.loops)
        aside = -(50.0 if below else 20.0) * _clear_side(seen, body)
        _dimension(drawing, body.carrier, body.origin, seen.names.coordinate(body), aside, SAME)


@of_each
def lengths(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, aside: float = 14.0, least: float = _VISIBLE
) -> None:
    """Draw link lengths l_i on the side without an angle; least: the fraction of the robot's size
    below which a length is not drawn."""
    for end in body.ends[:1]:
        name, aside = seen.names.length(body, end), aside * _clear_side(seen, body)
        _dimension(drawing, body.origin, end.place, name, aside, max(least * seen.size, SAME))


@of_each
def all_lengths(drawing: Drawing, seen: Snapshot, body: BodyPlace, least: float = _VISIBLE) -> None:
    """Draw lengths l_ci to centres of mass next to each link and l_i farther out, once where they
    are equal; least: the fraction of the robot's size below which none is drawn."""
    name = seen.names.centre_length(body)
    same = any(
        name == seen.names.length(body, end) and np.linalg.norm(end.place - body.com) < SAME
        for end in body.ends[:1]
    )
    if body.mass > 0 and not same:
        aside = 12.0 * _clear_side(seen, body)
        _dimension(drawing, body.origin, body.com, name, aside, max(least * seen.size, SAME))
    lengths(drawing, seen, (body,), aside=46.0, least=least)


@of_each
def of_the_ground(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw the distance from the origin to a joint on the ground, below it, where the model has a
    name for it."""
    if body.parent < 0 and not body.kind.slides:
        name = seen.names.on_the_ground(body)
        aside = -_BELOW if body.carrier[0] >= 0 else _BELOW
        _dimension(
            drawing, np.zeros(seen.model.dim), body.carrier, name, aside, _VISIBLE * seen.size
        )


def of_rods(drawing: Drawing, seen: Snapshot) -> None:
    """Draw the lengths of rods that close loops."""
    for k, loop in enumerate(seen.pose.loops):
        if loop.rod:
            _dimension(drawing, loop.carrier, loop.origin, seen.names.rod(k), 20.0, SAME)


def measured_centres(drawing: Drawing, seen: Snapshot) -> None:
    """Draw the centres of mass to which the model has named lengths."""
    naming = seen.names.naming
    bodies = [x for x in seen.drawn if naming.centre_length(x.number) is not None]
    centres(drawing, seen, bodies)


def _dimension(
    drawing: Drawing, start: Array, end: Array, name: str, aside: float, least: float
) -> None:
    if name and np.linalg.norm(end - start) > least:
        drawing.add(Dimension(point(start), point(end), name, label=name, aside=aside))


def _clear_side(seen: Snapshot, body: BodyPlace) -> float:
    """The side of a body without its joint's angle, on which lengths are drawn: 1 left, -1
    right."""
    if seen.model.dim == 3:
        return 1.0
    if body.kind.slides:
        return 1.0 if body.parent < 0 else _clear_side(seen, seen.pose.bodies[body.parent])
    (a, b), (c, d) = body.carrier_rotation[:, 0], body.rotation[:, 0]
    return 1.0 if a * d - b * c >= 0 else -1.0


# ---------------------------------------------------------------- vectors
@of_each
def links(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, aside: float = 0.0, letter: str = "s",
    least: float = _VECTOR,
) -> None:  # fmt: skip
    """Draw vectors s_i from the joint of body i to the next, or to the tip; least: the fraction of
    the robot's size below which none is drawn in space."""
    plane = seen.model.dim == 2
    shortest, aside = (0.0, aside) if plane else (max(least * seen.size, SAME), 0.0)
    for end, place in seen.reaches(body):
        if np.linalg.norm(place - body.origin) > shortest:
            drawing.position(body.origin, place, seen.names.reach(body, end, letter), aside)


@of_each
def to_centres(drawing: Drawing, seen: Snapshot, body: BodyPlace, aside: float = -BESIDE) -> None:
    """Draw vectors s_ci from the joint of body i to its centre of mass."""
    if body.mass > 0:
        aside = aside if seen.model.dim == 2 else 0.0
        drawing.position(body.origin, body.com, seen.names.on("s", body.number, "c"), aside)


@of_each
def directions(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw unit vectors along the slides."""
    if body.kind.slides and body.axis is not None:
        end, name = body.origin + 0.16 * seen.size * body.axis, seen.names.axis(body)
        drawing.arrow(body.origin, end, name, "z", body.axis, aside=-2 * BESIDE)


@of_each
def of_centres(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Draw vectors r_ci from the origin to the centre of mass of body i, beside the link where they
    would lie on it."""
    if body.mass > 0:
        along = body.parent < 0 and np.linalg.norm(body.origin) < SAME
        name = seen.names.on("r", body.number, "c")
        drawing.position(np.zeros(2), body.com, name, -BESIDE if along else 0.0)


def to_tip(drawing: Drawing, seen: Snapshot, name: str = "r") -> None:
    """Draw the vector r from the origin to the tip."""
    if seen.pose.tip is not None:
        drawing.position(np.zeros(seen.model.dim), seen.pose.tip, name)


# ---------------------------------------------------------------- axes in space
@of_each
def axes(drawing: Drawing, seen: Snapshot, body: BodyPlace, longest: float = math.inf) -> None:
    """Draw unit vectors z_i along the joint axes, at most `longest` metres long, with a thin line
    backwards."""
    if body.axis is not None:
        name, reach = seen.names.axis(body), min(0.17 * seen.size, longest) * body.axis
        start = body.carrier if body.kind.slides else body.origin
        drawing.line((start - 0.6 * reach, start), f"axis {body.number}", "axisline")
        drawing.arrow(start, start + reach, name, "z", body.axis, label=name)


@of_each
def variables(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Write the joints' variables behind their axes."""
    if body.axis is not None:
        end = body.carrier - 0.1 * seen.size * body.axis
        drawing.write(end, seen.names.coordinate(body), -body.axis)


def common_normal(p: Array, u: Array, q: Array, v: Array) -> tuple[Array, Array]:
    """The points at which the common normal of the axes p + s u and q + t v (u, v unit vectors)
    meets them; of parallel axes the normal through q."""
    w, cosine = q - p, float(u @ v)
    sine2 = 1.0 - cosine**2
    if sine2 < _PARALLEL:
        return p + (w @ u) * u, q
    s = float(w @ u - cosine * (w @ v)) / sine2
    t = float(cosine * (w @ u) - w @ v) / sine2
    return p + s * u, q + t * v


def normals(drawing: Drawing, seen: Snapshot) -> None:
    """Draw distances a_i along the common normal of the axes of joints i and i+1, and d_{i+1} along
    the axis between two normals."""
    heads: dict[int, Array] = {}

    def span(start: Array, end: Array, letter: str, body: BodyPlace, role: str) -> None:
        if np.linalg.norm(end - start) > _VECTOR * seen.size:
            name = seen.names.on(letter, body.number)
            drawing.arrow(start, end, name, role, end - start, "m", label=name, beside=0.5)

    for after in seen.pose.bodies:
        body = seen.pose.bodies[after.parent] if after.parent >= 0 else None
        if after.axis is None:
            continue
        if body is None or body.axis is None:
            heads[after.index] = after.carrier
            continue
        foot, head = common_normal(body.carrier, body.axis, after.carrier, after.axis)
        span(heads[body.index], foot, "d", body, "moment")
        span(foot, head, "a", body, "external")
        heads[after.index] = head
