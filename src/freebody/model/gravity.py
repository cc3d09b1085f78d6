"""The gravity field of a model: a size, which may be a letter, and a direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np

from freebody.errors import ModelError, shown
from freebody.labels import refuse_labelled
from freebody.model.families import Members, is_nested, members, of_member
from freebody.model.parameters import LARGEST, Parameter, Quantity, finite, quantity
from freebody.model.quantity_reader import VALUES
from freebody.outputs.number_text import compared
from freebody.spatial import unit


def gravity_of(
    given: float | str | Parameter | Sequence[float] | np.ndarray,
    dim: int,
    direction: tuple[Any, ...] | None = None,
    name: str | None = None,
) -> tuple[Quantity, tuple[Any, ...]]:
    """(size, unit direction) from a vector, a size or a name; a size keeps `direction` (default:
    down).

    Vectors (..., dim) are those of a family. A size becomes the value of the parameter `name`, so
    that equations can show a letter.
    """
    down = (0.0,) * (dim - 1) + (-1.0,)
    direction = direction or down
    if isinstance(given, np.ndarray) and not given.ndim:
        given = given[()]
    if isinstance(given, str | Parameter | int | float | Real):
        return quantity(given, "gravity", name), direction
    refuse_labelled("gravity", given)
    if is_nested(given):
        return _of_members(given, dim, direction)
    if not isinstance(given, Sequence) and np.ndim(given) == 0:
        raise ModelError(
            f"gravity: {shown(given)} is neither a size, nor a name, nor a vector of {dim} entries."
        )
    vector = np.array([finite(x, "gravity") for x in given])
    if vector.shape != (dim,):
        raise ModelError(
            f"gravity: a vector of {dim} entries in world axes is needed, not {len(vector)}."
        )
    return (math.hypot(*vector), unit(vector)) if vector.any() else (0.0, direction)


def _of_members(
    given: object, dim: int, direction: tuple[Any, ...]
) -> tuple[Quantity, tuple[Any, ...]]:
    """Gravity of a family: a size for each member, and the direction that they share, or each its
    own."""
    vectors = members(given, "gravity", LARGEST).array
    if vectors.shape[-1] != dim:
        raise ModelError(
            f"gravity: vectors of {dim} entries in world axes are needed, not {vectors.shape[-1]}."
        )
    sizes = np.sqrt((vectors * vectors).sum(axis=-1))
    if not sizes.any():
        return Members(sizes), direction
    along = unit(vectors.reshape(-1, dim)[int(np.argmax(sizes))])
    if np.allclose(vectors, sizes[..., None] * along, rtol=0.0, atol=1e-14 * float(sizes.max())):
        return Members(sizes), along
    some = sizes > 0.0
    turned = np.where(some[..., None], vectors, along) / np.where(some, sizes, 1.0)[..., None]
    columns = np.moveaxis(turned, -1, 0)
    return Members(sizes), tuple([Members(x.copy()) if x.any() else 0.0 for x in columns])


def direction_fault(direction: tuple[Any, ...]) -> str | None:
    """The fault of a direction of the field, its length, in words; None if it has none, or where a
    kernel reads it."""
    if any(isinstance(x, Parameter) for x in direction):
        return None
    length = np.sqrt(sum(np.square(VALUES.quantity(x)) for x in direction))
    off = np.argwhere(np.abs(length - 1.0) > _UNIT)
    if not len(off):
        return None
    at = tuple(map(int, off[0]))
    size, unit = compared(length[at], 1.0, digits=6)
    return f"gravity.direction has length {size}{of_member(at)}; it must be {unit}"


_UNIT = 1e-9


def axis_of(direction: Sequence[float]) -> str:
    """The axis that a direction lies along, such as "-z"; "" of others."""
    along = [(axis, x) for axis, x in zip("xyz", direction, strict=False) if x]
    return f"{'-' if along[0][1] < 0 else '+'}{along[0][0]}" if len(along) == 1 else ""
