"""`inverse_kinematics`: joint positions that bring a frame to a target, with a fast path for arms
whose closed form is already compiled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, UnknownNameError
from freebody.inverse.problem.closed_form_arm import ClosedFormArm, closed_form_for
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.problem import Found, InverseProblem, LimitsChoice, nothing
from freebody.inverse.problem.solution_arrays import Numbered, gathered
from freebody.inverse.problem.solutions import Solutions
from freebody.inverse.problem.task import read_target
from freebody.inverse.ways.by_closed_form import (
    branch_kernel,
    by_closed_form,
    by_self_motion,
    notes,
)
from freebody.inverse.ways.closed_chains import of_closed_chain
from freebody.inverse.ways.from_nearby import by_nearby, nearby_form, of_family
from freebody.inverse.ways.many_starts import by_search
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.model.shafts import untwisted
from freebody.targets import Kernel
from freebody.trees.public_calls import JointVector, finite_vector

LIMITS = get_args(LimitsChoice)
_NONE = np.zeros(())
_QuickAnswer = Callable[[Any, Any, Any], Solutions | None]
"""(target, q0, redundancy) -> the solutions; None where something has to be looked at: the
arguments, or a target without solution or next to a singular one."""
_FEW = 16
"""Targets that are sooner counted in plain Python."""
_PART = 0.5
"""Share of the targets that are looked at closer by themselves, at most."""
_UNCLEAR = (KeyError, TypeError, ValueError, IndexError, AttributeError)
"""Errors of looking for an answer, or asking it, where an argument is not plain: whoever looks
closer says what is wrong with it."""


def inverse_kinematics(
    model: Model,
    target: ArrayLike,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    *,
    q0: JointVector | None = None,
    limits: LimitsChoice = "mark",
    redundancy: ArrayLike | None = None,
    starts: int | None = None,
    seed: int | None = None,
) -> Solutions:
    """All joint positions that bring a frame to a target where a closed form exists, else those
    found from many starts.

    Closed forms, whatever frames, base and tool: planar arms of up to three joints (2.14, 2.15, by
    atan2 and with both elbows), SCARA robots, three joints that place a point, three that orient,
    six with a spherical wrist (Pieper 1968) or with three parallel axes (Elias and Wen 2022), seven
    of which six are such an arm. Else Levenberg–Marquardt.

    Flexible joints are solved with their shafts untwisted, in the solutions and at q0.

    Of a closed chain these are the working modes, at which the loops are closed too: all of them,
    and named by the sides on which elbows lie, where a planar robot comes apart into dyads, else
    those found from many starts.

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one. Of a family branches of the first member, or of an arm
        that it nearly is, are followed to all members side by side; members for which that is not
        sure are solved one by one.
    target : (..., dim) or (..., dim + 1, dim + 1)
        Point (m), or pose, world axes.
    frame : str, optional
        Name, default the tip.
    task : str or names of rows, optional
        What counts of the target: "position" (a point's default), "orientation", "pose" (a pose's
        default), or rows among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w").
    q0 : (nq,), optional
        Where joints stay that could stand anywhere, next to which angles are wrapped, and near
        which a redundant arm is sought; rad and m.
    limits : "mark", "drop" or "ignore"
        "mark" says in `within_limits` which solutions keep to the joints' limits, "drop" leaves out
        the others, "ignore" does not look at them.
    redundancy : (...), optional
        Of an arm with seven joints the position of the last, else of the first (rad, m), for which
        all branches are returned; without it, of each branch the one nearest to q0, else to the
        middle of the limits.
    starts, seed : int, optional
        Of the numeric search (default: 32 for redundant arms, else 96, and 0), which they ask for;
        refused where a closed form finds all.

    Returns
    -------
    Solutions
        q (..., k, nq), of a family (..., *family, k, nq); every solution has been put through
        forward kinematics. Out of reach: k = 0, the distance (m) to the workspace, and a sentence
        in `notes`.

    Raises
    ------
    ShapeError, NotFiniteError, UnknownNameError, MissingValueError
    """
    given: Any = target
    try:
        known = model.compiled["inverse_kinematics", frame, task, limits, given.shape[-1]]
        sure = known(given, q0, redundancy)
        if sure is not None and starts is None and seed is None:
            return sure
    except _UNCLEAR:
        pass
    rigid = untwisted(model)
    if rigid is not None:
        near = (
            None
            if q0 is None
            else rigid.links(finite_vector("inverse_kinematics", model, "q0", q0))
        )
        found = inverse_kinematics(
            rigid.model,
            target,
            frame,
            task,
            q0=near,
            limits=limits,
            redundancy=redundancy,
            starts=starts,
            seed=seed,
        )
        return found.at(rigid.at(found.q), model.family)
    problem, poses = _checked_problem(model, target, frame, task, q0, limits, starts, seed)
    batch = poses.shape[:-2]
    if model.family:
        if redundancy is not None:
            raise FamilyError("inverse_kinematics: redundancy=", model.name, model.family)
        return of_family(model, problem, batch, _of_member)
    if model.loops and redundancy is None:
        return of_closed_chain(problem, batch)
    form = _form(problem)
    if redundancy is not None:
        batch, problem = _held(problem, form, redundancy, poses)
    problem, found = _found(problem, form)
    if form is not None and len(problem.target) and (form.held is None or redundancy is not None):
        _remember(problem, form, frame, task)
    return gathered(problem, form, found, batch)


def _of_member(problem: InverseProblem) -> Solutions:
    """Solutions for a row of targets, computed as for a single robot."""
    batch = (len(problem.target),)
    if problem.solver.model.loops:
        return of_closed_chain(problem, batch)
    form = _form(problem)
    problem, found = _found(problem, form)
    return gathered(problem, form, found, batch)


def _found(problem: InverseProblem, form: ClosedFormArm | None) -> tuple[InverseProblem, Found]:
    """The problem with its targets completed where the task leaves something open, and the
    solutions found for it."""
    if not len(problem.target):
        return problem, nothing(problem, form.method if form else "Levenberg–Marquardt")
    if form is None:
        return problem, _without_form(problem)
    if form.held is not None and problem.held is None:
        found = None if problem.searched else by_self_motion(problem, form)
        return problem, found or by_search(problem)
    problem.refuse_search()
    problem = replace(problem, target=form.complete(problem.target))
    return problem, by_closed_form(problem, form)


def _checked_problem(
    model: Model,
    target: ArrayLike,
    frame: str | None,
    task: str | Sequence[str] | None,
    q0: JointVector | None,
    limits: LimitsChoice,
    starts: int | None,
    seed: int | None,
) -> tuple[InverseProblem, Array]:
    """The arguments of `inverse_kinematics`, checked, as a problem (of a family for its first
    member), and the targets as poses (…, dim + 1, dim + 1)."""
    function = "inverse_kinematics"
    model.require_values("inverse kinematics")
    if limits not in LIMITS:
        raise UnknownNameError("choice", limits, f"{function}: limits=", LIMITS)
    if starts is not None and starts < 1:
        raise FreebodyError(f"{function}: starts is {starts}, expected at least 1.")
    chosen, poses = read_target(function, model, target, task)
    solver = NumericalSolver(model, model.frame(frame).name, chosen)
    start = None if q0 is None else finite_vector(function, model, "q0", q0)
    if start is not None and start.ndim != 1:
        raise FreebodyError(f"{function}: q0 has shape {start.shape}, expected ({model.nq},).")
    if model.family:
        solver = replace(solver, model=model[(0,) * len(model.family)])
    flat = poses.reshape(-1, *poses.shape[-2:])
    searched = starts is not None or seed is not None
    return InverseProblem(solver, flat, start, limits, starts, seed or 0, searched), poses


def _form(problem: InverseProblem) -> ClosedFormArm | None:
    """The arm's closed form, where it has one for this task and the targets."""
    solver = problem.solver
    if solver.model.loops:
        return None
    facts, name = solver.model.facts, f"closed form for {solver.task.rows} of {solver.frame!r}"
    if name not in facts:
        facts.setdefault(name, closed_form_for(solver.model, solver.frame, solver.task))
    form: ClosedFormArm | None = facts[name]
    return form if form is not None and form.serves(problem.target) else None


def _without_form(problem: InverseProblem) -> Found:
    """Solutions of an arm without a closed form: from the branches of a nearby arm, else from many
    starts."""
    solver = problem.solver
    known = None
    if not problem.searched:
        known = nearby_form(solver.model, solver.frame, solver.task)
    return by_search(problem) if known is None else by_nearby(problem, known)


def _held(
    problem: InverseProblem, form: ClosedFormArm | None, redundancy: ArrayLike, poses: Array
) -> tuple[tuple[int, ...], InverseProblem]:
    """The batch shape of targets and positions of the held joint (`redundancy`), and the problem
    with both broadcast to it."""
    function, model = "inverse_kinematics", problem.solver.model
    given = as_floats(function, "redundancy", redundancy)
    refuse_not_finite(function, "redundancy", given, 0)
    if form is None or form.held is None:
        raise FreebodyError(
            f"{function}: redundancy is the position of one joint of an arm with seven of which "
            f"the other six have a closed form; {model.name!r} with frame "
            f"{problem.solver.frame!r} and this task is none. Leave it out."
        )
    try:
        batch = np.broadcast_shapes(given.shape, poses.shape[:-2])
    except ValueError:
        raise FreebodyError(
            f"{function}: the batch shapes do not broadcast together: target {poses.shape[:-2]}, "
            f"redundancy {given.shape}."
        ) from None
    core = poses.shape[-2:]
    flat = np.broadcast_to(poses, (*batch, *core)).reshape(-1, *core)
    solver = replace(problem.solver, still=form.held)
    held = np.broadcast_to(given, batch).reshape(-1)
    return batch, replace(problem, solver=solver, target=flat, held=held)


_NONE.flags.writeable = False


def _remember(
    problem: InverseProblem, form: ClosedFormArm, frame: str | None, task: object
) -> None:
    """Keep a function for the arm, frame and task that answers later calls quickly, where targets
    are plain poses or points."""
    kind, d = form.branches.kind, form.branches.dim
    plain = {"pose": d + 1, "position": d}.get(kind)
    kernel = branch_kernel(problem.solver, form)
    full = len(form.task.rows) == (d if kind == "position" else 3 * d - 3)
    if kernel is None or plain is None or not full or task not in (None, kind):
        return
    if problem.limits not in ("mark", "ignore"):
        return
    answer = _answering(kernel, form, replace(problem, q0=None))
    place = "inverse_kinematics", frame, task, problem.limits, plain
    problem.solver.model.compiled[place] = answer


def _answering(kernel: Kernel, form: ClosedFormArm, own: InverseProblem) -> _QuickAnswer:
    """The function that answers calls quickly for one frame, task and choice of limits; own: the
    problem without q0."""
    axes = 2 if form.branches.kind == "pose" else 1  # of one target
    middle, rest, every = own.reference, own.rest, form.branches.count
    seven, names = form.held is not None, form.names
    said = notes(own, form, np.zeros(len(form.chain.screws), dtype=bool))
    alike = {"distance": _NONE, "method": form.method, "notes": tuple(said)}
    if own.limits == "ignore":
        alike["_ignored"] = True
    array, double = np.ndarray, np.dtype(np.float64)

    def answer(target: Any, q0: Any, held: Any) -> Solutions | None:
        if type(target) is not array or target.dtype is not double:
            return None
        near, beside = middle, rest
        if q0 is not None:
            if type(q0) is not array or q0.dtype is not double or q0.ndim != 1:
                return None
            near = beside = q0
        if seven:
            if type(held) is double.type:
                held = float(held)
            elif not (type(held) is float or (type(held) is array and held.dtype is double)):
                return None
            if np.ndim(held) > target.ndim - axes:
                return None
            q, residual, within, count = kernel(target, near, beside, held)
        elif held is None:
            q, residual, within, count = kernel(target, near, beside)
        else:
            return None
        if type(count) is array:
            return _of_batch(own, form, alike, (target, q0, held), (q, residual, within, count))
        k = int(count)
        if k < 1:
            return None
        if k < every:
            q, residual = q[:k], residual[:k]
        return Solutions.of_kernel(names, q, residual, within, alike)

    return answer


def _of_batch(
    own: InverseProblem,
    form: ClosedFormArm,
    alike: dict[str, Any],
    given: tuple[Array, Array | None, Any],
    arrays: tuple[Array, ...],
) -> Solutions | None:
    """The solutions from a kernel's outputs (q, residual, within, count) for the given targets, q0
    and held positions; targets that the kernel cannot decide are computed again more closely. None
    where that fails."""
    q, residual, within, count = arrays
    if not count.size:
        return None
    others = alike | {"distance": np.zeros(count.shape)}
    few = count.tolist() if count.ndim == 1 and len(count) <= _FEW else None
    clear = count.min() >= 1.0 if few is None else all(x >= 1.0 for x in few)
    if not clear:
        looked = _closer(own, form, given, arrays)
        if looked is None:
            return None
        others |= looked
    k = int(max(few) if clear and few is not None else count.max())
    return Solutions.of_kernel(form.names, q[..., :k, :], residual[..., :k], within, others)


def _closer(
    own: InverseProblem,
    form: ClosedFormArm,
    given: tuple[Array, Array | None, Any],
    arrays: tuple[Array, ...],
) -> dict[str, Any] | None:
    """The distances and notes after solving more closely those targets of a batch that the kernel
    could not decide, whose solutions are put into its arrays (q, residual, within, count); None
    where they are many or a target is invalid, so that all are solved together."""
    (target, q0, held), (q, residual, within, counted) = given, arrays
    batch, rows = counted.shape, np.flatnonzero(~(counted.ravel() >= 1.0))
    if len(rows) > _PART * counted.size:
        return None
    core = target.shape[target.ndim - (2 if form.branches.kind == "pose" else 1) :]
    some = np.broadcast_to(target, (*batch, *core)).reshape(-1, *core)[rows]
    place = None if held is None else np.broadcast_to(held, batch).reshape(-1)[rows]
    if place is not None and not np.isfinite(place).all():
        return None
    try:
        _, poses = read_target("inverse_kinematics", own.solver.model, some, form.branches.kind)
    except FreebodyError:
        return None
    problem = replace(own, q0=q0, target=form.complete(poses), held=place)
    numbered = Numbered(rows, counted.size)
    found = gathered(problem, form, by_closed_form(problem, form), (len(rows),), numbered=numbered)
    k, every = len(found), residual.shape[-1]
    if k > every:
        return None
    values = found.q, found.residual, found.within_limits
    for array, value in zip((q, residual, within), values, strict=True):
        flat = array.reshape(-1, *array.shape[len(batch) :])
        flat[rows] = np.nan
        flat[rows, :k] = value
    counted.flat[rows] = found.count
    distance = np.zeros(batch)
    distance.flat[rows] = found.distance
    return {"distance": distance, "notes": found.notes}
