"""Convex hulls as solids of a scene: of few points, those of a body that lie farthest out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.formats.mjcf.compiled import outermost
from freebody.moving.fitted_solids import FramePlace, rounded

_THICK = 1e-3
"""Thickness that a flat mesh is given, of its length."""
_POINT = 1e-9
"""Size of points, of how far off they are, below which rounding decides what hull they have."""


@dataclass(frozen=True)
class DrawnHull:
    """A convex polyhedron fixed in a frame (0 the world, 1 + k body k): its corners (m) and its
    triangles, counterclockwise as seen from outside."""

    frame: int
    corners: Array
    faces: Array
    bodies: tuple[int, ...] = ()

    @property
    def ends(self) -> tuple[FramePlace, FramePlace]:
        """The ends of a line through the middle of the hull, along its longest side."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        middle, side = (low + high) / 2, int((high - low).argmax())
        ends = (middle.copy() for _ in "ab")
        places = []
        for end, value in zip(ends, (low[side], high[side]), strict=True):
            end[side] = value
            x, y, z = map(float, end)
            places.append(FramePlace(self.frame, (x, y, z)))
        return places[0], places[1]

    @property
    def data(self) -> list[Any]:
        """The hull as a page reads it."""
        corners = [rounded(x) for x in self.corners.ravel()]
        sides = np.sort(self.corners.max(axis=0) - self.corners.min(axis=0))
        radius = rounded(sides[:2].sum() / 4)  # by which it is grabbed
        places = (end.data for end in self.ends)
        return ["link", *places, radius, corners, self.faces.ravel().tolist(), list(self.bodies)]


def hull(frame: int, points: Sequence[Array], bodies: tuple[int, ...] = ()) -> DrawnHull | None:
    """The hull of points, each array (n, 3) in the frame, m; None where they are one point."""
    from scipy.spatial import ConvexHull, QhullError

    far = outermost(np.concatenate(points))
    try:
        found = ConvexHull(far)
    except QhullError:  # they are in a plane or on a line
        size = float((far.max(axis=0) - far.min(axis=0)).max())
        if size <= _POINT * float(np.abs(far).max()):
            return None
        aside = _THICK * size * np.concatenate([np.eye(3), -np.eye(3)])
        far = outermost((far[:, None] + aside).reshape(-1, 3))
        found = ConvexHull(far)
    corners, faces = far[found.vertices], found.simplices
    numbers = np.zeros(len(far), dtype=int)
    numbers[found.vertices] = np.arange(len(corners))
    a, b, c = (far[faces[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * found.equations[:, :3]).sum(axis=1) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return DrawnHull(frame, corners, numbers[faces], bodies)
