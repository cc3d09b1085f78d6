"""Descents towards poses by one kernel of the model's structure, all starts side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from freebody.algorithms.pose_descent import step_towards
from freebody.arrays import Array
from freebody.kernels import structural
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.structural import Bound, Over
from freebody.model.model import Model
from freebody.program import Argument, Program, trace
from freebody.targets import Kernel

_UNBOUNDED = 1e30
"""What stands for no limit inside a kernel, whose numbers are finite."""
_TOGETHER = 4
"""Steps after which those that have ended are put aside."""


def descent_kernel(
    model: Model, frame: str, rows: Sequence[int], columns: Sequence[int]
) -> Bound | None:
    """(q, damping, target, scales, low, high) -> (q, damping, left, longest) of `step_towards`,
    with the model's numbers; compiled when it is first asked for.

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
            tree = over(numbers)

            def pose(q: Any) -> Any:
                (T,) = FORMULAS["forward_kinematics"].evaluate(tree, option, q=q)
                return _parts(T, d)

            def jacobian(q: Any) -> Any:
                (J,) = FORMULAS["jacobian"].evaluate(tree, option, q=q)
                return J

            goal = _parts(target, d)
            return step_towards(
                pose, jacobian, rows, columns, q, damping, goal, scales, (low, high)
            )

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
    rest: float = 1e-14,
) -> tuple[Array, Array]:
    """(q, what is left) of starts q (N, nq) to targets (N, …), as `descend` does.

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
        active = active[(cost > goal) & (longest > rest) & (held < 1e12)]
    return q, left
