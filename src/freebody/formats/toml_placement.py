"""Placements in TOML: an origin and a rotation, or steps."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from freebody.errors import ModelError
from freebody.formats.toml_table import TomlTable
from freebody.model.placement import (
    AxisRotation,
    Placement,
    Rotate,
    Shift,
    rotate,
    rpy,
    shift,
    turn,
)
from freebody.outputs.numbers import compared

TURNS = ("rpy", "axis_angle", "quat_wxyz", "matrix", "angle")
PLACE = ("origin", *TURNS, "steps")
UNIT_VECTORS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def placement(table: TomlTable, dim: int) -> Placement:
    """origin, then one rotation; or a list of steps."""
    if "steps" in table:
        if any(key in table for key in ("origin", *TURNS)):
            table.refuse("steps give the complete placement; remove origin and rotations.", "steps")
        return Placement(
            tuple(_step(t.called(f"{table.where}, steps"), dim) for t in table.tables("steps"))
        )
    turns = [key for key in TURNS if key in table]
    if len(turns) > 1:
        table.refuse(f"{turns[0]} and {turns[1]} exclude each other; keep one rotation.", turns[1])
    if turns and (turns[0] == "angle") != (dim == 2) and turns[0] != "matrix":
        use = "angle" if dim == 2 else ", ".join(TURNS[:-1])
        table.refuse(f"{turns[0]} does not fit a model with dim = {dim}; use {use}.", turns[0])
    origin = shift(*table.quantities("origin", dim, default=(0.0,) * dim))
    return origin.then(_rotation(table, turns[0], dim)) if turns else origin


def _rotation(table: TomlTable, key: str, dim: int) -> Placement:
    if key == "angle":
        return turn("z", table.quantity(key, "angle"))
    if key == "rpy":
        return rpy(*table.vector(key, 3, "angle"))
    if key == "matrix":
        return _matrix(table, dim)
    if key == "quat_wxyz":
        w, x, y, z = table.vector(key, 4)
        if abs(math.sqrt(w * w + x * x + y * y + z * z) - 1.0) > 1e-6:
            length, unit = compared(math.hypot(w, x, y, z), 1.0, digits=6)
            table.refuse(f"the quaternion has length {length}, expected {unit}.", key)
        return rotate(
            _about((x, y, z), math.hypot(x, y, z), 2.0 * math.atan2(math.hypot(x, y, z), w))
        )
    inner = table.inner(table.data[key], key).called(f"{table.where}, {key}").only("axis", "angle")
    axis = inner.data.get("axis")
    if isinstance(axis, str):
        return turn(inner.choice("axis", UNIT_VECTORS), inner.quantity("angle", "angle"))
    direction = inner.vector("axis", 3)
    length = math.hypot(*direction)
    if length == 0.0:
        inner.refuse("the axis is zero; give a direction.", "axis")
    return rotate(_about(direction, length, inner.number("angle", "angle")))


def _about(axis: Iterable[float], length: float, angle: float) -> np.ndarray:
    """Rotation matrix by an angle (rad) about an axis of that length (Rodrigues)."""
    if length == 0.0:
        return np.eye(3)
    x, y, z = (a / length for a in axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * (K @ K)


def _matrix(table: TomlTable, dim: int) -> Placement:
    try:
        return rotate(table.matrix("matrix", dim))
    except ModelError as error:
        table.refuse(str(error), "matrix")


def _step(table: TomlTable, dim: int) -> Shift | AxisRotation | Rotate:
    """{ shift = [...] }, { turn = "z", angle = ... } or { matrix = [...] }; kept as written."""
    table.only("shift", "turn", "angle", "matrix")
    if "shift" in table:
        return Shift(table.quantities("shift", dim))
    if "turn" in table:
        return AxisRotation(
            table.choice("turn", "z" if dim == 2 else "xyz"), table.quantity("angle", "angle")
        )
    _matrix(table, dim)
    return Rotate(table.matrix("matrix", dim))


def direction(table: TomlTable, dim: int) -> tuple[float, ...]:
    """axis = [0, 0, 1], or a letter: "x", "-z"."""
    given = table.data.get("axis")
    if isinstance(given, str):
        sign, letter = (-1.0, given[1:]) if given.startswith("-") else (1.0, given)
        if letter not in UNIT_VECTORS or (dim == 2 and letter == "z"):
            table.refuse(
                f"axis is {given!r}, expected x, y{'' if dim == 2 else ', z'}, one of them with a "
                f"minus, or numbers.",
                "axis",
            )
        return tuple(sign * x for x in UNIT_VECTORS[letter][:dim])
    return table.vector("axis", dim)
