"""Arrays of numbers that carry how large the terms were that they were made of, so that a
difference can be told from rounding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

EQUAL = 1e-9
"""The share of a number's terms below which a difference counts as rounding: right equations need
1.5e-13 at regular states."""

Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, eq=False)
class Running:
    """value: the numbers; size: by how much they change where everything that they were made of
    changes by its own size."""

    value: Any
    size: Any

    @staticmethod
    def exact(x: Any) -> Running:
        """Numbers as they are."""
        return Running(x, np.abs(x))

    def __add__(self, other: Running) -> Running:
        return Running(self.value + other.value, self.size + other.size)

    def __sub__(self, other: Running) -> Running:
        return Running(self.value - other.value, self.size + other.size)

    def __neg__(self) -> Running:
        return Running(-self.value, self.size)

    def __mul__(self, other: Running) -> Running:
        size = np.abs(self.value) * other.size + np.abs(other.value) * self.size
        return Running(self.value * other.value, size)

    def __truediv__(self, other: Running) -> Running:
        value = self.value / other.value
        return Running(value, (self.size + np.abs(value) * other.size) / np.abs(other.value))

    def __pow__(self, exponent: int) -> Running:
        value, below = self.value**exponent, np.asarray(self.value, float) ** (exponent - 1)
        return Running(value, abs(exponent) * np.abs(below) * self.size)

    def by(self, value: Any, slope: Any) -> Running:
        """A function of the numbers, of which value and derivative are given."""
        return Running(value, np.abs(slope) * self.size + np.abs(value))

    @property
    def vanishes(self) -> Array:
        """Where they are 0 but for rounding; nowhere where they are no numbers."""
        return np.isfinite(self.value) & (np.abs(self.value) <= EQUAL * self.size)

    @property
    def worst(self) -> int:
        """Where they are farthest from 0, by their size; not where they are no numbers."""
        share = np.abs(self.value) / np.maximum(self.size, 1e-300)
        return int(np.argmax(np.where(np.isfinite(share), share, -1.0)))
