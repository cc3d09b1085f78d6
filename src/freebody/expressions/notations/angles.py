"""From where angles are measured: θ = B φ and a turn of the direction in which they are 0."""

from __future__ import annotations

import math

from freebody.errors import FreebodyError
from freebody.expressions.notations.notation import BookNotation
from freebody.model.bodies import Body
from freebody.model.model import Model

Weights = tuple[tuple[int, ...], ...]
"""A matrix of whole numbers."""


def angles_of(
    caller: str, notation: BookNotation, model: Model, absolute: bool = False
) -> tuple[Weights | None, tuple[int, ...]]:
    """B of θ = B φ, where θ are the model's coordinates and φ the notation's, or None where they
    are the same; and by how many right angles each of φ is 0 elsewhere, or ().

    Raises FreebodyError for robots whose angles are not written so.
    """
    turned = turned_by(caller, model) if absolute or notation.absolute else None
    if not notation.quarter_turns:
        return turned, ()
    first = [not any(row[:i]) for i, row in enumerate(turned_by(caller, model))]
    return turned, tuple(
        notation.quarter_turns * _sense(body) * int(alone or turned is not None)
        for body, alone in zip(model.bodies, first, strict=True)
    )


def turned_by(caller: str, model: Model) -> Weights:
    """B of θ = B φ for absolute angles, each in the sense of its own joint: each turn of a planar
    tree is that of its body less that of the body before. Drawings have anticlockwise ones only."""
    if model.dim != 2:
        raise FreebodyError(
            f"{caller}: absolute angles belong to robots in the plane; {model.name!r} is in space."
        )
    rows: list[list[int]] = []
    for i, body in enumerate(model.bodies):
        row = [int(i == k) for k in range(len(model.bodies))]
        above = body.parent
        while above >= 0 and not model.bodies[above].kind.turns:
            above = model.bodies[above].parent
        if body.kind.turns and above >= 0:
            row[above] = -_sense(body) * _sense(model.bodies[above])
        if body.joint.mimic is not None or (caller != "check" and _sense(body) < 0):
            raise FreebodyError(
                f"{caller}: absolute angles are not written where a joint follows another or turns "
                f"clockwise, as {body.joint.name!r} of {model.name!r} does."
            )
        rows.append(row)
    return tuple(map(tuple, rows))


def _sense(body: Body) -> int:
    """1 of a body that turns anticlockwise, -1 clockwise, 0 of one that does not turn."""
    return int(body.kind.turns and math.copysign(1, body.joint.axis[0]))
