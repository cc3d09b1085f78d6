"""Loops of a model: checked when it is made, and in scalars for the algorithms."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.errors import ModelError, UnknownNameError
from freebody.model.description import Loop
from freebody.model.families import Members
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.parameters import Parameter, Quantity, quantity
from freebody.model.struts import two_frames
from freebody.spatial import unit

if TYPE_CHECKING:
    from freebody.model.model import Model


def checked_loop(dim: int, loop: Loop, body_of: Mapping[str, int], taken: Container[str]) -> Loop:
    """The loop with a unit axis and a distance where it has one; refuses what closes nothing.

    body_of: the body of each frame; taken: names of joints and other loops.
    """
    where = f"loop {loop.name!r}"
    if loop.kind not in LOOP_KINDS:
        raise UnknownNameError("loop kind", loop.kind, where, LOOP_KINDS)
    kind = LOOP_KINDS[loop.kind]
    if dim not in kind.dimensions:
        raise ModelError(
            f"{where}: {kind.name} is no loop of dimension {dim}; write {kind.elsewhere}."
        )
    frames = two_frames(where, loop.name, loop.frames, body_of, taken, "the loop closes nothing")
    return replace(
        loop,
        frames=frames,
        axis=_axis(loop, dim, where),
        distance=checked_distance(loop),
    )


def checked_tolerance(given: object, where: str) -> tuple[float, float]:
    """A `loop_tolerance`: metres and radians, finite, not negative."""
    try:
        values = np.array(given, dtype=float)
    except (TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != (2,) or not np.isfinite(values).all() or (values < 0.0).any():
        raise ModelError(
            f"{where}: loop_tolerance is {given!r}, expected (metres, radians), two finite numbers "
            f"not below 0."
        )
    return float(values[0]), float(values[1])


def _axis(loop: Loop, dim: int, where: str) -> tuple[float, ...]:
    needed = dim in LOOP_KINDS[loop.kind].axis_in
    if not needed and loop.axis:
        raise ModelError(f"{where}: a {loop.kind} loop has no axis in dimension {dim}; remove it.")
    if not needed:
        return ()
    try:
        axis = np.array(loop.axis, dtype=float)
    except (TypeError, ValueError):
        axis = np.zeros(0)
    if axis.shape != (dim,) or not np.isfinite(axis).all() or not axis.any():
        raise ModelError(f"{where}: axis {loop.axis} must be {dim} finite numbers, not all zero.")
    return unit(axis)


def checked_distance(loop: Loop) -> Quantity | None:
    """The distance of a loop, refused where its kind has none, where it is missing, or not above
    0."""
    where = f"loop {loop.name!r}"
    if not LOOP_KINDS[loop.kind].needs_distance:
        if loop.distance is not None:
            raise ModelError(f"{where}: a {loop.kind} loop has no distance; remove it.")
        return None
    if loop.distance is None:
        raise ModelError(f"{where}: give the distance (m) between its frames.")
    distance = quantity(loop.distance, f"{where}: distance")
    value = distance.value if isinstance(distance, Parameter) else distance
    smallest = value.array.min() if isinstance(value, Members) else value
    if smallest is not None and smallest <= 0.0:
        raise ModelError(
            f"{where}: distance is {smallest:g} m, expected more than 0; for 0 hold the origins "
            f"together instead."
        )
    return distance


def held_by_base(model: Model) -> frozenset[int]:
    """The bodies (indices) that the base holds, through joints that do not leave them all their
    motion, or through loops."""
    number = {frame.name: frame.body for frame in model.frames}
    pairs = [
        (k, body.parent)
        for k, body in enumerate(model.bodies)
        if not (body.parent < 0 and body.kind.frees(model.dim))
    ]
    pairs += [(number[a], number[b]) for a, b in (loop.frames for loop in model.loops)]
    held, before = {-1}, 0
    while len(held) > before:
        before = len(held)
        held |= {x for pair in pairs if not held.isdisjoint(pair) for x in pair}
    return frozenset(held - {-1})
