"""Newton's method towards a pose of the tip: what the joints can do is done, what they cannot is
left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.inverse.problem.numerical_solver import EXACT
from freebody.motion.planning.tip_mobility import TipMobility
from freebody.trees.states import difference

_JUMP = 0.3  # rad, or of the arm's length: what is farther is on another branch
_STEPS = 60
_OPEN = 1e-10  # scaled loop equations


@dataclass(frozen=True, eq=False)
class TipSteps:
    """Loops come first, then the task, as near as they leave the joints free; nearest: of the task
    the position before the orientation.

    Inverted are as many singular values as are not zero at almost every position.
    """

    mobility: TipMobility
    nearest: bool

    def reached(self, start: Array, goal: Array) -> Array | None:
        """The position (nq,) near start at which nothing is missing to the pose `goal` that the
        joints can do; None where that leads away, or nowhere."""
        solver = self.mobility.solver
        q, best, miss = start, None, np.inf
        for _ in range(_STEPS):
            step, left = self._step(q, goal)
            if left <= EXACT and left >= 0.5 * miss:
                return best if miss < left else q
            if left <= EXACT:
                best, miss = q, left
            q = solver.moved(q, step)
            if not np.abs(difference(solver.model, start, q) / solver.rates).max() <= _JUMP:
                return None
        return best

    def _step(self, q: Array, goal: Array) -> tuple[Array, float]:
        """(the step (nv,), the largest angle that it makes good) at q (nq,); infinite where loops
        stay open."""
        mobility = self.mobility
        missing, slopes = mobility.solver.equations(q, goal)
        slopes = slopes[:, mobility.columns]
        step, free, left = np.zeros(slopes.shape[1]), np.eye(slopes.shape[1]), 0.0
        for rows, rank in self._levels(len(missing)):
            A, behind = slopes[rows] @ free, missing[rows] - slopes[rows] @ step
            U, s, Vt = np.linalg.svd(A)
            can = U[:, :rank].T @ behind
            step = step + free @ (Vt[:rank].T @ (can / np.maximum(s[:rank], 1e-300)))
            free, left = free @ Vt[rank:].T, max(left, float(np.abs(can).max(initial=0.0)))
        rates = np.zeros(len(mobility.solver.rates))
        rates[mobility.columns] = step
        loops = missing[len(mobility.solver.task.rows) :]
        if left <= EXACT and not np.abs(loops).max(initial=0.0) <= _OPEN:
            left = np.inf
        return rates * mobility.solver.rates, left

    def _levels(self, rows: int) -> Iterator[tuple[list[int], int]]:
        """(rows of the equations, their rank), what comes first first."""
        mobility, task = self.mobility, self.mobility.solver.task
        linear, counted = len(task.linear), len(task.rows)
        yield [*range(counted, rows)], mobility.held
        if not self.nearest:
            yield [*range(counted)], mobility.rank
            return
        yield [*range(linear)], mobility.placing
        yield [*range(linear, counted)], mobility.rank - mobility.placing
