"""Labels of drawings: what they show (an element's name, its value, or both), and where they stand.

Each label tries places around its anchors and takes the one with least overlap.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError, shown
from freebody.figures.drawing import Arc, Arrow, Dimension, Element, Label, Turn, metres
from freebody.model.model import Model
from freebody.outputs.number_text import significant

LABELS = ("names", "values", "both")


def labels_of(caller: str, model: Model, labels: str | None) -> str:
    """The kind of labels, one of `LABELS`; by default both names and values where the model has all
    values, else names.

    Raises UnknownNameError, and MissingValueError where values are asked for that are not there.
    """
    if labels is None:
        return "names" if model.missing else "both"
    if labels not in LABELS:
        raise UnknownNameError("choice", labels, f"{caller}: labels=", LABELS)
    if labels != "names":
        model.require_values(f"{caller} with labels={labels!r}")
    return labels


def chosen_of(caller: str, show: str | Iterable[str], known: Collection[str]) -> tuple[str, ...]:
    """The choices named in `show`, as one name or several, each once.

    Raises UnknownNameError for one that is not known, FreebodyError for what is no name.
    """
    if not isinstance(show, Iterable):
        raise FreebodyError(f"{caller}: show is {shown(show)}; give a name, or several.")
    chosen = (show,) if isinstance(show, str) else tuple(show)
    for name in chosen:
        if name not in list(known):
            raise UnknownNameError("choice", name, f"{caller}: show=", known)
    return tuple(dict.fromkeys(chosen))


def quantity(element: Element) -> str:
    """An element's value with its unit as text, of a vector its magnitude; "" where it has none."""
    match element:
        case Arrow(value=value, unit=unit) if value and unit:
            size = value[0] if len(value) == 1 else float(np.linalg.norm(value))
            return f"{significant(size)} {unit}"
        case Turn():
            return f"{significant(element.value)} {element.unit}"
        case Arc():
            return f"{significant(math.degrees(element.sweep))}°"
        case Dimension():
            return metres(math.dist(element.start, element.end))
        case _:
            return ""


def beside(element: Element, labels: str) -> tuple[str, str]:
    """The label of an element: a formula, and the plain text behind it."""
    name = element.text if isinstance(element, Label) else getattr(element, "label", "")
    value = quantity(element) if name and labels != "names" else ""
    if not value:
        return name, ""
    if labels == "values":
        return "", value
    magnitude = isinstance(element, Arrow) and len(element.value) > 1
    return name, f"\u2002{value}" if magnitude else f" = {value}"


Box = tuple[float, float, float, float]
"""Left, top, right, bottom in pixels."""

RULE: dict[str, Any] = {
    "turns": [0, 25, -25, 50, -50, 80, -80, 110, -110, 145, -145, 180],
    "distances": [
        [6, 0], [11, 1.5], [18, 4], [28, 9], [42, 18], [60, 32], [84, 55], [115, 85], [160, 130],
    ],
    "turn": 1, "anchor": 6, "line": 10, "near": 0.6, "forbidden": 1000, "outside": 30, "stay": 8,
    "above": 13.5, "below": 6, "edge": 3, "apart": [3, 2], "beside": [2, -1], "spacing": 5,
    "sweeps": 6, "leader": 36,
}  # fmt: skip
"""The rule of drawings on paper and of those that move. A place is a turn (degrees) from the
direction that is wanted and a distance (pixels, with its price) from an anchor; further turns and
anchors cost more. So do points of lines under the text, which are so many pixels apart, the area
that it shares with what is nearer than `apart`, and in a drawing that moves another place than
before. What is off the page (or nearer to its edge than `edge`) or on another text is forbidden: it
is taken where nothing else is left. A text so far away from its anchor has a line that leads to
it."""


@dataclass(frozen=True)
class Wanted:
    """A label that needs a place: its formula, the plain text behind it, and the anchors that it
    may stand at."""

    text: str
    css: str
    anchors: Sequence[tuple[complex, complex]]
    """Places on the page, the best first, each with the direction in which it would like to go."""
    width: float
    """Width of the label in pixels."""
    after: str = ""


@dataclass
class Crowd:
    """The page as far as it is taken: points of lines to keep clear of, boxes of text, and the
    page's edge."""

    width: float
    height: float
    points: list[complex] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)

    def keep_clear(self, a: complex, b: complex, half_width: float = 0.0) -> None:
        """Mark points along a segment, or along both edges of a bar, as taken."""
        length = abs(b - a)
        n = max(int(length / RULE["spacing"]), 1)
        across = 1j * (b - a) / length * half_width if length else 0.0
        for side in (-across, across) if half_width else (0.0,):
            self.points += [a + (b - a) * k / n + side for k in range(n + 1)]

    def settle(self, wanted: Sequence[Wanted]) -> list[Box]:
        """Boxes of all wanted labels: placed one after the other, then again among the others until
        none moves, in both orders, of which the cheaper result is kept."""
        choices = [_candidates(w) for w in wanted]
        choices = [(boxes, prices + self._fixed(boxes)) for boxes, prices in choices]
        order = range(len(choices))
        settled = (self._settled(choices, way) for way in (order, order[::-1]))
        _, placed = min(settled, key=itemgetter(0))
        self.boxes += placed
        return placed

    def _settled(
        self, choices: Sequence[tuple[Array, Array]], order: Iterable[int]
    ) -> tuple[float, list[Box]]:
        """The total price of placing labels in a given order, and their boxes."""
        placed: dict[int, Box] = {}
        total = 0.0
        for _ in range(1 + RULE["sweeps"]):
            before, total = dict(placed), 0.0
            for k in order:
                others = [box for i, box in placed.items() if i != k]
                price, placed[k] = self._cheapest(*choices[k], others)
                total += price
            if placed == before:
                break
        return total, [placed[k] for k in sorted(placed)]

    def _cheapest(self, boxes: Array, prices: Array, others: Iterable[Box]) -> tuple[float, Box]:
        total = prices.copy()
        for other in (*self.boxes, *others):
            total += RULE["near"] * overlaps(boxes, other)
            total += RULE["forbidden"] * (overlaps(boxes, other, (0.0, 0.0)) > 0.0)
        best = int(np.argmin(total))
        left, top, right, bottom = boxes[best].tolist()
        return float(total[best]), (left, top, right, bottom)

    def _fixed(self, boxes: Array) -> Array:
        """The price of each box that does not depend on other labels: for leaving the page and for
        covering lines."""
        left, top, right, bottom = boxes.T
        edge, (wide, high) = RULE["edge"], RULE["beside"]
        outside = np.maximum(0, edge - left) + np.maximum(0, edge - top)
        outside += np.maximum(0, right - self.width + edge)
        outside += np.maximum(0, bottom - self.height + edge)
        x, y = np.array([(p.real, p.imag) for p in self.points]).reshape(-1, 2).T
        hit = (left[:, None] - wide < x) & (x < right[:, None] + wide)
        hit &= (top[:, None] - high < y) & (y < bottom[:, None] + high)
        forbidden = RULE["forbidden"] * (outside > 0) + RULE["outside"] * outside
        return forbidden + RULE["line"] * hit.sum(axis=1)


def _candidates(wanted: Wanted) -> tuple[Array, Array]:
    """Candidate boxes (k, 4) of a label around its anchors, and the price of each for its distance
    from the preferred place."""
    half = complex(wanted.width + 2, RULE["above"] + RULE["below"]) / 2
    boxes, prices = [], []
    for rank, (anchor, way) in enumerate(wanted.anchors):
        for k, turn in enumerate(RULE["turns"]):
            u = cmath.rect(1.0, cmath.phase(way) + math.radians(turn))
            for distance, price in RULE["distances"]:
                # the box touches the circle of that distance around the anchor
                beyond = complex(half.real * u.real * abs(u.real), half.imag * u.imag * abs(u.imag))
                centre = anchor + u * distance + beyond
                low, high = centre - half, centre + half
                boxes.append((low.real, low.imag, high.real, high.imag))
                prices.append(RULE["anchor"] * rank + RULE["turn"] * k + price)
    return np.array(boxes), np.array(prices)


def overlaps(boxes: Array, other: Box, apart: Sequence[float] = tuple(RULE["apart"])) -> Array:
    """Area that each box shares with another, with a margin beside it and above."""
    left, top, right, bottom = boxes.T
    wide = np.minimum(right, other[2]) - np.maximum(left, other[0]) + apart[0]
    high = np.minimum(bottom, other[3]) - np.maximum(top, other[1]) + apart[1]
    return np.maximum(wide, 0.0) * np.maximum(high, 0.0)


def leader(anchor: complex, box: Box) -> complex | None:
    """The point at which the line from an anchor meets a label's box; None for a label near its
    anchor, which needs no line."""
    left, top, right, bottom = box
    x, y = min(max(anchor.real, left), right), min(max(anchor.imag, top), bottom)
    return complex(x, y) if abs(complex(x, y) - anchor) > RULE["leader"] else None
