"""The answer at once: where a closed form has been asked for before, and all is plain and clear."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.inverse.branch_kernel import branch_kernel
from freebody.inverse.by_closed_form import notes
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.problem import Problem
from freebody.inverse.solutions import Solutions
from freebody.model.model import Model
from freebody.targets import Kernel

_NONE = np.zeros(())
_NONE.flags.writeable = False


@dataclass(frozen=True, eq=False)
class _Plain:
    """What answers for one frame, task and choice of limits."""

    kernel: Kernel
    form: ClosedFormArm
    axes: int
    """Of one target."""
    reference: Array
    rest: Array
    ignore: bool
    """Whether limits count."""
    notes: tuple[str, ...]

    def __call__(self, target: Any, q0: Any, held: Any) -> Solutions | None:
        """None where something has to be looked at: the arguments, or a target without solution or
        next to a singular one."""
        if type(target) is not np.ndarray or target.dtype != np.float64:
            return None
        reference, rest = self.reference, self.rest
        if q0 is not None:
            if type(q0) is not np.ndarray or q0.dtype != np.float64 or q0.ndim != 1:
                return None
            reference = rest = q0
        if self.form.held is None:
            if held is not None:
                return None
            q, residual, within, count = self.kernel(target, reference, rest)
        else:
            if not (type(held) is float or (type(held) is np.ndarray and held.dtype == np.float64)):
                return None
            if np.ndim(held) > target.ndim - self.axes:
                return None
            q, residual, within, count = self.kernel(target, reference, rest, held)
        if count.ndim:
            if not count.size or not count.min() >= 1.0:
                return None
            k, distance = int(count.max()), np.zeros(count.shape)
        elif count >= 1.0:
            k, distance = int(count), _NONE
        else:
            return None
        if k < q.shape[-2]:
            q, residual, within = q[..., :k, :], residual[..., :k], within[..., :k]
        return Solutions.lazily_named(
            self.form.names,
            q=q,
            residual=residual,
            within_limits=residual == residual if self.ignore else within == 1.0,
            distance=distance,
            method=self.form.method,
            notes=self.notes,
        )


def quick_answer(
    model: Model, target: Any, frame: Any, task: Any, q0: Any, limits: Any, held: Any
) -> Solutions | None:
    """The solutions, if what was remembered is sure of them."""
    try:
        known = model.compiled["inverse_kinematics", frame, task, limits, target.shape[-1]]
        return known(target, q0, held)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError):
        return None  # explained by who looks closer


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
    model = problem.solver.model
    own = replace(problem, q0=None)
    model.compiled["inverse_kinematics", frame, task, problem.limits, plain] = _Plain(
        kernel,
        form,
        2 if kind == "pose" else 1,
        own.reference,
        own.rest,
        problem.limits == "ignore",
        tuple(notes(problem, form, np.zeros(len(form.chain.screws), dtype=bool))),
    )
