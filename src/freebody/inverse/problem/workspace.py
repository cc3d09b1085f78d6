"""Distances of unreachable targets, many side by side: by kernels where a closed form's geometry
gives them, else by descents from many starts; and a sentence for each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import line
from freebody.algorithms.closed_form_inverse.out_of_reach import closer
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.inverse.problem.closed_form import ClosedFormArm
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.problem import InverseProblem
from freebody.inverse.problem.solutions import turning_coordinates
from freebody.inverse.problem.task import Task
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program
from freebody.trees.states import random_state

_STARTS = 48
_KEPT = 12
"""How many starts, the nearest when each has gone most of its way, are followed to the end."""
_AT_ONCE = 256
"""Targets looked at side by side, which bounds the memory."""
_SIDE_BY_SIDE = 2048
"""Targets side by side, which bounds the memory."""
_SAMPLES = 4096
_NEAREST, _ANYWHERE = 8, 16
"""How many samples near each target descents start from, and how many for all targets."""
_STEPS, _LAST_STEPS, _BEST = 20, 60, 2
"""Steps of every descent; steps of the best few, to the end; how many these are."""
_GRID = 96
_VALLEYS = 4
"""How many of the least values on the grid are followed."""
_CLOSER = np.linspace(-1.0, 1.0, 9)
_ROUNDS = 14
"""How often they are looked at closer, each time four times."""
_NEAR = 1e-7  # nearer than this (in arm lengths) is reached
Away = tuple[Array, Callable[[int], str]]
"""Distances (N,) of targets from what can be reached, and a sentence for each."""


def distances(problem: InverseProblem, form: ClosedFormArm | None) -> Away:
    """The distances (N,) of a problem's targets, all without a solution, from what the frame
    reaches, and a sentence for each; 0 where only the orientation is out of reach."""
    solver, count = problem.solver, len(problem.target)
    if not solver.task.linear:
        return np.zeros(count), lambda _: "The frame cannot reach this orientation."
    away = exact_distances(problem, form)
    how = "" if away is not None else "about "
    if away is None:
        parts = range(0, count, _AT_ONCE)
        away = np.concatenate([_searched(solver, problem.target[k : k + _AT_ONCE]) for k in parts])
    out = away > _NEAR * solver.length
    given = None if form is None or problem.held is None else form.held
    also = "" if given is None else f" and {solver.model.position_names[given]!r} where it is given"

    def sentence(k: int) -> str:
        return _sentence(solver, away[k], out[k], how, also)

    return np.where(out, away, 0.0), sentence


def _searched(solver: NumericalSolver, target: Array) -> Array:
    """Distances (N,) found by many descents; of the position alone where the orientation cannot be
    reached."""
    away, turned = _nearest(solver, target)
    if solver.task.angular and (turned > 1e-6).any():
        places = replace(solver, task=Task(solver.task.dim, solver.task.linear))
        away = np.where(turned > 1e-6, _nearest(places, target)[0], away)
    return away


def _sentence(solver: NumericalSolver, distance: float, out: bool, how: str, also: str) -> str:
    frame = f"frame {solver.frame!r} of {solver.model.name!r}"
    unseen = beyond_the_starts(solver)
    if unseen:
        return f"No solution was found for {frame}, at best {distance:.6g} m from it. {unseen}"
    if out:
        oriented = f" with this orientation{also}" if solver.task.angular else ""
        return (
            f"Out of reach: the target is {how}{distance:.6g} m from the nearest point that "
            f"{frame} can reach{oriented}."
        )
    if solver.task.angular:
        return (
            f"The position is within reach of {frame}, but not with this orientation{also}; "
            'task="position" leaves the orientation free.'
        )
    return f"No solution was found for {frame}, though the target lies at the edge of its reach."


def beyond_the_starts(solver: NumericalSolver) -> str:
    """A sentence for arms with unlimited angles whose turns are not equivalent, such as those of
    screws, since solutions beyond one turn are not searched; "" for others."""
    model, again = solver.model, turning_coordinates(solver.model)
    limited = np.logical_and(*map(np.isfinite, solver.bounds))
    names = [
        model.position_names[k]
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None and body.kind.nq == body.kind.nv
        for k, angular in zip(at.q, body.kind.angular, strict=True)
        if angular and not again[k] and not limited[k]
    ]
    if not names:
        return ""
    return (
        f"Starts lie within ±π of {', '.join(names)}, where each turn leads elsewhere: set limits, "
        "or give q0= near a solution."
    )


def _nearest_rows(cost: Array) -> np.ndarray:
    """The indices of the lowest costs of each target, from the costs of all starts target by
    target."""
    by_target = cost.reshape(-1, _STARTS)
    best = np.argpartition(by_target, _KEPT, axis=-1)[:, :_KEPT]
    return (best + _STARTS * np.arange(len(by_target))[:, None]).ravel()


def _nearest(solver: NumericalSolver, target: Array) -> tuple[Array, Array]:
    """(distance, angle) (N,) remaining after the best of many descents in which an angle counts a
    thousandfold."""
    q, _, _ = random_state(solver.model, 1, _STARTS)
    starts, goals = np.tile(q, (len(target), 1)), np.repeat(target, _STARTS, axis=0)
    q, cost = solver.solve(goals, starts, weight=30.0, iterations=30)
    rows, goals = _nearest_rows(cost), np.repeat(target, _KEPT, axis=0)
    q, _ = solver.solve(goals, q[rows], weight=30.0, iterations=60)
    q, cost = solver.solve(goals, q, weight=1000.0, iterations=100)
    best = np.argmin(cost.reshape(len(target), _KEPT), axis=-1)
    q = q.reshape(len(target), _KEPT, -1)[np.arange(len(target)), best]
    error = solver.task.error(solver.pose_and_jacobian(q)[0], target)
    k = len(solver.task.linear)
    return np.linalg.norm(error[:, :k], axis=-1), np.linalg.norm(error[:, k:], axis=-1)


def exact_distances(problem: InverseProblem, form: ClosedFormArm | None) -> Array | None:
    """Distances (N,) of targets from the nearest pose of the same orientation, where the geometry
    of a closed form gives them: by screws that bring a point to another one, or by a search over
    one joint; else None."""
    if form is None:
        return None
    at = range(0, len(problem.target), _SIDE_BY_SIDE)
    parts = [problem.part(np.arange(k, min(k + _SIDE_BY_SIDE, len(problem.target)))) for k in at]
    found = [x for part in parts if (x := _some_distances(part, form)) is not None]
    return np.concatenate(found) if len(found) == len(parts) > 0 else None


def _some_distances(problem: InverseProblem, form: ClosedFormArm) -> Array | None:
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
    """Newton descents that bring a point, from many starts, as near as possible to given points."""

    def __init__(
        self, problem: InverseProblem, form: ClosedFormArm, screws: Sequence[Screw], c: Array
    ):
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
        """Random joint positions (angles, and shifts of up to twice the arm's length), and a KD
        tree of the points to which they bring the moved point."""
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
        best = np.argpartition(square, _BEST, axis=-1)[:, :_BEST]
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
def _gap_kernel(problem: InverseProblem, form: ClosedFormArm) -> Kernel | None:
    """The kernel (target, x) -> squares of distances (branches,) with the deciding joint at x; None
    for a form that has none."""
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


def _target(problem: InverseProblem) -> str | None:
    """The name of the NumPy target for single problems, for which compiling would take longer than
    computing; else None."""
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
    """The least distance squared (N,) over all positions of the deciding joint."""
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
