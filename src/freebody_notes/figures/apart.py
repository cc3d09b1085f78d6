"""The links of a planar arm drawn apart at the joints, with all forces and torques on each, and the
inertias."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Arrow, Dimension, Drawing, Element, Label, Line, point
from freebody.figures.layers import forces
from freebody.figures.layers.structure import of_each
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot
from freebody.figures.view import FLAT, WorldPoint

_GAP = 0.34  # of the arm's size


@dataclass
class DrawnApart(Drawing):
    """A drawing whose bodies are moved away from their true positions."""

    moved: dict[int, WorldPoint] = field(default_factory=dict)
    """How far, by the body's number, metres."""


def apart(seen: Snapshot, show: Sequence[str], note: str) -> DrawnApart:
    """All bodies of a planar robot, drawn apart by a gap at each joint, and a bar for the forces.

    show: of `forces.PARTS`, beside points and centres. note: the words below.
    """
    drawing = DrawnApart(FLAT, f"Free-body diagrams of the links of {seen.model.name}")
    shift: dict[int, Array] = {-1: np.zeros(2)}
    scale = forces.scale_of(seen.loads, 0.38 * seen.size)
    for body in seen.pose.bodies:
        gap = np.zeros(2) if body.parent < 0 else _gap(seen, body)
        shift[body.index] = shift[body.parent] + gap
        part = forces.alone(seen, body, ("points", "centres", *show), scale)
        drawing.add(*(_moved(element, shift[body.index]) for element in part.elements))
        drawing.moved[body.number] = point(shift[body.index])
    drawing.ruler(scale.force / 2.5, scale.longest / 2.5, "N", "reaction")
    drawing.notes = [note]
    return drawing


def _gap(seen: Snapshot, body: BodyPlace) -> Array:
    """Gap between a body and its child in the free-body drawing: along both, or perpendicular if
    they are folded together."""
    before, after = seen.heading(seen.pose.bodies[body.parent]), seen.heading(body)
    way = before + after
    if np.linalg.norm(way) < 0.3:
        way = np.array([-before[1], before[0]])
    return _GAP * seen.size * way / np.linalg.norm(way)


def _moved(element: Element, by: Array) -> Element:
    """A drawn element shifted by a vector in the plane."""
    if isinstance(element, Line):
        return replace(element, points=tuple(point(np.add(p, by)) for p in element.points))
    fields = ("start", "end") if isinstance(element, Arrow | Dimension) else ("at",)
    return replace(element, **{f: point(np.add(getattr(element, f), by)) for f in fields})


@of_each
def inertias(drawing: Drawing, seen: Snapshot, body: BodyPlace) -> None:
    """Add the labels (m_i, I_i) of a body's mass and moment of inertia beside its link."""
    if body.mass > 0:
        along, names = seen.heading(body), seen.names
        text = f"{names.mass(body.number)}, {names.inertia(body.number)}"
        at = point(body.com + 0.1 * seen.size * along)
        drawing.add(Label(at, text, text, direction=(along[1], -along[0])))
