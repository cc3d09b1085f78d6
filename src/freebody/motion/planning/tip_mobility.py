"""The motions that the joints can give a frame: their number, how far a position is from having
fewer, and Newton's method towards a pose as far as they allow.

These motions are the columns of the frame's Jacobian, of a closed chain over what its loops allow;
lengths count over the robot's. Their number is that at almost every position: 4 of a SCARA's 6, 5
of an arm with five axes. A position with fewer is singular.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.inverse.problem.numerical_solver import EXACT, NumericalSolver
from freebody.lazy import cached_property
from freebody.loops.equations import closing, scaled_jacobian
from freebody.loops.scaled_equations import RANK, null_space
from freebody.trees.states import difference, generic_state

_POSITIONS = 8
_ASIDE = 0.1  # rad, or of the mechanism's length: how far closed positions are looked for
_CLOSED = 1e-11
_JUMP = 0.3  # rad, or of the arm's length: what is farther is on another branch
_STEPS = 60
_OPEN = 1e-10  # scaled loop equations


@dataclass(frozen=True, eq=False)
class TipMobility:
    """The motions of a frame on a branch. columns: coordinates (in an open chain those that move
    the frame). freedom: their number of motions at almost every position. rank: the number of the
    frame's motions in the task's rows; placing: in its linear rows alone."""

    solver: NumericalSolver
    columns: list[int]
    freedom: int
    rank: int
    placing: int

    @staticmethod
    def of(solver: NumericalSolver, q0: Array) -> TipMobility:
        """The mobility on the branch of q0 (nq,)."""
        model = solver.model
        columns = list(range(model.nv)) if model.loops else np.flatnonzero(solver.moving).tolist()
        found = [_ranks(solver, q, columns) for q in _positions(solver, q0)]
        freedom = min(moves for moves, _, _ in found)
        usual = [ranks for moves, *ranks in found if moves == freedom]
        return TipMobility(solver, columns, freedom, *(max(x) for x in zip(*usual, strict=True)))

    @property
    def held(self) -> int:
        """The number of motions that the loops prevent."""
        return len(self.columns) - self.freedom

    def posture(self, q: Array) -> TipPosture:
        """Posture of the arm at q (nq,)."""
        T, _ = self.solver.pose_and_jacobian(q)
        return TipPosture(self, q, self.solver.equations(q, T)[1][:, self.columns])


@dataclass(frozen=True, eq=False)
class TipPosture:
    """A position q (nq,) and slopes (r + m, n) of the task's rows and the loops there, as angles,
    over the mobility's columns."""

    mobility: TipMobility
    q: Array
    slopes: Array

    @cached_property
    def _allowed(self) -> Array:
        """A basis (n, k) of the motions that the loops allow."""
        return null_space(self.slopes[len(self.mobility.solver.task.rows) :], RANK)[0]

    @cached_property
    def _tip(self) -> tuple[Array, Array]:
        """The left singular vectors and singular values (U, s) of the tip's motions (r, k)."""
        rows = self.slopes[: len(self.mobility.solver.task.rows)]
        U, s, _ = np.linalg.svd(rows @ self._allowed)
        return U, s

    @property
    def ratio(self) -> float:
        """The ratio of the smallest to the largest singular value of the tip's motions; 0 where the
        tip has lost a motion, or the loops allow one more than usual."""
        s, k = self._tip[1], self.mobility.rank
        if self._allowed.shape[1] != self.mobility.freedom:
            return 0.0
        if not k:
            return 1.0
        return float(s[k - 1] / s[0]) if s[0] else 0.0

    @property
    def lost(self) -> Array | None:
        """Factors (r,) of a combination of the tip's velocities that is 0, or smallest, whatever
        the joints do; None where such a combination exists at every position, or the loops allow
        more motions than usual."""
        U, solver = self._tip[0], self.mobility.solver
        if self.mobility.rank < len(U) or self._allowed.shape[1] != self.mobility.freedom:
            return None
        found = U[:, -1] * solver.scale
        return found / found[np.argmax(np.abs(found))]

    @property
    def hold(self) -> float:
        """How clearly the drives of a closed chain determine its joints: 1 at best, 0 where they do
        not."""
        if not self.mobility.solver.model.loops:
            return 1.0
        own = self._allowed[list(self.mobility.solver.model.driven)]
        return float(np.linalg.svd(own, compute_uv=False).min(initial=1.0))

    def holds_like(self, other: TipPosture) -> bool:
        """Whether the small step to another posture passes no position at which the drives do not
        hold the tip."""
        return not self.mobility.solver.model.loops or _alike(self._driven, other._driven)

    def moves_like(self, other: TipPosture) -> bool:
        """Whether two postures a small step apart are on one branch of the inverse kinematics; for
        a redundant arm they always are."""
        return self.mobility.rank < self.mobility.freedom or _alike(self.slopes, other.slopes)

    @property
    def _driven(self) -> Array:
        """The slopes (m + d, n) of the loops and of the drives of a closed chain."""
        solver = self.mobility.solver
        own = np.eye(solver.model.nv)[list(solver.model.driven)]
        return np.concatenate([self.slopes[len(solver.task.rows) :], own])


@dataclass(frozen=True, eq=False)
class TipSteps:
    """Newton steps of a closed or open chain towards a pose: loops first, then the task as far as
    they leave freedom; nearest: the position before the orientation.

    Inverted are as many singular values as are not zero at almost every position.
    """

    mobility: TipMobility
    nearest: bool

    def reached(self, start: Array, goal: Array) -> Array | None:
        """The position (nq,) near start at which no joint motion brings the frame nearer to the
        pose `goal`; None where the steps diverge."""
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
        """(the step (nv,), the largest error that it removes, as an angle) at q (nq,); infinite
        where loops stay open."""
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
        """Pairs (rows of the equations, their rank) in order of priority."""
        mobility, task = self.mobility, self.mobility.solver.task
        linear, counted = len(task.linear), len(task.rows)
        yield [*range(counted, rows)], mobility.held
        if not self.nearest:
            yield [*range(counted)], mobility.rank
            return
        yield [*range(linear)], mobility.placing
        yield [*range(linear, counted)], mobility.rank - mobility.placing


def _alike(a: Array, b: Array) -> bool:
    """Whether two maps (m, n) of rank n, m >= n, have the same orientation; for square ones that
    their determinants have one sign."""
    return bool(np.linalg.slogdet(a.T @ b)[0] > 0.0)


def _positions(solver: NumericalSolver, q0: Array) -> Iterator[Array]:
    """Random positions (nq,), which are regular with near certainty; of a closed chain near q0."""
    model = solver.model
    q, aside, _ = generic_state(model, 0, _POSITIONS)
    if model.loops:
        near = solver.moved(np.tile(q0, (_POSITIONS, 1)), _ASIDE * aside * solver.rates)
        q, left = closing(model, near, range(model.nv))
        q = np.concatenate([q0[None], q[left <= _CLOSED]])
    yield from q


def _ranks(solver: NumericalSolver, q: Array, columns: list[int]) -> tuple[int, int, int]:
    """(numbers of motions of the joints, of the tip, and of the tip's position) at q (nq,)."""
    J = (solver.scale[:, None] * solver.pose_and_jacobian(q)[1] * solver.rates)[:, columns]
    if solver.model.loops:
        J = J @ null_space(scaled_jacobian(solver.model, q), RANK)[0]
    return J.shape[1], _rank(J), _rank(J[: len(solver.task.linear)])


def _rank(J: Array) -> int:
    return int(np.linalg.matrix_rank(J, rtol=RANK)) if J.size else 0
