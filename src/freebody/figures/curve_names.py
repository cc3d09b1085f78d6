"""Names beside the curves of a plot, where there is room for them; the others need a legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from freebody.arrays import Array
from freebody.figures.labelling import RULE, Box, Crowd, Wanted, overlaps
from freebody.figures.marked_text import width

SIZE = 12.0
"""Height of the letters of a name, pixels."""
_PLACES = 13
"""Samples of a curve beside which its name may stand, evenly spaced along the plot."""
_TRIED = 6
"""How many of them, those farthest from other curves, are tried."""
_AWAY = 20.0
"""Pixels: a name farther from its curve is not seen to be of it."""
_COVERED = 2
"""Points of curves that a name may cover."""


@dataclass(frozen=True)
class CurveName:
    """A name that stands beside its curve: the middle of its line of text, pixels."""

    name: str
    at: complex


def named_curves(
    curves: Mapping[str, Array], box: Box, taken: Sequence[Box] = ()
) -> list[CurveName]:
    """The names that have a place beside their curves, inside a plot's box.

    curves: points (k, 2) of each curve by name, pixels, NaN where it is interrupted. taken: boxes
    of other texts.
    """
    left, top, right, bottom = box
    corner = complex(left, top)
    crowd = Crowd(right - left, bottom - top)
    crowd.boxes += [(a - left, b - top, c - left, d - top) for a, b, c, d in taken]
    xs = np.linspace(0.06, 0.94, _PLACES) * crowd.width
    heights = np.array([_height(points - (left, top), xs) for points in curves.values()])
    for points in curves.values():
        for a, b in pairwise(points - (left, top)):
            if np.isfinite([a, b]).all():
                crowd.keep_clear(complex(*a), complex(*b))
    wanted = [
        Wanted(name, "", _anchors(heights, k, xs, crowd.height), width(name, SIZE))
        for k, name in enumerate(curves)
    ]
    before, points = len(crowd.boxes), np.array(crowd.points)
    boxes = crowd.settle([w for w in wanted if w.anchors])
    found = iter(boxes)
    placed: list[CurveName] = []
    standing: list[Box] = crowd.boxes[:before]
    for want in wanted:
        if not want.anchors:
            continue
        own = next(found)
        if _reads_well(own, want, standing, points, crowd):
            standing.append(own)
            middle = complex((own[0] + own[2]) / 2, own[3] - RULE["below"])
            placed.append(CurveName(want.text, corner + middle))
    return placed


def _height(points: Array, xs: Array) -> Array:
    """The height of a curve at some places along the plot; NaN where it has none."""
    there = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(there) < 2:
        return np.full(len(xs), np.nan)
    x, y = points[there].T
    next_one = np.clip(np.searchsorted(x, xs), 1, len(x) - 1)
    bridged = there[next_one] - there[next_one - 1] > 1
    return np.where(bridged, np.nan, np.interp(xs, x, y, left=np.nan, right=np.nan))


def _anchors(heights: Array, k: int, xs: Array, tall: float) -> list[tuple[complex, complex]]:
    """The places of curve k that are farthest from the other curves and the plot's edges, the best
    first, each with the way to the larger gap beside it."""
    own = heights[k]
    edges = np.array([np.zeros_like(own), np.full_like(own, tall)])
    others = np.concatenate([np.delete(heights, k, axis=0), edges]) - own
    above = np.nanmin(np.where(others <= 0, -others, np.inf), axis=0)
    below = np.nanmin(np.where(others > 0, others, np.inf), axis=0)
    room = np.where(np.isfinite(own), np.maximum(above, below), -1.0)
    best = [int(j) for j in np.argsort(-room, kind="stable")[:_TRIED] if room[j] > 0]
    return [(complex(xs[j], own[j]), -1j if above[j] >= below[j] else 1j) for j in best]


def _reads_well(
    own: Box, want: Wanted, standing: Sequence[Box], points: Array, crowd: Crowd
) -> bool:
    """Whether a name stands inside the plot near its curve, on no other text and on no curve."""
    left, top, right, bottom = own
    if left < 0 or top < 0 or right > crowd.width or bottom > crowd.height:
        return False
    here = np.array([own])
    if any(float(overlaps(here, other, (0.0, 0.0))[0]) > 0 for other in standing):
        return False
    x, y = points.real, points.imag
    if ((left < x) & (x < right) & (top + 3 < y) & (y < bottom - 3)).sum() > _COVERED:
        return False
    nearest = min(
        abs(complex(min(max(a.real, left), right), min(max(a.imag, top), bottom)) - a)
        for a, _ in want.anchors
    )
    return nearest <= _AWAY
