"""Arms that are nearly one with a closed form, such as calibrated ones, and families of them: every
branch of that one, followed to the arm itself by steps side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.closed_form_inverse.choose_recipe import NEARLY, nearby, recipe_for
from freebody.algorithms.closed_form_inverse.solve import Branches
from freebody.algorithms.screws import chain_to
from freebody.arrays import Array
from freebody.inverse.by_closed_form import candidates
from freebody.inverse.closed_form import ClosedFormArm, closed_form_for
from freebody.inverse.descent_kernel import descend_by_kernel
from freebody.inverse.levenberg_marquardt import descend
from freebody.inverse.many_starts import by_search
from freebody.inverse.numerical_solver import EXACT, NumericalSolver
from freebody.inverse.problem import Found, Problem
from freebody.inverse.solutions import APART, wrapped
from freebody.inverse.task import Task
from freebody.kernels.structural import Bound
from freebody.model.model import Model
from freebody.trees.states import random_state

_UNCLEAR = 4.0
"""How much more (relative) than the arms differ a branch must clear its bounds, to be one of both
or of neither."""
_MISSED = 1e-4
"""What leads no nearer (m and rad) than this leads to no solution."""

Poses = Callable[[Array, np.ndarray], tuple[Array, Array]]
"""(q (M, nq), which targets (M,)) -> pose and Jacobian of the arm that each is of."""


@dataclass(frozen=True, eq=False)
class Follow:
    """The arms that branches are followed to, each target's its own."""

    poses: Poses
    kernel: Bound | None
    """Of a step; None where steps are made with the poses."""
    numbers: Array | None = None
    """(N, …), which the kernel takes for each target; None where all are of one arm."""

    def descended(
        self, solver: NumericalSolver, q: Array, target: Array, rows: np.ndarray
    ) -> Array:
        """Where starts q (M, nq) come to, each of the target of a row."""
        task, k = solver.task, len(solver.task.linear)
        goal, iterations = 1e-3 * EXACT, 100
        if self.kernel is not None:
            numbers = None if self.numbers is None else self.numbers[rows]
            scales = 1.0 / solver.length, 1.0
            return descend_by_kernel(
                self.kernel, q, target, scales, None,
                numbers=numbers, goal=goal, iterations=iterations,
            )[0]  # fmt: skip
        scale = np.array([1.0 / solver.length] * k + [1.0] * (len(task.rows) - k))

        def residual(q: Array, some: np.ndarray) -> tuple[Array, Array]:
            T, J = self.poses(q, rows[some])
            return scale * task.error(T, target[some]), scale[:, None] * J

        return descend(residual, q, solver.moved, goal=goal, iterations=iterations)[0]


@dataclass(frozen=True, eq=False)
class NearbyForm:
    """The closed form of an arm, and how far (rad, arm lengths) the one that is asked for differs
    from it."""

    form: ClosedFormArm
    differs: float

    @property
    def method(self) -> str:
        """What is done."""
        return f"{self.form.method}, of the arm nearby, and Levenberg–Marquardt from there"


def nearby_form(model: Model, frame: str, task: Task) -> NearbyForm | None:
    """The closed form of the arm that this one nearly is, for a whole pose; None without one, or
    where a joint would have to be given."""
    chain = chain_to(model.tree, frame)
    if chain is None or model.dim == 2 or not (task.places and task.turns):
        return None
    chain = nearby(chain)
    recipe = recipe_for(chain, "pose", False)
    if recipe is None:
        return None
    form = ClosedFormArm(Branches(chain, "pose", recipe, 3), task, ("up", "down"))
    if form.held is not None:
        return None
    q, _, _ = random_state(model, 2, 16)
    solver = NumericalSolver(model, frame, task)
    differs = difference(form, solver, *((q, solver.pose_and_jacobian(q)[0])))
    return NearbyForm(form, differs) if differs < NEARLY else None


def difference(form: ClosedFormArm, solver: NumericalSolver, q: Array, T: Array) -> float:
    """How far (rad, arm lengths) poses T (…) at q (…) are from those of the form's arm."""
    chain = form.chain
    x = chain.positions(q)
    points = [np.broadcast_to(v, (*x.shape[:-1], 3)) for v in (chain.p, *chain.R.T)]
    for k, s in reversed(list(enumerate(chain.screws))):
        points = [s.moved(x[..., k], points[0]), *(s.turned(x[..., k], v) for v in points[1:])]
    there = np.zeros((*x.shape[:-1], 4, 4))
    there[..., :3, 3], there[..., :3, :3] = points[0], np.stack(points[1:], axis=-1)
    error = Task(3, tuple(range(6))).error(there, T)
    error[..., :3] /= solver.length
    return float(np.abs(error).max(initial=0.0))


def by_nearby(problem: Problem, known: NearbyForm) -> Found:
    """What the branches lead to, and for targets for which this is not sure many starts too."""
    solver = problem.solver
    follow = Follow(lambda q, _: solver.pose_and_jacobian(q), solver.descent)
    found, sure = followed(problem, known, follow)
    rows = np.flatnonzero(~sure)
    if not len(rows):
        return found
    searched = by_search(problem.part(rows), found.q[rows])
    return searched if len(rows) == len(sure) else found.with_rows(rows, searched)


def followed(problem: Problem, known: NearbyForm, follow: Follow) -> tuple[Found, np.ndarray]:
    """The solutions (N, branches) that the branches of the arm nearby lead to, and whether this is
    sure (N,): each of them led to one of its own, or is none there either."""
    solver, form = problem.solver, known.form
    chain, nq = form.chain, solver.model.nq
    x, _, clear = candidates(form, chain.positions(problem.reference), problem)
    starts = chain.coordinates(x, problem.rest)
    bound = _UNCLEAR * known.differs
    with np.errstate(invalid="ignore"):
        tried = np.logical_and(clear > -bound, np.isfinite(x).all(axis=-1))
        lost = np.less_equal(clear, 0.0)
    rows = np.nonzero(tried)[0]
    q = np.full((*tried.shape, nq), np.nan)
    miss, left = np.full(tried.shape, np.nan), np.full(tried.shape, np.inf)
    if len(rows):
        target = problem.target[rows]
        at = follow.descended(solver, starts[tried], target, rows)
        at = wrapped(solver, at, problem.reference)
        left[tried] = solver.task.miss(follow.poses(at, rows)[0], target)
        good = left[tried] <= EXACT
        q[tried], miss[tried] = np.where(good[:, None], at, np.nan), left[tried]
    there = left <= EXACT
    # what leads to no solution has none where the branch is none of the arm nearby either
    settled = there | ~tried | (lost & (left > _MISSED))
    sure = np.logical_and(settled.all(axis=-1), ~_merged(q).any(axis=-1))
    q[~there], miss[~there] = np.nan, np.nan
    notes = [
        "The arm is nearly one with a closed form: what its branches lead to, perhaps not all."
    ]
    return Found(q, miss, form.names, known.method, notes), sure


def _merged(q: Array) -> np.ndarray:
    """Which solutions (N, k) are another one before them."""
    way = q[:, :, None] - q[:, None]
    with np.errstate(invalid="ignore"):
        near = np.abs(way).max(axis=-1) < APART
    return np.tril(near, -1).any(axis=-1)


def form_near(model: Model, frame: str, task: Task) -> NearbyForm | None:
    """The closed form of a model itself, else of the arm that it nearly is."""
    own = closed_form_for(model, frame, task)
    if own is not None and own.held is None and task.places and task.turns and model.dim == 3:
        return NearbyForm(own, 0.0)
    return nearby_form(model, frame, task)


def farther(known: NearbyForm, differs: float) -> NearbyForm:
    """The same for arms that differ so much from it."""
    return replace(known, differs=max(known.differs, differs))
