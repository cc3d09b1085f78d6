"""The closed form for a frame and a task, if its chain of joints has one."""

from __future__ import annotations

import numpy as np

from freebody.algorithms.closed_form_inverse.choose_recipe import without_idle
from freebody.algorithms.joint_lines import parallel
from freebody.algorithms.screws import ScrewChain, chain_to
from freebody.arrays import Array
from freebody.inverse.closed_form import (
    ClosedFormSolver,
    Displacement,
    six_joints,
    three_joints,
    three_turns,
)
from freebody.inverse.parallel_axes import ParallelAxesArm, parallel_axes_arm
from freebody.inverse.task import Task
from freebody.model.model import Model

_UP = np.array([0.0, 0.0, 1.0])


def closed_form_for(model: Model, frame: str, task: Task) -> ClosedFormSolver | None:
    """The closed form that gives all solutions of a task, or None."""
    chain = chain_to(model.tree, frame)
    if chain is not None and not task.angular:
        chain = without_idle(chain)
    if chain is None or len(chain.screws) > 6:
        return None
    if model.dim == 2:
        return parallel_axes_arm(chain, _UP, task.turns, ("up", "down")) if task.places else None
    if task.places and task.turns and len(chain.screws) == 6:
        return six_joints(chain)
    form = _level_in_space(model, chain, task)
    if form is None and task.places and len(chain.screws) == 3:
        form = three_joints(chain)
    if form is None and task.turns and not task.linear and len(chain.screws) == 3:
        form = three_turns(chain)
    return form


def _level_in_space(model: Model, chain: ScrewChain, task: Task) -> ClosedFormSolver | None:
    form = parallel_axes_arm(chain, None, bool(task.angular), _elbows(model, chain))
    if not isinstance(form, ParallelAxesArm):
        return None
    along = [k for k in range(3) if parallel(np.eye(3)[k], form.normal)]
    needed = {k for k in range(3) if k not in along or form.lift is not None}
    turned = not task.angular or task.turns or bool(along and along[0] in task.angular)
    return form if needed <= set(task.linear) and turned else None


def _elbows(model: Model, chain: ScrewChain) -> tuple[str, str]:
    """Up and down for an arm that moves in an upright plane, left and right (from above) for one
    that moves level."""
    axis = next((s.w for s in chain.screws if s.turning), None)
    if axis is None:
        return ("up", "down")
    lean = float(np.array(model.gravity_direction) @ axis)
    return (
        ("up", "down") if abs(lean) < 0.5 else ("left", "right") if lean < 0 else ("right", "left")
    )


def displacement(chain: ScrewChain, target: Array) -> Displacement:
    """X = T T(0)⁻¹ of targets (N, …), those in the plane put into z = 0."""
    d = target.shape[-1] - 1
    R = np.broadcast_to(np.eye(3), (len(target), 3, 3)).copy()
    p = np.zeros((len(target), 3))
    R[:, :d, :d], p[:, :d] = target[:, :d, :d], target[:, :d, d]
    R = R @ chain.R.T
    return Displacement(R, p - R @ chain.p)


def displacement_to_points(chain: ScrewChain, target: Array) -> Displacement:
    """The shifts that bring the frame from zero to the points of targets (N, …); their rotation is
    not asked for."""
    d = target.shape[-1] - 1
    p = np.zeros((len(target), 3))
    p[:, :d] = target[:, :d, d]
    return Displacement(np.broadcast_to(np.eye(3), (len(target), 3, 3)), p - chain.p)


def can_serve(form: ClosedFormSolver, task: Task, X: Displacement) -> bool:
    """Whether the form fits these targets too: a partial orientation must be a turn about the arm's
    own axis."""
    if not isinstance(form, ParallelAxesArm) or task.turns or not task.angular:
        return True
    return bool(np.abs(X.R @ form.normal - form.normal).max(initial=0.0) < 1e-9)
