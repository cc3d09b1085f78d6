"""Descents towards targets from many starts side by side, for arms without a closed form and to
polish closed-form solutions: Levenberg-Marquardt on matrices, or by one kernel.

Source: Levenberg 1944; Marquardt 1963.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.algorithms.loop_scales import rates_of_lengths
from freebody.algorithms.pose_descent import step_towards
from freebody.algorithms.screws import arm_length
from freebody.arrays import Array
from freebody.inverse.problem.task import Task
from freebody.kernels import structural
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.structural import Bound, Over
from freebody.lazy import cached_property
from freebody.loops.closure_checks import scaled_jacobian, scaled_residual
from freebody.loops.scaled_equations import length as mechanism_length
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries, shafts
from freebody.model.tree import Tree
from freebody.model.usable_limits import usable_limits
from freebody.program import Argument, Program, trace
from freebody.targets import Kernel
from freebody.trees.positions import generic_state, integrate

EXACT = 1e-10
"""A solution reproduces its target this well (m and rad)."""
_UNBOUNDED = 1e30
"""Stands for no limit inside a kernel, whose numbers are finite."""
_REST = 1e-14
"""Steps that are too small to count."""
_TOGETHER = 4
"""Steps after which those that have ended are put aside."""


@dataclass(frozen=True, eq=False)
class NumericalSolver:
    """A numerical solver for positions of a model's frame that fulfil a task, from many starts.
    Shafts of flexible joints stand as they do at the start."""

    model: Model
    frame: str
    task: Task
    still: int | None = None
    """The place in q of a joint that is not moved."""

    @cached_property
    def length(self) -> float:
        """The length of the arm, or of a closed chain's mechanism (m), by which lengths and radians
        are compared."""
        if self.model.loops:
            return mechanism_length(self.model)
        return arm_length(self.model.tree, self.frame)

    @cached_property
    def rates(self) -> Array:
        """Scales (nv,) of rates: the length for rates in m/s, 1 for angular ones."""
        return np.where(rates_of_lengths(self.model.tree), self.length, 1.0)

    @cached_property
    def scale(self) -> Array:
        """Factors (r,) that turn the task's rows into angles."""
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
        tree, gone = self.model.tree, shafts(self.model)
        mask = np.zeros(self.model.nq, dtype=bool)
        for i in ancestors(tree, tree.frames[self.frame][0]):
            mask[list(tree.bodies[i].coordinates.q)] = i not in gone
        return mask

    @cached_property
    def freedom(self) -> int:
        """How many of the coordinates that move the frame are left over by the task, at most
        poses."""
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
        """The kernel of one step of `solve`; None where there is none."""
        return descent_kernel(self.model, self.frame, self.task.rows, self.columns)

    @property
    def columns(self) -> list[int]:
        """The indices in q of the coordinates that the solver moves."""
        return [k for k in np.flatnonzero(self.moving).tolist() if k != self.still]

    def pose_and_jacobian(self, q: Array) -> tuple[Array, Array]:
        """T (..., dim + 1, dim + 1) and the counted rows of J (..., r, nv) at q (..., nq)."""
        T, J = self._kernel(q)
        J = J[..., list(self.task.rows), :]
        if self._still:
            J[..., self._still] = 0.0
        return T, J

    @cached_property
    def _still(self) -> list[int]:
        """The entries of q̇ that are not moved."""
        where = self.model.coordinates
        held = [] if self.still is None else [next(x for x in where if self.still in x.q)]
        return [k for at in held for k in at.v] + list(shaft_entries(self.model))

    def equations(self, q: Array, target: Array, weight: float = 1.0) -> tuple[Array, Array]:
        """(residuals (..., r + m), their slopes (..., r + m, nv) over `rates`) of the task and of a
        closed chain's loops, as angles; loops count `weight` times."""
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
        """The distance of q (..., nq) from the targets by forward kinematics: the larger of m and
        rad."""
        return self.task.miss(self.pose_and_jacobian(q)[0], target)

    def moved(self, q: Array, step: Array) -> Array:
        """The positions q moved along a step (..., nv)."""
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
        """(q, miss) after Newton steps, each kept only where it helped; q (N, nq), target (N,
        …)."""
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
        """Positions q (N, nq) of a redundant arm, moved along its solutions as near to `towards`
        (nq,) as possible."""
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


_Residual = Callable[[Array, np.ndarray], tuple[Array, Array]]
"""(x (k, n), rows (k,)) -> (e (k, m), E (k, m, nv)): residuals of problems, and what a step takes
off them."""
_Move = Callable[[Array, Array], Array]
"""Function (x, step) -> the moved x."""


def descend(
    residual: _Residual,
    x: Array,
    move: _Move = np.add,
    *,
    goal: float = 0.0,
    iterations: int = 60,
) -> tuple[Array, Array]:
    """(x, |e|) after a least-squares descent of the residual e from each start x (N, n).

    A problem stops where |e| ≤ goal or where its steps are too small to count. Each has a damping
    of its own, a fifth of the last after a step that helped, four times after one that did not.
    """
    x = x.copy()
    everyone = np.arange(len(x))
    e, E = residual(x, everyone)
    cost, damping = np.linalg.norm(e, axis=-1), np.full(len(x), 1e-2)
    active = everyone[cost > goal]
    for _ in range(iterations):
        if not len(active):
            break
        step = _step(e[active], E[active], damping[active])
        trial = move(x[active], step)
        e_trial, E_trial = residual(trial, active)
        cost_trial = np.linalg.norm(e_trial, axis=-1)
        better = cost_trial < cost[active]
        kept = active[better]
        x[kept] = trial[better]
        e[kept] = e_trial[better]
        E[kept] = E_trial[better]
        cost[kept] = cost_trial[better]
        damping[kept] = np.maximum(damping[kept] * 0.2, 1e-14)
        damping[active[~better]] *= 4.0
        moving = np.abs(step).max(axis=-1) > _REST
        active = active[moving & (cost[active] > goal) & (damping[active] < 1e12)]
    return x, cost


def _step(e: Array, E: Array, damping: Array) -> Array:
    transposed = np.swapaxes(E, -1, -2)
    n = E.shape[-1]
    normal = transposed @ E
    normal[:, range(n), range(n)] += damping[:, None]
    return np.linalg.solve(normal, transposed @ e[..., None])[..., 0].astype(float, copy=False)


def descent_kernel(
    model: Model, frame: str, rows: Sequence[int], columns: Sequence[int]
) -> Bound | None:
    """The kernel (q, damping, target, scales, low, high) -> (q, damping, left, longest) of
    `step_towards`, with the model's numbers; compiled on first use.

    None where coordinates do not add up, as those of quaternions, where nothing is to be moved, and
    where no machine code is made: NumPy, node by node, is slower than by matrices.
    """
    names = ("forward_kinematics", "jacobian")
    option = Option(frame)
    both = structural.fetch(model, names, option).kernel
    if model.nq != model.nv or not columns or not rows:
        return None
    if not isinstance(both, Kernel) or both.target != "cpu":
        return None
    d, n = model.dim, model.nq

    def made(p: Argument, over: Over) -> Program:
        def evaluate(*scalars: Any) -> tuple[Any, ...]:
            q, damping, target, scales, low, high, numbers = scalars
            step = DescentStep(over(numbers), frame, tuple(rows), tuple(columns))
            return step(q, damping, target, scales, (low, high))

        inputs = (
            Argument("q", (n,)),
            Argument("damping", ()),
            Argument("target", (d + 1, d + 1)),
            Argument("scales", (2,), uniform=True),
            Argument("low", (n,), uniform=True),
            Argument("high", (n,), uniform=True),
        )
        outputs = [Argument("q1", (n,)), *(Argument(x, ()) for x in ("damped", "left", "longest"))]
        return trace("descent", evaluate, (*inputs, p), outputs)

    key = ("descent", " ".join(map(str, rows)), " ".join(map(str, columns)))
    return structural.fetch_own(model, key, option, made)


@dataclass(frozen=True)
class DescentStep:
    """A step of `step_towards` over scalars, of a frame of a tree towards a target (dim + 1, dim +
    1) in the counted rows."""

    tree: Tree
    frame: str
    rows: tuple[int, ...]
    columns: tuple[int, ...]

    def __call__(
        self, q: Any, damping: Any, target: Any, scales: Any, limits: tuple[Any, Any]
    ) -> tuple[Any, ...]:
        """(q, damping, remaining error, longest entry of the step)."""
        d, option = self.tree.space.dim, Option(self.frame)

        def pose(q: Any) -> Any:
            (T,) = FORMULAS["forward_kinematics"].evaluate(self.tree, option, q=q)
            return _parts(T, d)

        def jacobian(q: Any) -> Any:
            (J,) = FORMULAS["jacobian"].evaluate(self.tree, option, q=q)
            return J

        goal = _parts(target, d)
        return step_towards(
            pose, jacobian, self.rows, self.columns, q, damping, goal, scales, limits
        )


def _parts(T: Any, d: int) -> tuple[Any, Any]:
    return tuple(row[:d] for row in T[:d]), tuple(row[d] for row in T[:d])


def descend_by_kernel(
    bound: Bound,
    q: Array,
    target: Array,
    scales: tuple[float, float],
    limits: tuple[Array, Array] | None,
    *,
    numbers: Array | None = None,
    goal: float = 0.0,
    iterations: int = 60,
) -> tuple[Array, Array]:
    """(q, remaining error) of descents by a kernel from starts q (N, nq) to targets (N, …), as
    `descend` does.

    limits: (low, high) that are kept to. numbers: (N, …), of the robot that each start is of.
    """
    n = q.shape[-1]
    low, high = limits or (np.full(n, -np.inf), np.full(n, np.inf))
    low, high = np.maximum(low, -_UNBOUNDED), np.minimum(high, _UNBOUNDED)
    fixed = np.array(scales), low, high
    q, left = q.copy(), np.full(len(q), np.inf)
    active, damping = np.arange(len(q)), np.full(len(q), 1e-2)
    for start in range(0, iterations, _TOGETHER):
        if not len(active):
            break
        x, held, goals = q[active], damping[active], target[active]
        own = bound.numbers if numbers is None else (numbers[active],)
        for _ in range(min(_TOGETHER, iterations - start)):
            x, held, cost, longest = bound.kernel(x, held, goals, *fixed, *own)
        q[active], damping[active], left[active] = x, held, cost
        active = active[(cost > goal) & (longest > _REST) & (held < 1e12)]
    return q, left
