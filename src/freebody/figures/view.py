"""The view of a drawing: places of the world, plane or space, on the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array

WorldPoint = tuple[float, ...]
"""A point of the world, metres."""


@dataclass(frozen=True)
class View:
    """A view of the world: rows to the right and up on the page, and towards the viewer."""

    rows: tuple[WorldPoint, WorldPoint]
    towards: WorldPoint = ()

    def project(self, points: Iterable[Sequence[float]]) -> Array:
        """Page coordinates (k, 2) in metres, y up."""
        return np.asarray(list(points), dtype=float) @ np.asarray(self.rows).T

    def on_page(self, place: Sequence[float] | Array) -> complex:
        """The point x + iy on the page, in metres with y down, of a place or a direction in the
        world."""
        x, y = np.asarray(self.rows) @ np.asarray(place, dtype=float)
        return complex(x, -y)

    def depth(self, points: Iterable[Sequence[float]]) -> float:
        """How near the mean of some points is to the viewer, in metres."""
        if not self.towards:
            return 0.0
        return float(np.mean(np.asarray(list(points), dtype=float) @ np.asarray(self.towards)))

    def shown(self, a: Array, b: Array) -> float:
        """The share of a segment's length that is seen; 1 where nothing is foreshortened."""
        length = float(np.linalg.norm(b - a))
        return float(np.linalg.norm(np.asarray(self.rows) @ (b - a)) / length) if length else 1.0


FLAT = View(((1.0, 0.0), (0.0, 1.0)))


def axonometric(azimuth: float, elevation: float = 24.0) -> View:
    """Parallel projection of space with z up; azimuth of the viewer from x, elevation above the
    ground, degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    towards = (math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e))
    right = (-math.sin(a), math.cos(a), 0.0)
    up = (-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e))
    return View((right, up), towards)


def best_view(
    segments: Sequence[tuple[Array, Array]],
    azimuths: Sequence[float] = (-60, -30, 30, 60, 120, 150, -150, -120),
    elevation: float = 24.0,
) -> View:
    """The axonometric view that shows the given segments least foreshortened; of views that do so
    alike, whatever rounding says, the first."""
    ways = np.array([b - a for a, b in segments] or [np.ones(3)])

    total = float(np.linalg.norm(ways, axis=1).sum()) or 1.0

    def shown(view: View) -> float:
        lengths = np.linalg.norm(ways @ np.asarray(view.rows).T, axis=1)
        return round(float(lengths.sum() + 2.0 * lengths.min()) / total, 9)

    return max((axonometric(azimuth, elevation) for azimuth in azimuths), key=shown)
