"""The answer at once: where a closed form has been asked for before, and all is plain and clear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.answer import Numbered, gathered
from freebody.inverse.branch_kernel import branch_kernel
from freebody.inverse.by_closed_form import by_closed_form, notes
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.problem import Problem
from freebody.inverse.solutions import Solutions
from freebody.inverse.task import read_target
from freebody.targets import Kernel

_NONE = np.zeros(())
_NONE.flags.writeable = False

Answer = Callable[[Any, Any, Any], Solutions | None]
"""(target, q0, redundancy) -> the solutions; None where something has to be looked at: the
arguments, or a target without solution or next to a singular one."""


_FEW = 16
"""Targets that are sooner counted in plain Python."""
_PART = 0.5
"""Of the targets: so many at most are looked at closer by themselves."""

UNCLEAR = (KeyError, TypeError, ValueError, IndexError, AttributeError)
"""What looking for an answer, or asking it, raises where an argument is not plain: whoever looks
closer says what is wrong with it."""


def remember(problem: Problem, form: ClosedFormArm, frame: str | None, task: object) -> None:
    """Answer at once from now on, where targets are given as this task takes them."""
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


def _answering(kernel: Kernel, form: ClosedFormArm, own: Problem) -> Answer:
    """What answers for one frame, task and choice of limits; own: without q0."""
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
    own: Problem,
    form: ClosedFormArm,
    alike: dict[str, Any],
    given: tuple[Array, Array | None, Any],
    arrays: tuple[Array, ...],
) -> Solutions | None:
    """The answer from what the kernel found (q, residual, within, count) of the targets, q0 and
    held positions that were given; those that are not clear to it looked at closer."""
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
    own: Problem,
    form: ClosedFormArm,
    given: tuple[Array, Array | None, Any],
    arrays: tuple[Array, ...],
) -> dict[str, Any] | None:
    """Look closer at those targets of a batch that are not clear to the kernel, and put what is
    found into its arrays (q, residual, within, count); the distances and notes then. None where
    they are many, or one of them is no target: that is said of all together."""
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
