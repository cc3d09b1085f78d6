"""`workspace`: the points that the tip of an arm reaches, and in how many ways."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import ShapeError
from freebody.inverse.kinematics import inverse_kinematics
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.problem import InverseProblem
from freebody.inverse.problem.task import Task, read_target
from freebody.inverse.ways.closed_chains import of_closed_chain, still_moves, unmeasured
from freebody.model.doubts import RANGES, Doubt, attribute, doubts_used, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.values import ByValue

if TYPE_CHECKING:
    import xarray as xr

_AT_ONCE = 65536
"""Targets of an open chain side by side, which bounds the memory."""
_MODES_AT_ONCE = 4096
"""Targets of a closed chain side by side."""


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceMap(Tabled, ByValue):
    """The number of ways in which a frame reaches points (...), within the joints' limits.

    points: (..., dim), m, world axes. ways: (...), or (..., m) for m orientations, of a family
    (..., [m,] *family); 0 out of reach. redundant: whether each point that is reached is reached in
    infinitely many ways; ways is 1 there. distance: as ways, m, from the reachable set without
    limits; 0 where only limits or the orientation prevent it; NaN out of a closed chain's reach.
    oriented: whether the orientation was given. frame: its name. method: how the ways were found.
    family: the shape of the family. doubts: those on the limits of positions.
    """

    points: Array
    ways: np.ndarray
    redundant: bool
    distance: Array
    oriented: bool
    frame: str
    method: str
    family: tuple[int, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)

    @property
    def reached(self) -> np.ndarray:
        """Flags of the points that are reached (..., *family), with several orientations in any of
        them."""
        found = self.ways > 0
        return np.asarray(found.any(axis=self._axis)) if self._several else found

    @property
    def share(self) -> Array:
        """The fraction of the orientations in which each point is reached (..., *family)."""
        found = (self.ways > 0).astype(float)
        return np.asarray(found.mean(axis=self._axis)) if self._several else found

    @property
    def _axis(self) -> int:
        """The index of the axis of several orientations."""
        return self.points.ndim - 1

    @property
    def _several(self) -> bool:
        return self.ways.ndim > self._axis + len(self.family)

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the points, with their places as coordinates: ways, distance,
        share and reached."""
        dims = axes_of("point", self.points.ndim - 1)
        family = axes_of("member", len(self.family))
        all_of = (*dims, *(("orientation",) if self._several else ()), *family)
        entries = {
            "ways": (all_of, self.ways, "1", "ways to reach it within the limits"),
            "distance": (all_of, self.distance, "m", "distance from what can be reached"),
            "reached": ((*dims, *family), self.reached, "1", "whether it is reached"),
            "share": ((*dims, *family), self.share, "1", "part of the orientations"),
        }
        places = {
            axis: (dims, self.points[..., k], "m", f"{axis} of the point")
            for k, axis in enumerate("xyz"[: self.points.shape[-1]])
        }
        about = {"frame": self.frame, "method": self.method, "redundant": int(self.redundant)}
        return labelled(entries, places, about | attribute(self.doubts))

    def _title(self) -> str:
        count = self.reached.size
        how = "any orientation"
        if self.oriented:
            many = self.ways.shape[self._axis] if self._several else 0
            how = f"{many} orientations" if self._several else "one orientation"
        members = f" of {int(np.prod(self.family))} members" if self.family else ""
        points = f"{int(self.reached.sum())} of {counted(count, 'point')}{members}"
        end = named(self.doubts)
        return f"Workspace: frame {self.frame!r} reaches {points}, {how}{end}"

    def _table(self) -> TextTable:
        if not self.ways.size:
            return TextTable((), ())
        values, counts = np.unique(self.ways, return_counts=True)
        rows = [
            ("any number" if self.redundant and k else str(k), str(n), f"{n / self.ways.size:.1%}")
            for k, n in zip(values, counts, strict=True)
        ]
        what = "poses" if self.oriented else "points"
        notes = (f"By {self.method}.", *filter(None, [in_one_line(self.doubts)]))
        return TextTable(("ways", what, f"of all {what}"), rows, notes)


def workspace(
    model: Model,
    points: ArrayLike,
    frame: str | None = None,
    *,
    orientation: ArrayLike | None = None,
) -> WorkspaceMap:
    """The points that a frame reaches within the joints' limits, and in how many ways.

    The ways are the solutions of `fb.inverse_kinematics`: all of them where it has a closed form,
    else what many starts found, which may miss some; of a closed chain its working modes, all
    loops closed. Each member of a family is asked for each point.

    Parameters
    ----------
    model
        The robot.
    points : (..., dim), m, world axes
        Points, such as a grid.
    frame
        Name of the frame; None: the tip.
    orientation : (dim, dim), or (m, dim, dim), world axes
        A rotation that the frame keeps, or several, each of which is tried at each point; None: the
        orientation is free.

    Returns
    -------
    WorkspaceMap

    Raises
    ------
    FreebodyError, ShapeError, NotFiniteError, UnknownNameError
    """
    function, d = "workspace", model.dim
    model.require_values("the workspace")
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
    find = _closed_chain if model.loops else _open_chain
    ways, distance, method, redundant = find(model, name, task, flat)
    if redundant:
        ways = np.minimum(ways, 1)
    whole = (*shape, *model.family)
    return WorkspaceMap(
        at,
        ways.reshape(whole),
        redundant,
        distance.reshape(whole),
        given is not None,
        name,
        method,
        model.family,
        doubts_used(model, RANGES),
    )


Ways = tuple[np.ndarray, Array, str, bool]
"""Ways and distances (N, *family), how they were found, and whether there are infinitely many."""


def _open_chain(model: Model, frame: str, task: Task, target: Array) -> Ways:
    ways = np.zeros((len(target), *model.family), dtype=int)
    distance, method = np.zeros(ways.shape), ""
    one = model[(0,) * len(model.family)] if model.family else model
    of_members = (1,) * len(model.family)
    at_once = max(1, _AT_ONCE // int(np.prod(model.family)))
    for start in range(0, len(target), at_once):
        part = slice(start, start + at_once)
        goals = target[part].reshape(-1, *of_members, *target.shape[1:])
        found = inverse_kinematics(model, goals, frame)
        ways[part] = (found.valid & found.within_limits).sum(axis=-1)
        distance[part], method = found.distance, found.method
    return ways, distance, method, NumericalSolver(one, frame, task).freedom > 0


def _closed_chain(model: Model, frame: str, task: Task, target: Array) -> Ways:
    if model.family:
        each = [
            _closed_chain(model[index], frame, task, target) for index in np.ndindex(model.family)
        ]
        shape = (len(target), *model.family)
        ways, distance = (np.stack([x[k] for x in each], -1).reshape(shape) for k in (0, 1))
        return ways, distance, each[0][2], any(x[3] for x in each)
    _, poses = read_target("workspace", model, target, None)
    solver, method, redundant = NumericalSolver(model, frame, task), "", False
    ways, distance = np.zeros(len(poses), dtype=int), np.zeros(len(poses))
    for start in range(0, len(poses), _MODES_AT_ONCE):
        part = slice(start, start + _MODES_AT_ONCE)
        problem = InverseProblem(solver, poses[part], None, "mark", None, 0)
        found = of_closed_chain(problem, problem.target.shape[:1], away=unmeasured)
        ways[part] = (found.valid & found.within_limits).sum(axis=-1)
        distance[part], method = found.distance, found.method
        some = found.q[found.valid][:1]
        redundant = redundant or (len(some) > 0 and still_moves(problem, some[0]))
    return ways, distance, method, redundant


def _poses(points: Array, R: Array) -> Array:
    """Poses (..., [m,] dim + 1, dim + 1) made of points (..., dim) and rotations ([m,] dim,
    dim)."""
    d = points.shape[-1]
    batch = (*points.shape[:-1], *R.shape[:-2])
    poses = np.zeros((*batch, d + 1, d + 1))
    poses[..., :d, :d] = R
    poses[..., :d, d] = points[..., None, :] if R.ndim == 3 else points
    poses[..., d, d] = 1.0
    return poses
