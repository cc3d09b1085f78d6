"""Inverse kinematics from many starts: for arms without a closed form, and to polish what a closed
form gave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.algorithms.loop_scales import rates_of_lengths
from freebody.algorithms.screws import arm_length
from freebody.arrays import Array
from freebody.inverse.descent_kernel import descend_by_kernel, descent_kernel
from freebody.inverse.levenberg_marquardt import descend
from freebody.inverse.task import Task
from freebody.kernels import structural
from freebody.kernels.formulas import Option
from freebody.kernels.structural import Bound
from freebody.lazy import cached_property
from freebody.loops.equations import scaled_jacobian, scaled_residual
from freebody.loops.scaled_equations import length as mechanism_length
from freebody.model.model import Model
from freebody.model.usable_limits import usable_limits
from freebody.trees.states import generic_state, integrate

EXACT = 1e-10
"""A solution reproduces its target this well (m and rad)."""


@dataclass(frozen=True, eq=False)
class NumericalSolver:
    """Finds positions of a frame of a model that do a task, from many starts."""

    model: Model
    frame: str
    task: Task
    still: int | None = None
    """The place in q of a joint that is not moved."""

    @cached_property
    def length(self) -> float:
        """Length of the arm, of a closed chain of the mechanism (m): what a radian is worth."""
        if self.model.loops:
            return mechanism_length(self.model)
        return arm_length(self.model.tree, self.frame)

    @cached_property
    def rates(self) -> Array:
        """(nv,): the length for rates in m/s, 1 for angular ones."""
        return np.where(rates_of_lengths(self.model.tree), self.length, 1.0)

    @cached_property
    def scale(self) -> Array:
        """(r,): what makes angles of the task's rows."""
        angular = len(self.task.angular)
        return np.array([1.0 / self.length] * len(self.task.linear) + [1.0] * angular)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper limits (nq,), those of followers included; infinite where there are
        none."""
        low, high = np.full(self.model.nq, -np.inf), np.full(self.model.nq, np.inf)
        allowed = usable_limits(self.model)
        for body, at in zip(self.model.bodies, self.model.coordinates, strict=True):
            if body.joint.mimic is None and body.kind.nq == 1:
                low[at.q[0]], high[at.q[0]] = allowed.lower[at.v[0]], allowed.upper[at.v[0]]
        return low, high

    @cached_property
    def moving(self) -> np.ndarray:
        """Which entries of q move the frame (nq,)."""
        tree = self.model.tree
        mask = np.zeros(self.model.nq, dtype=bool)
        for i in ancestors(tree, tree.frames[self.frame][0]):
            mask[list(tree.bodies[i].coordinates.q)] = True
        return mask

    @cached_property
    def freedom(self) -> int:
        """How many coordinates move the frame beyond those that the task takes, at most poses."""
        q, _, _ = generic_state(self.model, 0, 8)
        J = self.pose_and_jacobian(q)[1] / self.length
        used = int((np.abs(J).max(axis=(0, 1)) > 1e-12).sum())
        return used - int(np.linalg.matrix_rank(J, rtol=1e-9).max())

    @cached_property
    def _kernel(self) -> Callable[..., tuple[Array, Array]]:
        names = ("forward_kinematics", "jacobian")
        return structural.fetch(self.model, names, Option(self.frame))

    @cached_property
    def descent(self) -> Bound | None:
        """The kernel of a step of `solve`; None without one."""
        return descent_kernel(self.model, self.frame, self.task.rows, self.columns)

    @property
    def columns(self) -> list[int]:
        """The entries of q that are moved."""
        return [k for k in np.flatnonzero(self.moving).tolist() if k != self.still]

    def pose_and_jacobian(self, q: Array) -> tuple[Array, Array]:
        """T (..., dim + 1, dim + 1) and the counted rows of J (..., r, nv) at q (..., nq)."""
        T, J = self._kernel(q)
        J = J[..., list(self.task.rows), :]
        if self.still is not None:
            at = next(x for x in self.model.coordinates if self.still in x.q)
            J[..., list(at.v)] = 0.0
        return T, J

    def equations(self, q: Array, target: Array, weight: float = 1.0) -> tuple[Array, Array]:
        """(what is missing (..., r + m), its slopes (..., r + m, nv) over `rates`) of the task and
        of a closed chain's loops, as angles; loops count `weight` times."""
        T, J = self.pose_and_jacobian(q)
        missing = self.scale * self.task.error(T, target)
        slopes = self.scale[:, None] * J * self.rates
        model = self.model
        if not model.loops:
            return missing, slopes
        open_by, loops = scaled_residual(model, q), scaled_jacobian(model, q)
        return (
            np.concatenate([missing, -weight * open_by], axis=-1),
            np.concatenate([slopes, weight * loops], axis=-2),
        )

    def miss(self, q: Array, target: Array) -> Array:
        """How far q (..., nq) is from the targets, by forward kinematics: m or rad, the larger."""
        return self.task.miss(self.pose_and_jacobian(q)[0], target)

    def moved(self, q: Array, step: Array) -> Array:
        """q moved along a step (..., nv)."""
        return q + step if self.model.nq == self.model.nv else integrate(self.model, q, step)

    def solve(
        self,
        target: Array,
        starts: Array,
        *,
        within: bool = False,
        weight: float = 1.0,
        iterations: int = 60,
    ) -> tuple[Array, Array]:
        """(q, scaled residual) from starts (N, nq) to targets (N, …); `within` keeps to the limits;
        the orientation counts `weight` times."""
        goal = 1e-3 * EXACT if weight == 1.0 else 0.0
        by_kernel = self.descent
        if by_kernel is not None:
            scales, limits = (1.0 / self.length, weight), self.bounds if within else None
            return descend_by_kernel(
                by_kernel, starts, target, scales, limits, goal=goal, iterations=iterations
            )
        k = len(self.task.linear)
        scale = np.append(self.scale[:k], weight * self.scale[k:])

        def residual(q: Array, rows: np.ndarray) -> tuple[Array, Array]:
            T, J = self.pose_and_jacobian(q)
            return scale * self.task.error(T, target[rows]), scale[:, None] * J

        def move(q: Array, step: Array) -> Array:
            moved = self.moved(q, step)
            return np.clip(moved, *self.bounds) if within else moved

        return descend(residual, starts, move, goal=goal, iterations=iterations)

    def polished(self, q: Array, target: Array) -> tuple[Array, Array]:
        """(q, miss) after Newton steps, each kept where it helped; q (N, nq), target (N, …)."""
        error, J = self._error_and_jacobian(q, target)
        miss = self.task.size(error)
        for _ in range(3):
            step = np.asarray(np.linalg.pinv(J, rcond=1e-7) @ error[..., None], dtype=float)
            trial = self.moved(q, step[..., 0])
            errors, slopes = self._error_and_jacobian(trial, target)
            after = self.task.size(errors)
            better = after < miss
            if not better.any():
                break
            q, miss = np.where(better[:, None], trial, q), np.where(better, after, miss)
            error = np.where(better[:, None], errors, error)
            J = np.where(better[:, None, None], slopes, J)
        return q, miss

    def _error_and_jacobian(self, q: Array, target: Array) -> tuple[Array, Array]:
        T, J = self.pose_and_jacobian(q)
        return self.task.error(T, target), J

    def settled(self, q: Array, target: Array, towards: Array, within: bool) -> Array:
        """q (N, nq) slid along the solutions of a redundant arm as near to `towards` (nq,) as can
        be."""
        slid = q
        for _ in range(40):
            T, J = self.pose_and_jacobian(slid)
            inverse = np.linalg.pinv(J, rcond=1e-6)
            wish = towards - slid
            own = inverse @ (self.task.error(T, target)[..., None] - J @ wish[..., None])
            slid = slid + 0.5 * (wish + own[..., 0])
            if within:
                slid = np.clip(slid, *self.bounds)
        slid, miss = self.polished(slid, target)
        good = miss <= EXACT
        if within:
            low, high = self.bounds
            good &= ((slid >= low) & (slid <= high)).all(axis=-1)
        return np.where(good[:, None], slid, q)
