"""The gravity field of a model: a size, which may be a letter, and a direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np

from freebody.errors import ModelError
from freebody.labels import refuse_labelled
from freebody.model.parameters import Parameter, Quantity, finite, quantity
from freebody.spatial import unit


def gravity_of(
    given: float | str | Parameter | Sequence[float],
    dim: int,
    direction: tuple[float, ...] | None = None,
    name: str | None = None,
) -> tuple[Quantity, tuple[float, ...]]:
    """(size, unit direction) from a vector, a size or a name; a size keeps `direction` (default: down).

    A size becomes the value of the parameter `name`, so that equations can show a letter.
    """
    down = (0.0,) * (dim - 1) + (-1.0,)
    direction = direction or down
    if isinstance(given, str | Parameter | int | float | Real):
        return quantity(given, "gravity", name), direction
    refuse_labelled("gravity", given)
    vector = np.array([finite(x, "gravity") for x in given])
    if vector.shape != (dim,):
        raise ModelError(f"gravity: a vector of {dim} entries in world axes is needed, not {len(vector)}.")
    return (math.hypot(*vector), unit(vector)) if vector.any() else (0.0, direction)
