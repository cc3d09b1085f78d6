"""Arrays of numbers that carry how large the terms were that they were made of, so that a
difference can be told from rounding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

EQUAL = 1e-9
"""The share of a number's terms below which a difference counts as rounding: right equations need
1.5e-13 at regular states."""
_STEEPEST = 100.0
"""Slope of a function up to which it counts: arccos and roots are infinitely steep somewhere, but
rounding changes them by some 1e-8 at most."""

AnyArray = np.ndarray[Any, np.dtype[Any]]


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
        """A quotient; no number where the divisor is 0 but for rounding."""
        value = self.value / np.where(other.vanishes, np.nan, other.value)
        return Running(value, (self.size + np.abs(value) * other.size) / np.abs(other.value))

    def __pow__(self, exponent: int) -> Running:
        if exponent < 0:
            return Running.exact(np.ones_like(self.value)) / self**-exponent
        below = np.asarray(self.value, float) ** max(exponent - 1, 0)
        return Running(self.value**exponent, exponent * np.abs(below) * self.size)

    def by(self, value: Any, slope: Any) -> Running:
        """A function of the numbers, of which value and derivative are given."""
        return Running(value, np.minimum(np.abs(slope), _STEEPEST) * self.size + np.abs(value))

    @property
    def vanishes(self) -> AnyArray:
        """Where they are 0 but for rounding; nowhere where they are no numbers."""
        known = np.isfinite(self.value) & np.isfinite(self.size)
        return known & (np.abs(self.value) <= EQUAL * self.size)

    @property
    def worst(self) -> int:
        """Where they are farthest from 0, by their size; not where they are no numbers."""
        with np.errstate(invalid="ignore"):
            share = np.abs(self.value) / np.maximum(self.size, 1e-300)
        return int(np.argmax(np.where(np.isfinite(share), share, -1.0)))
