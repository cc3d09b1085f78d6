"""An inverse kinematics problem, and what was found for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.solutions import BranchNames, Verified, named, wrapped
from freebody.lazy import cached_property
from freebody.trees.states import neutral

LimitsChoice = Literal["mark", "drop", "ignore"]
"""Choices of what becomes of solutions beyond the joints' limits."""


@dataclass(frozen=True, eq=False)
class InverseProblem:
    """A problem of inverse kinematics: targets (N, …) of a frame and task."""

    solver: NumericalSolver
    target: Array
    q0: Array | None
    limits: LimitsChoice
    starts: int | None
    seed: int
    searched: bool = False
    """Whether a search is wanted, by its starts or seed."""
    held: Array | None = None
    """(N,): of an arm of seven joints the position of the one that is given."""
    alone: bool = False
    """Whether the robot is solved for but this once, so that no machine code of its own is made."""

    def part(self, rows: np.ndarray) -> InverseProblem:
        """The problem restricted to the targets of the given rows."""
        held = None if self.held is None else self.held[rows]
        return replace(self, target=self.target[rows], held=held)

    def refuse_search(self) -> None:
        """Refuse arguments of a search (starts, seed) where a closed form answers."""
        if self.searched:
            raise FreebodyError(
                f"inverse_kinematics: starts= and seed= are of the numeric search; for "
                f"{self.solver.model.name!r} with frame {self.solver.frame!r} and this task a "
                f"closed form finds all positions. Leave them out."
            )

    @cached_property
    def reference(self) -> Array:
        """q (nq,) next to which angles are wrapped: q0, else the middle of the limits, else 0."""
        if self.q0 is not None:
            return self.q0
        low, high = self.solver.bounds
        both = np.isfinite(low) & np.isfinite(high)
        middle = neutral(self.solver.model)
        middle[both] = (low[both] + high[both]) / 2
        return np.clip(middle, low, high)

    @cached_property
    def rest(self) -> Array:
        """Positions q (nq,) for the coordinates that do not move the frame."""
        if self.q0 is not None:
            return self.q0
        neutral_q = np.clip(neutral(self.solver.model), *self.solver.bounds)
        return wrapped(self.solver, neutral_q[None], self.reference)[0]


@dataclass(frozen=True, eq=False)
class Found:
    """Solutions found for targets (N, …), with room for k of each; missing ones are NaN and "".
    With the method and notes."""

    q: Array
    """Positions (N, k, nq) that were found."""
    miss: Array
    """Distances (N, k) from the targets, by forward kinematics."""
    names: BranchNames | np.ndarray
    """Names of the branches (N, k), or the function that finds them from solutions (…, nq)."""
    method: str
    notes: list[str]

    @property
    def branches(self) -> np.ndarray:
        """The names (N, k) of the solutions' branches; "" where there is no solution."""
        return named(self.names, self.q, np.isfinite(self.miss))

    @property
    def lost(self) -> np.ndarray:
        """The row numbers of the targets without a solution."""
        return np.flatnonzero(~np.isfinite(self.miss).any(axis=-1))

    def with_rows(self, rows: np.ndarray, other: Found) -> Found:
        """The solutions with those for the targets of the given rows replaced by another's."""
        k = max(self.miss.shape[1], other.miss.shape[1])
        alike = callable(self.names) and (
            self.names == other.names if callable(other.names) else np.isnan(other.miss).all()
        )

        def merged(mine: np.ndarray, theirs: np.ndarray) -> np.ndarray:
            whole = _widened(mine, k).astype(np.result_type(mine, theirs))
            whole[rows] = _widened(theirs, k)
            return whole

        return replace(
            self,
            q=merged(self.q, other.q),
            miss=merged(self.miss, other.miss),
            names=self.names if alike else merged(self.branches, other.branches),
        )


def _widened(x: np.ndarray, k: int) -> np.ndarray:
    """The array (N, k, …) with its second axis widened to k, new entries NaN or ""."""
    empty = np.full((len(x), k - x.shape[1], *x.shape[2:]), "" if x.dtype.kind == "U" else np.nan)
    return np.concatenate([x, empty.astype(x.dtype)], axis=1)


def nothing(problem: InverseProblem, method: str) -> Found:
    """The empty result of a problem without targets."""
    return found_in_turn([], None, problem.solver.model.nq, method, [])


def found_in_turn(
    solutions: list[Verified],
    branches: list[list[str]] | None,
    nq: int,
    method: str,
    notes: list[str],
) -> Found:
    """Solutions gathered target by target into arrays; branches: their names, if there are any."""
    N, k = len(solutions), max((len(s.q) for s in solutions), default=0)
    q, miss = np.full((N, k, nq), np.nan), np.full((N, k), np.nan)
    names = np.full((N, k), "", dtype=object)
    for i, s in enumerate(solutions):
        q[i, : len(s.q)], miss[i, : len(s.q)] = s.q, s.miss
        names[i, : len(s.q)] = "" if branches is None else branches[i]
    return Found(q, miss, names.astype(str), method, notes)
