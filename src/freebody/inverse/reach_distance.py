"""How far targets are out of reach, many side by side, by kernels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import line
from freebody.algorithms.closed_form_inverse.out_of_reach import closer
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.problem import Problem
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program

_AT_ONCE = 2048
"""Targets side by side, which bounds the memory."""
_SAMPLES = 4096
_NEAREST, _ANYWHERE = 8, 16
"""Of the samples, how many near each target descents start from, and how many for all."""
_STEPS, _LAST_STEPS, _KEPT = 20, 60, 2
"""Of every descent; of the best few, to the end."""
_GRID = 96
_VALLEYS = 4
"""Of the least values on the grid, how many are followed."""
_CLOSER = np.linspace(-1.0, 1.0, 9)
_ROUNDS = 14
"""How often they are looked at closer, each time four times."""


def exact_distances(problem: Problem, form: ClosedFormArm | None) -> Array | None:
    """Distances (N,) of a problem's targets from what can be had with their orientation, where the
    geometry of a closed form tells: by the screws that bring a point to another one, or over the
    one joint that decides; else None."""
    if form is None:
        return None
    at = range(0, len(problem.target), _AT_ONCE)
    parts = [problem.part(np.arange(k, min(k + _AT_ONCE, len(problem.target)))) for k in at]
    found = [x for part in parts if (x := _some_distances(part, form)) is not None]
    return np.concatenate(found) if len(found) == len(parts) > 0 else None


def _some_distances(problem: Problem, form: ClosedFormArm) -> Array | None:
    reached = form.reached(problem.target, problem.held)
    if reached is not None:
        screws, c, points = reached
        if not screws:
            return np.linalg.norm(points - c, axis=-1)
        return _Descents(problem, form, screws, c).distances(points)
    kernel = _gap_kernel(problem, form)
    return None if kernel is None else _over_one_joint(kernel, form.counted(problem.target))


# ---------------------------------------------------------------- by screws
class _Descents:
    """Newton's steps towards points from many starts."""

    def __init__(self, problem: Problem, form: ClosedFormArm, screws: Sequence[Screw], c: Array):
        self.length = problem.solver.length
        self.screws = [replace(s, p=s.p / self.length, rest=0.0) for s in screws]
        self.c = c / self.length
        compiled = problem.solver.model.compiled
        held = problem.held is not None
        key = ("closer", problem.solver.frame, form.branches.kind, held, problem.alone)
        if key not in compiled:
            compiled[key] = self._kernel(_target(problem)), self._sampled()
        self.kernel, (self.samples, self.tree) = compiled[key]

    def _kernel(self, target: str | None) -> Kernel:
        lines, c = [line(s) for s in self.screws], tuple(map(float, self.c))
        n = len(lines)

        def step(x: Any, damping: Any, goal: Any) -> Any:
            return closer(lines, c, x, damping, goal)

        inputs = [Argument("x", (n,)), Argument("damping", ()), Argument("goal", (3,))]
        outputs = [Argument("closer", (n,)), Argument("damped", ()), Argument("square", ())]
        return compile_program(trace("closer", step, inputs, outputs), target=target)

    def _sampled(self) -> tuple[Array, Any]:
        """Positions anywhere (angles, and shifts of up to twice the arm's length), and where they
        bring the point, as a tree."""
        from scipy.spatial import KDTree  # half of freebody's own time to import

        rng = np.random.default_rng(1)
        x = rng.uniform(-1.0, 1.0, size=(_SAMPLES, len(self.screws)))
        x *= np.where([s.turning for s in self.screws], np.pi, 2.0)
        points = np.broadcast_to(self.c, (_SAMPLES, 3))
        for k in reversed(range(len(self.screws))):
            points = self.screws[k].moved(x[:, k], points)
        return x, KDTree(points)

    def distances(self, points: Array) -> Array:
        """How far points (N, 3) are from what can be reached (N,)."""
        goals = points[:, None] / self.length
        _, near = self.tree.query(goals[:, 0], k=_NEAREST)
        shape = (len(points), _ANYWHERE, len(self.screws))
        anywhere = np.broadcast_to(self.samples[:_ANYWHERE], shape)
        x, damping, square = self._followed(
            np.concatenate([self.samples[near], anywhere], axis=1),
            np.full((len(points), _NEAREST + _ANYWHERE), 1e-3),
            goals,
            _STEPS,
        )
        best = np.argpartition(square, _KEPT, axis=-1)[:, :_KEPT]
        x = np.take_along_axis(x, best[..., None], axis=1)
        _, _, square = self._followed(
            x, np.take_along_axis(damping, best, axis=1), goals, _LAST_STEPS
        )
        return self.length * np.sqrt(square.min(axis=-1))

    def _followed(
        self, x: Array, damping: Array, goals: Array, steps: int
    ) -> tuple[Array, Array, Array]:
        square = np.zeros(damping.shape)
        for _ in range(steps):
            x, damping, square = self.kernel(x, damping, goals)
        return x, damping, square


# ---------------------------------------------------------------- over one joint
def _gap_kernel(problem: Problem, form: ClosedFormArm) -> Kernel | None:
    """(target, x) -> squares of distances (ways,); None for a form that has none."""
    arm, compiled = form.branches, problem.solver.model.compiled
    key = ("gaps", problem.solver.frame, arm.kind, problem.alone)
    if key not in compiled:
        home = arm.chain.R, arm.chain.p
        ways = arm.gaps(*(tuple(map(tuple, home[0])), tuple(home[1])), 0.0)
        if ways is None:
            compiled[key] = None
        else:
            compiled[key] = _gaps_compiled(form, len(ways), _target(problem))
    return compiled[key]


def _target(problem: Problem) -> str | None:
    """NumPy, where compiling would take longer than all else."""
    return "numpy" if problem.alone else None


def _gaps_compiled(form: ClosedFormArm, ways: int, target: str | None) -> Kernel:
    def gaps(target: Any, x: Any) -> Any:
        return (tuple(form.branches.gaps(*form.of_counted(target), x) or ()),)

    inputs = [Argument("target", form.counted(np.eye(form.branches.dim + 1)).shape)]
    return compile_program(
        trace("gaps", gaps, [*inputs, Argument("x", ())], [Argument("squares", (ways,))]),
        target=target,
    )


def _over_one_joint(kernel: Kernel, target: Array) -> Array:
    """The least over the joint's turn (N,)."""
    grid = np.linspace(-np.pi, np.pi, _GRID, endpoint=False)
    squares = kernel(target[:, None], grid)  # (N, G, ways)
    valley = (squares <= np.roll(squares, 1, axis=1)) & (squares <= np.roll(squares, -1, axis=1))
    flat = np.where(valley, squares, np.inf).reshape(len(target), -1)
    best = np.argpartition(flat, _VALLEYS, axis=-1)[:, :_VALLEYS]
    x, way = grid[best // squares.shape[-1]], best % squares.shape[-1]
    step, least = 2 * np.pi / _GRID, np.zeros(x.shape)
    for _ in range(_ROUNDS):
        tried = x[..., None] + step * _CLOSER  # (N, valleys, 9)
        there = np.take_along_axis(
            kernel(target[:, None, None], tried), way[..., None, None], axis=-1
        )[..., 0]
        nearest = np.argmin(there, axis=-1)[..., None]
        x = np.take_along_axis(tried, nearest, axis=-1)[..., 0]
        least = np.take_along_axis(there, nearest, axis=-1)[..., 0]
        step /= 4.0
    return np.sqrt(least.min(axis=-1))
