"""The solutions of an inverse kinematics problem, and how candidates become solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.closed_form_inverse.near_reference import LOOSE
from freebody.algorithms.loop_scales import repeating
from freebody.arrays import Array, as_floats, check_core
from freebody.by_value import ByValue
from freebody.inverse.problem.numerical_solver import EXACT, NumericalSolver
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted

_OUTSIDE = "  (outside the limits)"
_TURN = 2 * np.pi
APART = 1e-6
"""Joint positions nearer than this (rad, m) are one solution."""
ALIKE = 1e-2
"""Solutions of a redundant arm nearer than this (rad, m) are one: they are samples of a
continuum."""
BranchNames = Callable[[Array], np.ndarray]
"""Solutions q (…, nq) -> the names (…) of their branches."""


def named(names: BranchNames | np.ndarray, q: Array, there: np.ndarray) -> np.ndarray:
    """The names (..., k) of solutions q (..., k, nq), "" where there is none."""
    if not callable(names):
        return names
    found = names(q[there])
    whole = np.full(there.shape, "", dtype=found.dtype)
    whole[there] = found
    return whole


@dataclass(frozen=True, eq=False, repr=False)
class Solutions(Tabled, ByValue):
    """Solutions of `inverse_kinematics` for one target, or for a batch of them (...).

    q: (k, nq), one row a solution; of a batch (..., k, nq), k the largest number, NaN where a
    target has fewer. valid: (..., k), which rows are solutions. branches: (..., k) names such as
    "elbow up"; "" where there is no name or no solution. residual: (..., k), by forward kinematics,
    the larger of m and rad. within_limits: (..., k). distance: (...) from the workspace, m; 0 where
    there are solutions, or only the orientation cannot be had. method: what was done. notes: what
    else is worth knowing, such as joints that could stand anywhere.
    """

    q: Array
    branches: np.ndarray
    residual: Array
    within_limits: np.ndarray
    distance: Array
    method: str
    notes: tuple[str, ...] = ()

    @classmethod
    def lazily_named(cls, names: BranchNames, **fields: Any) -> Solutions:
        """Solutions from all fields but the branches' names, which are found on first access."""
        made = object.__new__(cls)
        vars(made).update(fields, _names=names)
        for name in ("q", "residual", "within_limits", "distance"):
            fields[name].flags.writeable = False
        return made

    @classmethod
    def of_kernel(
        cls, names: BranchNames, q: Array, residual: Array, within: Array, others: dict[str, Any]
    ) -> Solutions:
        """Solutions from a kernel's outputs without delay: within (..., branches), 1 where the
        limits are kept, becomes flags on first access; others: read-only fields that no kernel
        gives, and `_ignored` where limits do not count."""
        q.setflags(write=False)
        residual.setflags(write=False)
        made = object.__new__(cls)
        known = made.__dict__
        known.update(others)
        known["q"] = q
        known["residual"] = residual
        known["_within"] = within
        known["_names"] = names
        return made

    def __getattr__(self, name: str) -> Any:
        known = vars(self)
        if name == "branches" and "_names" in known:
            found = named(known["_names"], self.q, self.valid)
        elif name == "within_limits" and "_within" in known:
            kept = np.equal(known["_within"][..., : len(self)], 1.0)
            found = self.valid if "_ignored" in known else kept
        else:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        found.flags.writeable = False
        return known.setdefault(name, found)

    def __dir__(self) -> list[str]:
        return sorted(
            {*super().__dir__(), "branches", "within_limits"}
        )  # before they are asked for too

    def __len__(self) -> int:
        """The number of rows for each target: the number of solutions of the target that has
        most."""
        return self.q.shape[-2]

    @property
    def valid(self) -> np.ndarray:
        """Which rows of q are solutions (..., k); the others are NaN."""
        return np.isfinite(self.residual)

    @property
    def count(self) -> np.ndarray:
        """How many solutions each target has (...)."""
        return np.asarray(self.valid.sum(axis=-1))

    def nearest(self, q: ArrayLike) -> Array:
        """The solution (..., nq) nearest to q (nq,) or (..., nq), NaN where there is none.

        Angles count as they are, whole turns too: found with q0=q, they are next to it.
        """
        size = self.q.shape[-1]
        at = as_floats("Solutions.nearest", "q", q)
        check_core("Solutions.nearest", "q", at, (size,), f"the model has nq = {size}")
        way = self.q - at[..., None, :]
        far = np.where(self.valid, np.sqrt(np.sum(way * way, axis=-1)), np.inf)
        none = np.full((*far.shape[:-1], 1), np.inf)
        best = np.argmin(np.concatenate([far, none], axis=-1), axis=-1)
        last = np.full((*self.q.shape[:-2], 1, size), np.nan)
        every = np.concatenate([self.q, last], axis=-2)
        return np.take_along_axis(every, best[..., None, None], axis=-2)[..., 0, :]

    def at(self, q: Array, family: tuple[int, ...]) -> Solutions:
        """The same solutions as positions q (..., k, n) of another robot, or of all members of a
        family, NaN where there are none."""
        whole = np.where(self.valid[..., None], q, np.nan)
        batch, k = np.broadcast_shapes(self.distance.shape, family), len(self)
        return replace(
            self,
            q=np.broadcast_to(whole, (*batch, *whole.shape[-2:])),
            branches=np.broadcast_to(self.branches, (*batch, k)),
            residual=np.broadcast_to(self.residual, (*batch, k)),
            within_limits=np.broadcast_to(self.within_limits, (*batch, k)),
            distance=np.broadcast_to(self.distance, batch),
        )

    def _found(self) -> str:
        if self.q.ndim > 2:
            least, most = int(self.count.min()) if self.count.size else 0, len(self)
            span = f"{most}" if least == most else f"{least} to {most}"
            shape = self.q.shape[:-2]
            targets = counted(shape[0], "target") if len(shape) == 1 else f"{shape} targets"
            return f"{targets}, {span} solutions each; {self.method}"
        return f"{counted(len(self), 'solution')}; {self.method}"

    def _title(self) -> str:
        return f"Solutions: {self._found()}"

    def _table(self) -> TextTable:
        if self.q.ndim > 2:
            return TextTable((), (), self.notes)
        head = (
            "",
            "name",
            *(f"q[{k}]" for k in range(self.q.shape[-1])),
            "residual",
            "within limits",
        )
        rows = [
            (str(k), str(name), *(f"{x:.4f}" for x in q), f"{miss:.1e}", "yes" if fine else "no")
            for k, (q, name, miss, fine) in enumerate(
                zip(self.q, self.branches, self.residual, self.within_limits, strict=True)
            )
        ]
        return TextTable(head, rows, self.notes)

    def __str__(self) -> str:
        if self.q.ndim > 2:
            return "\n".join([self._found(), *self.notes])
        rows = []
        for q, name, fine in zip(self.q, self.branches, self.within_limits, strict=True):
            shown = np.array2string(q, precision=6, suppress_small=True, max_line_width=200)
            rows.append(f"  {shown}  {name}{_OUTSIDE * (not fine)}".rstrip())
        return "\n".join([self._found(), *rows, *self.notes])


@dataclass(frozen=True, eq=False)
class Verified:
    """The verified solutions of one target: q (k, nq), misses (k,), and the rows of the candidates
    that they came from."""

    q: Array
    miss: Array
    row: np.ndarray


def verified(
    solver: NumericalSolver, q: Array, target: Array, reference: Array, apart: float = APART
) -> list[Verified]:
    """The solutions among candidates q (N, k, nq): those that reach their targets (N, …), polished,
    wrapped, each once.

    Positions nearer to each other than `apart` (rad, m) count as one.
    """
    N, k, nq = q.shape
    flat, goals = q.reshape(-1, nq), np.repeat(target, k, axis=0)
    good = np.flatnonzero(np.isfinite(flat).all(axis=-1))
    miss = np.full(N * k, np.inf)
    if len(good):
        miss[good] = solver.miss(flat[good], goals[good])
        # one for all that are there already and stand alike
        there = (miss <= EXACT).reshape(N, k)
        first = distinct(solver.model, flat.reshape(q.shape), there, 0.1 * apart).ravel()
        close = miss < 1e-4 * max(1.0, solver.length)
        near = np.flatnonzero(close & (first | ~there.ravel()))
        miss[:] = np.inf
        if len(near):
            flat = flat.copy()
            flat[near], _ = solver.polished(flat[near], goals[near])
            flat[near] = wrapped(solver, flat[near], reference)
            miss[near] = solver.miss(flat[near], goals[near])
    kept = distinct(solver.model, flat.reshape(q.shape), (miss <= EXACT).reshape(N, k), apart)
    return [
        Verified(flat[rows + i * k], miss[rows + i * k], rows)
        for i, rows in enumerate(map(np.flatnonzero, kept))
    ]


def wrapped(solver: NumericalSolver, q: Array, reference: Array) -> Array:
    """Positions q (N, nq) with angles moved by whole turns: into their limits where possible, and
    within these next to `reference`."""
    turns = turning_coordinates(solver.model)
    low, high = (bound[turns] for bound in solver.bounds)
    x = q[:, turns]
    with np.errstate(invalid="ignore"):
        # half a turn away, to rounding, is above the reference
        x = x - _TURN * np.ceil((x - reference[turns] - LOOSE) / _TURN - 0.5)
        up = _TURN * np.ceil(np.maximum(low - x - LOOSE, 0.0) / _TURN)
        down = _TURN * np.ceil(np.maximum(x - high - LOOSE, 0.0) / _TURN)
        moved = x + up - down
        fits = (moved >= low - LOOSE) & (moved <= high + LOOSE)
    q = q.copy()
    q[:, turns] = np.where(fits, moved, x)
    return q


def distinct(model: Model, q: Array, there: np.ndarray, apart: float) -> np.ndarray:
    """Flags (N, k) of the positions q (N, k, nq) marked in `there` that differ from all earlier
    ones of their target by more than `apart`."""
    turn = _TURN * turning_coordinates(model)

    def alike(rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        way = q[rows] - q[rows, first][:, None]
        way -= turn * np.round(way / _TURN)
        return np.asarray((np.abs(way) <= apart).all(axis=-1))

    return each_once(there, alike)


def each_once(
    there: np.ndarray, alike: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Flags (N, k) of the solutions marked in `there` that equal no earlier one; alike: (rows (M,),
    one solution of each (M,)) -> which of the row's solutions equal it (M, k)."""
    kept, left = np.zeros(there.shape, dtype=bool), there.copy()
    while len(rows := np.flatnonzero(left.any(axis=1))):
        first = np.argmax(left[rows], axis=1)
        kept[rows, first] = True
        left[rows] &= ~alike(rows, first)
        left[rows, first] = False
    return kept


def turning_coordinates(model: Model) -> np.ndarray:
    """Flags (nq,) of the entries of q that are angles which repeat after a turn, also through mimic
    joints that follow them."""
    mask, again = np.zeros(model.nq, dtype=bool), repeating(model.tree)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.kind.nq == body.kind.nv:
            mask[list(at.q)] = [again[k] for k in at.v]
    return mask


def within(solver: NumericalSolver, q: Array) -> np.ndarray:
    """Whether q (..., nq) lies within the limits, to rounding."""
    low, high = solver.bounds
    return np.asarray(((q >= low - LOOSE) & (q <= high + LOOSE)).all(axis=-1))
