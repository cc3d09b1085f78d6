"""Where labels go: each tries places around its anchors and takes the one with least overlap."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from freebody.arrays import Array
from freebody.figures.text import SIZE

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in pixels."""

_TURNS = (0.0, 25.0, -25.0, 50.0, -50.0, 80.0, -80.0, 110.0, -110.0, 145.0, -145.0, 180.0)
_DISTANCES = {6.0: 0.0, 11.0: 1.5, 18.0: 4.0, 28.0: 9.0, 42.0: 18.0, 60.0: 32.0}  # and prices
_SWEEPS = 4  # how often labels may move once all are there


@dataclass(frozen=True)
class Wanted:
    """A label that looks for a place: a formula and plain text after it."""

    text: str
    css: str
    anchors: Sequence[tuple[complex, complex]]
    """Places on the page, the best first, each with the direction in which it would like to go."""
    width: float
    """Pixels."""
    after: str = ""


@dataclass
class Crowd:
    """What is on the page already: points of lines to keep clear of, boxes of text, and the page's
    edge."""

    width: float
    height: float
    points: list[complex] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)

    def keep_clear(self, a: complex, b: complex, half_width: float = 0.0) -> None:
        """Points along a segment, or along both edges of a bar."""
        length = abs(b - a)
        n = max(int(length / 5.0), 1)
        across = 1j * (b - a) / length * half_width if length else 0.0
        for side in (-across, across) if half_width else (0.0,):
            self.points += [a + (b - a) * k / n + side for k in range(n + 1)]

    def settle(self, wanted: Sequence[Wanted]) -> list[Box]:
        """Boxes for all: one after the other, then each once more among the others, until none
        moves."""
        choices = [_candidates(w) for w in wanted]
        choices = [(boxes, prices + self._fixed(boxes)) for boxes, prices in choices]
        first = len(self.boxes)
        for boxes, prices in choices:
            self.boxes.append(self._cheapest(boxes, prices))
        for _ in range(_SWEEPS):
            before = self.boxes[first:]
            for k, (boxes, prices) in enumerate(choices, first):
                self.boxes.pop(k)
                self.boxes.insert(k, self._cheapest(boxes, prices))
            if self.boxes[first:] == before:
                break
        return self.boxes[first:]

    def _cheapest(self, boxes: Array, prices: Array) -> Box:
        total = prices.copy()
        for other in self.boxes:
            total += 0.6 * overlaps(boxes, other)
        left, top, right, bottom = boxes[int(np.argmin(total))].tolist()
        return left, top, right, bottom

    def _fixed(self, boxes: Array) -> Array:
        """What a place costs whatever the other labels do: being off the page, and lines under the
        text."""
        left, top, right, bottom = boxes.T
        outside = np.maximum(0, 3 - left) + np.maximum(0, 3 - top)
        outside += np.maximum(0, right - self.width + 3) + np.maximum(0, bottom - self.height + 3)
        x, y = np.array([(p.real, p.imag) for p in self.points]).reshape(-1, 2).T
        hit = (left[:, None] - 2 < x) & (x < right[:, None] + 2)
        hit &= (top[:, None] - 1 < y) & (y < bottom[:, None] + 1)
        return 30 * outside + 7 * hit.sum(axis=1)


def _candidates(wanted: Wanted) -> tuple[Array, Array]:
    """Boxes around the anchors (k, 4), and how far each is from what is wanted."""
    half = complex(wanted.width + 2, 1.25 * SIZE) / 2
    boxes, prices = [], []
    for rank, (anchor, way) in enumerate(wanted.anchors):
        for k, turn in enumerate(_TURNS):
            u = cmath.rect(1.0, cmath.phase(way) + math.radians(turn))
            for distance, price in _DISTANCES.items():
                # the box touches the circle of that distance around the anchor
                beyond = complex(half.real * u.real * abs(u.real), half.imag * u.imag * abs(u.imag))
                centre = anchor + u * distance + beyond
                low, high = centre - half, centre + half
                boxes.append((low.real, low.imag, high.real, high.imag))
                prices.append(6 * rank + 1.0 * k + price)
    return np.array(boxes), np.array(prices)


def overlaps(boxes: Array, other: Box) -> Array:
    """Area that each box shares with another, with a small margin."""
    left, top, right, bottom = boxes.T
    wide = np.minimum(right, other[2]) - np.maximum(left, other[0]) + 3
    high = np.minimum(bottom, other[3]) - np.maximum(top, other[1]) + 2
    return np.maximum(wide, 0.0) * np.maximum(high, 0.0)
