"""`workspace`: where the tip of an arm can be, and in how many ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import ShapeError
from freebody.inverse.kinematics import inverse_kinematics
from freebody.inverse.numerical_solver import NumericalSolver
from freebody.inverse.task import read_target
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable
from freebody.values import ByValue

_AT_ONCE = 65536
"""Targets side by side, which bounds the memory."""


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceMap(Tabled, ByValue):
    """In how many ways a frame comes to points (...), within the joints' limits.

    points: (..., dim), m, world axes. ways: (...), or (..., m) for m orientations; 0 out of reach.
    redundant: whether each point that is reached is reached in infinitely many ways; ways is 1
    there. distance: as ways, m, from what can be reached, limits left aside; 0 where only they, or
    the orientation, are in the way. oriented: whether the orientation was given. frame: its name.
    method: how the ways were found.
    """

    points: Array
    ways: np.ndarray
    redundant: bool
    distance: Array
    oriented: bool
    frame: str
    method: str

    @property
    def reached(self) -> np.ndarray:
        """Which points are reached (...), of several orientations in any."""
        found = self.ways > 0
        return np.asarray(found.any(axis=-1)) if self._several else found

    @property
    def share(self) -> Array:
        """Of the orientations the part in which each point is reached (...)."""
        found = (self.ways > 0).astype(float)
        return np.asarray(found.mean(axis=-1)) if self._several else found

    @property
    def _several(self) -> bool:
        return self.ways.ndim == self.points.ndim

    def _title(self) -> str:
        count = self.reached.size
        how = "any orientation"
        if self.oriented:
            how = f"{self.ways.shape[-1]} orientations" if self._several else "one orientation"
        points = f"{int(self.reached.sum())} of {count} points"
        return f"WorkspaceMap: {points} of frame {self.frame!r}, {how}"

    def _table(self) -> TextTable:
        if not self.ways.size:
            return TextTable((), ())
        values, counts = np.unique(self.ways, return_counts=True)
        rows = [
            ("any number" if self.redundant and k else str(k), str(n), f"{n / self.ways.size:.1%}")
            for k, n in zip(values, counts, strict=True)
        ]
        what = "poses" if self.oriented else "points"
        return TextTable(("ways", what, f"of all {what}"), rows, (f"By {self.method}.",))


def workspace(
    model: Model,
    points: ArrayLike,
    frame: str | None = None,
    *,
    orientation: ArrayLike | None = None,
) -> WorkspaceMap:
    """Which points a frame reaches within the joints' limits, and in how many ways.

    points: (..., dim), m, world axes, such as a grid. frame: name, default the tip. orientation:
    (dim, dim), a rotation that the frame keeps, world axes, or several (m, dim, dim), each of which
    is tried at each point; without it the orientation is free.

    The ways are the solutions of `fb.inverse_kinematics`: all of them where it has a closed form,
    else what many starts found, which may miss some. Open chains. Returns WorkspaceMap. Raises
    FreebodyError, ShapeError, NotFiniteError, UnknownNameError.
    """
    function, d = "workspace", model.dim
    model.require_values("the workspace")
    model.require_tree(function)
    if model.family:
        raise FamilyError(function, model.name, model.family)
    name = model.frame(frame).name
    at = as_floats(function, "points", points)
    if at.shape[-1:] != (d,):
        raise ShapeError(function, "points", at.shape, f"(..., {d})", "the last axis is x, y, …")
    refuse_not_finite(function, "points", at, 1)
    target, given = at, None
    if orientation is not None:
        given = as_floats(function, "orientation", orientation)
        if given.ndim not in (2, 3) or given.shape[-2:] != (d, d):
            wanted = f"({d}, {d}) or (m, {d}, {d})"
            raise ShapeError(function, "orientation", given.shape, wanted, "rotations")
        refuse_not_finite(function, "orientation", given, 2)
        target = _poses(at, given)
    task, poses = read_target(function, model, target, None)
    shape = poses.shape[:-2]
    flat = (target if given is None else poses).reshape(-1, *target.shape[len(shape) :])
    ways, distance = np.zeros(len(flat), dtype=int), np.zeros(len(flat))
    method = ""
    for start in range(0, len(flat), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        found = inverse_kinematics(model, flat[part], name)
        ways[part] = (found.valid & found.within_limits).sum(axis=-1)
        distance[part], method = found.distance, found.method
    redundant = NumericalSolver(model, name, task).freedom > 0
    if redundant:
        ways = np.minimum(ways, 1)
    return WorkspaceMap(
        at, ways.reshape(shape), redundant, distance.reshape(shape), given is not None, name, method
    )


def _poses(points: Array, R: Array) -> Array:
    """(..., [m,] dim + 1, dim + 1) of points (..., dim) and rotations ([m,] dim, dim)."""
    d = points.shape[-1]
    batch = (*points.shape[:-1], *R.shape[:-2])
    poses = np.zeros((*batch, d + 1, d + 1))
    poses[..., :d, :d] = R
    poses[..., :d, d] = points[..., None, :] if R.ndim == 3 else points
    poses[..., d, d] = 1.0
    return poses
