"""Motions that are simulated side by side: their batch shape, flattened to lanes."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array

Some = int | slice | NDArray[np.intp]
"""Which lanes: one without its axis, or several."""


@dataclass(frozen=True)
class MotionLanes:
    """The shape of a batch, and its members one after another."""

    shape: tuple[int, ...]

    @property
    def count(self) -> int:
        """How many."""
        return prod(self.shape)

    def each(self, array: Array, core: int) -> Array:
        """(count, *core) of an array (..., *core); one without leading axes, which is the same for
        all lanes, as it is. core: number of its axes."""
        if array.ndim == core:
            return array
        own = array.shape[array.ndim - core :]
        return np.broadcast_to(array, (*self.shape, *own)).reshape(self.count, *own)

    def all(self, array: Array, core: int) -> Array:
        """(count, *core), a copy."""
        own = array.shape[array.ndim - core :]
        return np.array(np.broadcast_to(array, (*self.shape, *own))).reshape(self.count, *own)

    def index(self, lane: int) -> tuple[int, ...]:
        """The index of a lane in the batch."""
        return tuple(map(int, np.unravel_index(lane, self.shape))) if self.shape else ()


def some_of(array: Array, core: int, lanes: Some) -> Array:
    """Of what `MotionLanes.each` returned the rows of some lanes."""
    return array if array.ndim == core else array[lanes]
