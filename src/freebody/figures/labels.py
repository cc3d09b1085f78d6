"""Where labels go: each tries places around its anchors and takes the one with least overlap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from freebody.figures import text as texts

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in pixels."""

_TURNS = (0.0, 40.0, -40.0, 80.0, -80.0, 125.0, -125.0, 180.0)
_DISTANCES = (7.0, 16.0, 28.0, 44.0)


@dataclass
class Wanted:
    """A label that looks for a place: anchors in pixels, each with the direction it would like to go."""

    text: str
    css: str
    anchors: Sequence[tuple[float, float, float, float]]
    """(x, y, dx, dy) of each anchor, the best first; y down."""
    size: float = 13.0


@dataclass
class Placed:
    """A label with its box."""

    wanted: Wanted
    box: Box


@dataclass
class Crowd:
    """What is on the page already: points of lines to keep clear of, boxes of text, and the page's edge."""

    width: float
    height: float
    points: list[tuple[float, float]] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)

    def keep_clear(self, a: tuple[float, float], b: tuple[float, float], half_width: float = 0.0) -> None:
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

    def place(self, wanted: Wanted) -> Placed:
        """The cheapest place; it is taken from then on."""
        w, h = texts.width(wanted.text, wanted.size) + 2, wanted.size * 1.25
        best, cost = (0.0, 0.0, w, h), math.inf
        for rank, (x, y, dx, dy) in enumerate(wanted.anchors):
            heading = math.atan2(dy, dx)
            for k, turn in enumerate(_TURNS):
                a = heading + math.radians(turn)
                for j, distance in enumerate(_DISTANCES):
                    # the box touches the circle of that distance around the anchor
                    cx = x + math.cos(a) * (distance + w / 2 * abs(math.cos(a)))
                    cy = y + math.sin(a) * (distance + h / 2 * abs(math.sin(a)))
                    box = (cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2)
                    price = self._price(box) + 6 * rank + 1.5 * k + 4 * j
                    if price < cost:
                        best, cost = box, price
        self.boxes.append(best)
        return Placed(wanted, best)

    def _price(self, box: Box) -> float:
        left, top, right, bottom = box
        outside = (
            max(0, 3 - left)
            + max(0, 3 - top)
            + max(0, right - self.width + 3)
            + max(0, bottom - self.height + 3)
        )
        hits = sum(left - 2 < x < right + 2 and top - 1 < y < bottom + 1 for x, y in self.points)
        return 30 * outside + 7 * hits + 0.6 * sum(_overlap(box, other) for other in self.boxes)


def _overlap(a: Box, b: Box) -> float:
    wide = min(a[2], b[2]) - max(a[0], b[0]) + 3
    high = min(a[3], b[3]) - max(a[1], b[1]) + 2
    return wide * high if wide > 0 and high > 0 else 0.0
