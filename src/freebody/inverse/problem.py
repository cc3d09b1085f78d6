"""An inverse kinematics problem, and what was found for it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.inverse.numerical_solver import NumericalSolver
from freebody.inverse.solutions import Verified
from freebody.trees.states import neutral


@dataclass(frozen=True, eq=False)
class Problem:
    """What was asked for: targets (N, …) of a frame and task."""

    solver: NumericalSolver
    target: Array
    q0: Array | None
    limits: str
    starts: int | None
    seed: int

    @property
    def reference(self) -> Array:
        """q (nq,) next to which angles are wrapped: q0, else the middle of the limits, else 0."""
        if self.q0 is not None:
            return self.q0
        low, high = self.solver.bounds
        both = np.isfinite(low) & np.isfinite(high)
        middle = neutral(self.solver.model)
        middle[both] = (low[both] + high[both]) / 2
        return np.clip(middle, low, high)


@dataclass(frozen=True, eq=False)
class Found:
    """What was found for targets (N, …), k at most for one of them, NaN and "" where it has fewer;
    the method, and notes."""

    q: Array
    """(N, k, nq)."""
    miss: Array
    """(N, k), by forward kinematics."""
    branches: np.ndarray
    """(N, k)."""
    method: str
    notes: list[str]

    @property
    def lost(self) -> np.ndarray:
        """The targets without a solution."""
        return np.flatnonzero(~np.isfinite(self.miss).any(axis=-1))

    def with_rows(self, rows: np.ndarray, other: Found) -> Found:
        """The same with what another found for the targets of these rows."""
        k = max(self.miss.shape[1], other.miss.shape[1])

        def merged(mine: np.ndarray, theirs: np.ndarray) -> np.ndarray:
            whole = _widened(mine, k).astype(np.result_type(mine, theirs))
            whole[rows] = _widened(theirs, k)
            return whole

        return replace(
            self,
            q=merged(self.q, other.q),
            miss=merged(self.miss, other.miss),
            branches=merged(self.branches, other.branches),
        )


def _widened(x: np.ndarray, k: int) -> np.ndarray:
    """(N, k, …) with nothing in the new columns."""
    empty = np.full((len(x), k - x.shape[1], *x.shape[2:]), "" if x.dtype.kind == "U" else np.nan)
    return np.concatenate([x, empty.astype(x.dtype)], axis=1)


def found_in_turn(
    solutions: list[Verified], branches: list[list[str]], nq: int, method: str, notes: list[str]
) -> Found:
    """What was found target by target."""
    N, k = len(solutions), max((len(s.q) for s in solutions), default=0)
    q, miss = np.full((N, k, nq), np.nan), np.full((N, k), np.nan)
    names = np.full((N, k), "", dtype=object)
    for i, (s, given) in enumerate(zip(solutions, branches, strict=True)):
        q[i, : len(s.q)], miss[i, : len(s.q)], names[i, : len(s.q)] = s.q, s.miss, given
    return Found(q, miss, names.astype(str), method, notes)
