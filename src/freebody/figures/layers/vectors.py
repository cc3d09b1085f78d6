"""Position vectors: s_i from joint to joint, r to the tip, s_ci and r_ci to the centres of mass."""

from __future__ import annotations

import numpy as np

from freebody.figures.drawing import SAME, Drawing
from freebody.figures.layers.structure import of_each
from freebody.figures.names import Names
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot

BESIDE = 15.0
"""How far a vector in the plane is drawn beside the link it lies on, pixels."""
_VISIBLE = 0.025
"""Vectors in space below this part of the robot's size are not drawn."""


@of_each
def links(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, aside: float = 0.0,
    letter: str = "s", least: float = _VISIBLE,
) -> None:  # fmt: skip
    """s_i, from the joint of body i to the next, or to the tip. least: of the robot's size, below
    which none is drawn in space."""
    plane = seen.model.dim == 2
    shortest, aside = (0.0, aside) if plane else (max(least * seen.size, SAME), 0.0)
    for end, place in seen.reaches(body):
        if np.linalg.norm(place - body.origin) > shortest:
            drawing.position(body.origin, place, names.reach(body, end, letter), aside)


@of_each
def to_centres(
    drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace, aside: float = -BESIDE
) -> None:
    """s_ci, from the joint of body i to its centre of mass."""
    if body.mass > 0:
        aside = aside if seen.model.dim == 2 else 0.0
        drawing.position(body.origin, body.com, names.on("s", body.number, "c"), aside)


@of_each
def directions(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """Unit vectors along the slides."""
    if body.kind.slides and body.axis is not None:
        end = body.origin + 0.16 * seen.size * body.axis
        drawing.arrow(body.origin, end, names.axis(body), "z", body.axis, aside=-2 * BESIDE)


@of_each
def of_centres(drawing: Drawing, seen: Snapshot, names: Names, body: BodyPlace) -> None:
    """r_ci, from the origin to the centre of mass of body i; beside the link where it lies on
    it."""
    if body.mass > 0:
        along = body.parent < 0 and np.linalg.norm(body.origin) < SAME
        name = names.on("r", body.number, "c")
        drawing.position(np.zeros(2), body.com, name, -BESIDE if along else 0.0)


def to_tip(drawing: Drawing, seen: Snapshot, names: Names, name: str = "r") -> None:
    """r, from the origin to the tip."""
    if seen.pose.tip is not None:
        drawing.position(np.zeros(seen.model.dim), seen.pose.tip, name)
