"""Solutions for arms that nearly have a closed form, such as calibrated ones, and for members of
families: the branches of the nearby arm, followed numerically side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.closed_form_inverse.choose_recipe import NEARLY, nearby, recipe_for
from freebody.algorithms.closed_form_inverse.solve import Branches
from freebody.algorithms.screws import chain_to
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.closed_form_arm import ClosedFormArm, closed_form_for
from freebody.inverse.problem.numerical_solver import (
    EXACT,
    NumericalSolver,
    descend,
    descend_by_kernel,
    descent_kernel,
)
from freebody.inverse.problem.problem import Found, InverseProblem
from freebody.inverse.problem.solution_arrays import gathered
from freebody.inverse.problem.solutions import APART, Solutions, wrapped
from freebody.inverse.problem.task import Task
from freebody.inverse.ways.by_closed_form import candidates
from freebody.inverse.ways.many_starts import by_search
from freebody.kernels import structural
from freebody.kernels.formulas import Option
from freebody.kernels.structural import Bound
from freebody.model.families import Members
from freebody.model.model import Model
from freebody.trees.positions import random_state

_UNCLEAR = 4.0
"""How much more (relative) than the arms differ a branch must clear its bounds, to be one of both
or of neither."""
_MISSED = 1e-4
"""A start that leads no nearer (m and rad) than this leads to no solution."""
_MOST = 0.05
"""How far (rad, arm lengths) members may be from the first to be followed from there."""
PoseFunction = Callable[[Array, np.ndarray], tuple[Array, Array]]
"""(q (M, nq), which targets (M,)) -> pose and Jacobian of the arm that each is of."""
_OneMember = Callable[[InverseProblem], Solutions]
"""Solver of a problem of one member."""
_SolvedPiece = tuple[np.ndarray, Solutions]
"""Rows of the batch, with what was found for their targets."""


@dataclass(frozen=True, eq=False)
class Follow:
    """The arms to which the branches of a nearby arm are followed, one for each target."""

    poses: PoseFunction
    kernel: Bound | None
    """The kernel of a step; None where steps are made with the poses."""
    numbers: Array | None = None
    """(N, …), which the kernel takes for each target; None where all are of one arm."""

    def descended(
        self, solver: NumericalSolver, q: Array, target: Array, rows: np.ndarray
    ) -> Array:
        """The positions to which the numerical solver leads from starts q (M, nq); `rows` tells the
        target of each start."""
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
    """The closed form of a nearby arm, and how far (rad, arm lengths) the wanted arm differs from
    it."""

    form: ClosedFormArm
    differs: float

    @property
    def method(self) -> str:
        """The name of the method in results."""
        return f"{self.form.method}, of the arm nearby, and Levenberg–Marquardt from there"


def nearby_form(model: Model, frame: str, task: Task) -> NearbyForm | None:
    """The closed form of the arm that this one nearly is, for a whole pose; None where there is
    none, or where a joint would have to be held."""
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


def form_near(model: Model, frame: str, task: Task) -> NearbyForm | None:
    """The closed form of a model itself, else of the arm that it nearly is."""
    own = closed_form_for(model, frame, task)
    if own is not None and own.held is None and task.places and task.turns and model.dim == 3:
        return NearbyForm(own, 0.0)
    return nearby_form(model, frame, task)


def farther(known: NearbyForm, differs: float) -> NearbyForm:
    """The nearby closed form with its difference raised to at least `differs` (rad, arm
    lengths)."""
    return replace(known, differs=max(known.differs, differs))


def difference(form: ClosedFormArm, solver: NumericalSolver, q: Array, T: Array) -> float:
    """The largest difference (rad, arm lengths) between given poses T (…) at q (…) and those of the
    closed form's arm."""
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


def by_nearby(problem: InverseProblem, known: NearbyForm) -> Found:
    """Solutions followed from the branches of the nearby arm, and from many starts as well for
    targets where these are not sure."""
    solver = problem.solver
    follow = Follow(lambda q, _: solver.pose_and_jacobian(q), solver.descent)
    found, sure = followed(problem, known, follow)
    rows = np.flatnonzero(~sure)
    if not len(rows):
        return found
    searched = by_search(problem.part(rows), found.q[rows])
    return searched if len(rows) == len(sure) else found.with_rows(rows, searched)


def of_family(
    model: Model, given: InverseProblem, batch: tuple[int, ...], one: _OneMember
) -> Solutions:
    """Solutions of inverse kinematics for all members of a family; given: the problem for the first
    member, whose targets have a batch that broadcasts with the family."""
    try:
        whole = np.broadcast_shapes(batch, model.family)
    except ValueError:
        raise FreebodyError(
            f"inverse_kinematics: the batch shapes do not broadcast together: target {batch}, "
            f"model.family {model.family}."
        ) from None
    core = given.target.shape[-2:]
    target = np.broadcast_to(given.target.reshape(*batch, *core), (*whole, *core))
    problem = replace(given, target=target.reshape(-1, *core))
    count = int(np.prod(model.family))
    member = np.broadcast_to(np.arange(count).reshape(model.family), whole).reshape(-1)
    pieces, rows = _side_by_side(model, problem, member)
    notes = [note for _, s in pieces for note in s.notes]
    for k in np.unique(member[rows]):
        own = rows[member[rows] == k]
        index = tuple(map(int, np.unravel_index(k, model.family)))
        solver = replace(problem.solver, model=model[index])
        pieces.append((own, one(replace(problem.part(own), solver=solver, alone=True))))
    lost = sum(int((s.count == 0).sum()) for _, s in pieces)
    if lost:
        notes.append(f"{lost} of {len(member)} have no solution, see distance.")
    return _joined(pieces, whole, model.nq, tuple(notes))


def _side_by_side(
    model: Model, problem: InverseProblem, member: np.ndarray
) -> tuple[list[_SolvedPiece], np.ndarray]:
    """Solutions that are sure for all members at once, in pieces, and the rows of targets that
    remain unsolved."""
    every = np.arange(len(problem.target))
    solver, task = problem.solver, problem.solver.task
    limits = [body.joint.limits for body in model.bodies]
    differ = any(isinstance(x, Members) for one in limits for x in (one.lower, one.upper))
    if model.loops or problem.searched or differ:
        return [], every
    known = form_near(solver.model, solver.frame, task)
    if known is None or not len(every):
        return [], every
    names = ("forward_kinematics", "jacobian")
    bound = structural.fetch(model, names, Option(solver.frame))
    numbers = bound.numbers[0].reshape(-1, bound.numbers[0].shape[-1])

    def poses(q: Array, rows: np.ndarray) -> tuple[Array, Array]:
        T, J = bound.kernel(q, numbers[member[rows]])
        return T, J[..., list(task.rows), :]

    q, _, _ = random_state(solver.model, 2, 16)
    T, _ = bound.kernel(q[:, None], numbers)
    apart = np.array([difference(known.form, solver, q, T[:, k]) for k in range(len(numbers))])
    near = np.flatnonzero(apart < _MOST)
    some = np.flatnonzero(np.isin(member, near))
    if not len(some):
        return [], every
    known = farther(known, float(apart[near].max()))
    step = descent_kernel(model, solver.frame, task.rows, solver.columns)
    own = None if step is None else step.numbers[0].reshape(len(numbers), -1)[member[some]]
    follow = Follow(lambda q, rows: poses(q, some[rows]), step, own)
    found, sure = followed(problem.part(some), known, follow)
    good = np.flatnonzero(sure & np.isfinite(found.miss).any(axis=-1))
    if not len(good):
        return [], every
    part = replace(
        found, q=found.q[good], miss=found.miss[good], notes=[*found.notes, _how_far(known)]
    )
    solved = gathered(problem.part(some[good]), known.form, part, (len(good),))
    return [(some[good], solved)], np.setdiff1d(every, some[good])


def _how_far(known: NearbyForm) -> str:
    return (
        f"Members differ by up to {known.differs:.2g} (rad, arm lengths) from the arm whose "
        f"branches were followed."
    )


def _joined(
    pieces: list[_SolvedPiece], batch: tuple[int, ...], nq: int, notes: tuple[str, ...]
) -> Solutions:
    """The solutions of all pieces joined into one batch."""
    M = int(np.prod(batch))
    k = max((len(s) for _, s in pieces), default=0)
    q, residual = np.full((M, k, nq), np.nan), np.full((M, k), np.nan)
    within, names = np.zeros((M, k), dtype=bool), np.full((M, k), "", dtype=object)
    distance = np.zeros(M)
    for rows, s in pieces:
        for whole, part in (
            (q, s.q),
            (residual, s.residual),
            (within, s.within_limits),
            (names, s.branches),
        ):
            whole[rows, : len(s)] = part
        distance[rows] = s.distance
    return Solutions(
        q.reshape(*batch, k, nq),
        names.astype(str).reshape(*batch, k),
        residual.reshape(*batch, k),
        within.reshape(*batch, k),
        distance.reshape(batch),
        "; ".join(dict.fromkeys(s.method for _, s in pieces)) or "no targets",
        notes,
    )


def followed(
    problem: InverseProblem, known: NearbyForm, follow: Follow
) -> tuple[Found, np.ndarray]:
    """The solutions (N, branches) that the branches of the nearby arm lead to, and flags (N,) of
    the targets where these are sure: each branch led to a solution of its own, or has none on the
    nearby arm either."""
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
    """Flags of the solutions (N, k) that repeat another one before them."""
    way = q[:, :, None] - q[:, None]
    with np.errstate(invalid="ignore"):
        near = np.abs(way).max(axis=-1) < APART
    return np.tril(near, -1).any(axis=-1)
