"""The geometry of a planar robot: angles, slides, lengths; centres of mass in plane and space."""

from __future__ import annotations

import math

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import SAME, Arc, Dimension, Drawing, Label, point
from freebody.figures.layers.structure import of_each
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

_ARC = 0.15
_VISIBLE = 0.05
"""Radius of an angle's arc, of the drawing's size."""


@of_each
def centres(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """Centres of mass with their names."""
    if body.mass > 0:
        along = seen.heading(body)
        away = (along[1], -along[0]) if seen.model.dim == 2 else (0.0, 0.0, -1.0)
        drawing.centre(body.com, names.on("C", body.number), away)


@of_each
def angles(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, longest: float = math.inf
) -> None:
    """θ_1 from the x axis, further ones from the line of the link before: dashed where an angle
    starts, an arc with a head where it ends, of a radius of at most `longest` metres."""
    name = names.coordinate(body)
    if not body.kind.turns or not name:
        return
    before = math.atan2(body.carrier_rotation[1, 0], body.carrier_rotation[0, 0])
    now = math.atan2(body.rotation[1, 0], body.rotation[0, 0])
    turned, reach = math.remainder(now - before, 2 * math.pi), min(_ARC * seen.size, longest)
    end = body.origin + 1.5 * reach * np.array([math.cos(before), math.sin(before)])
    drawing.line((body.origin, end), f"reference {name}", "guide")
    drawing.add(Arc(point(body.origin), reach, before, turned, name, label=name))


@of_each
def slides(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """d_i, from where a slide begins to the joint's block."""
    if body.kind.slides:
        aside = -20.0 * _clear_side(seen, body)
        _dimension(drawing, body.carrier, body.origin, names.coordinate(body), aside, SAME)


@of_each
def lengths(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, aside: float = 14.0,
    least: float = _VISIBLE,
) -> None:  # fmt: skip
    """l_i, on the side where no angle is. least: of the robot's size, below which none is drawn."""
    for end in body.ends[:1]:
        _length(drawing, seen, body, end.place, names.length(body, end), aside, least)


@of_each
def all_lengths(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, least: float = _VISIBLE
) -> None:
    """l_ci next to each link, l_i farther out. least: as for `lengths`."""
    if body.mass > 0:
        _length(drawing, seen, body, body.com, names.centre_length(body), 12.0, least)
    lengths(drawing, seen, names, (body,), aside=27.0, least=least)


def _length(
    drawing: Drawing, seen: Snapshot, body: BodyPlace, place: Array, name: str, aside: float,
    least: float,
) -> None:  # fmt: skip
    aside *= _clear_side(seen, body)
    _dimension(drawing, body.origin, place, name, aside, max(least * seen.size, SAME))


def _dimension(
    drawing: Drawing, start: Array, end: Array, name: str, aside: float, least: float
) -> None:
    if name and np.linalg.norm(end - start) > least:
        drawing.add(Dimension(point(start), point(end), name, label=name, aside=aside))


def _clear_side(seen: Snapshot, body: BodyPlace) -> float:
    """1: left of a body, -1: right of it; an angle is drawn behind the turn that made it."""
    if body.kind.slides:
        return 1.0 if not body.parent >= 0 else _clear_side(seen, seen.pose.bodies[body.parent])
    (a, b), (c, d) = body.carrier_rotation[:, 0], body.rotation[:, 0]
    return 1.0 if a * d - b * c >= 0 else -1.0


@of_each
def inertias(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """(m_i, I_i) beside the links."""
    if body.mass > 0:
        along = seen.heading(body)
        text = f"{names.mass(body.number)}, {names.inertia(body.number)}"
        at = point(body.com + 0.1 * seen.size * along)
        drawing.add(Label(at, text, text, direction=(along[1], -along[0])))
