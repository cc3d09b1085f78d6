"""Where labels go: each tries places around its anchors and takes the one with least overlap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from freebody.arrays import Array

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in pixels."""

_TURNS = (0.0, 25.0, -25.0, 50.0, -50.0, 80.0, -80.0, 110.0, -110.0, 145.0, -145.0, 180.0)
_DISTANCES = (6.0, 11.0, 18.0, 28.0, 42.0, 60.0)
_SWEEPS = 4  # how often labels may move once all are there


@dataclass
class Wanted:
    """A label that looks for a place: anchors in pixels, each with the direction it would like to
    go."""

    text: str
    css: str
    anchors: Sequence[tuple[float, float, float, float]]
    """(x, y, dx, dy) of each anchor, the best first; y down."""
    size: float
    """Height of its letters, pixels."""
    width: float
    """Pixels."""
    after: str = ""
    """Plain text that follows."""


@dataclass
class Placed:
    """A label with its box."""

    wanted: Wanted
    box: Box


@dataclass
class Crowd:
    """What is on the page already: points of lines to keep clear of, boxes of text, and the page's
    edge."""

    width: float
    height: float
    points: list[tuple[float, float]] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)

    def keep_clear(
        self, a: tuple[float, float], b: tuple[float, float], half_width: float = 0.0
    ) -> None:
        """Points along a segment, or along both edges of a bar."""
        length = math.dist(a, b)
        n = max(int(length / 5.0), 1)
        u, v = ((b[0] - a[0]) / length, (b[1] - a[1]) / length) if length else (0.0, 0.0)
        for side in (-half_width, half_width) if half_width else (0.0,):
            shift = (-v * side, u * side)
            self.points += [
                (a[0] + (b[0] - a[0]) * k / n + shift[0], a[1] + (b[1] - a[1]) * k / n + shift[1])
                for k in range(n + 1)
            ]

    def settle(self, wanted: Sequence[Wanted]) -> list[Placed]:
        """Places for all: one after the other, then each once more among the others, until none
        moves."""
        choices = [_candidates(w) for w in wanted]
        choices = [(boxes, prices + self._fixed(boxes)) for boxes, prices in choices]
        first = len(self.boxes)
        for boxes, prices in choices:
            self.boxes.append(self._cheapest(boxes, prices))
        for _ in range(_SWEEPS):
            before = self.boxes[first:]
            for k, (boxes, prices) in enumerate(choices):
                own = self.boxes.pop(first + k)
                best = self._cheapest(boxes, prices)
                self.boxes.insert(first + k, best if best != own else own)
            if self.boxes[first:] == before:
                break
        return [Placed(w, box) for w, box in zip(wanted, self.boxes[first:], strict=True)]

    def _cheapest(self, boxes: Array, prices: Array) -> Box:
        total = prices.copy()
        for other in self.boxes:
            total += 0.6 * _overlaps(boxes, other)
        return tuple(float(x) for x in boxes[int(np.argmin(total))])  # type: ignore[return-value]

    def _fixed(self, boxes: Array) -> Array:
        """What a place costs whatever the other labels do: being off the page, and lines under the
        text."""
        left, top, right, bottom = boxes.T
        outside = np.maximum(0, 3 - left) + np.maximum(0, 3 - top)
        outside += np.maximum(0, right - self.width + 3) + np.maximum(0, bottom - self.height + 3)
        price = 30 * outside
        if self.points:
            x, y = np.array(self.points).T
            hit = (left[:, None] - 2 < x) & (x < right[:, None] + 2)
            hit &= (top[:, None] - 1 < y) & (y < bottom[:, None] + 1)
            price = price + 7 * hit.sum(axis=1)
        return price


def _candidates(wanted: Wanted) -> tuple[Array, Array]:
    """Boxes around the anchors (k, 4), and how far each is from what is wanted."""
    w = wanted.width + 2
    h = wanted.size * 1.25
    boxes, prices = [], []
    for rank, (x, y, dx, dy) in enumerate(wanted.anchors):
        heading = math.atan2(dy, dx)
        for k, turn in enumerate(_TURNS):
            a = heading + math.radians(turn)
            for j, distance in enumerate(_DISTANCES):
                # the box touches the circle of that distance around the anchor
                cx = x + math.cos(a) * (distance + w / 2 * abs(math.cos(a)))
                cy = y + math.sin(a) * (distance + h / 2 * abs(math.sin(a)))
                boxes.append((cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2))
                prices.append(6 * rank + 1.0 * k + (0.0, 1.5, 4.0, 9.0, 18.0, 32.0)[j])
    return np.array(boxes), np.array(prices)


def _overlaps(boxes: Array, other: Box) -> Array:
    """Area that each box shares with another, with a small margin."""
    left, top, right, bottom = boxes.T
    wide = np.minimum(right, other[2]) - np.maximum(left, other[0]) + 3
    high = np.minimum(bottom, other[3]) - np.maximum(top, other[1]) + 2
    return np.maximum(wide, 0.0) * np.maximum(high, 0.0)


def _overlap(a: Box, b: Box) -> float:
    return float(_overlaps(np.array([a]), b)[0])
