"""The kernel behind `inverse_kinematics`: all solutions of a closed form as they are returned, and
whether this is sure."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.near_reference import (
    ORTHOGONAL,
    JointRanges,
    solutions,
)
from freebody.elementary import absolute, less, where
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.numerical_solver import NumericalSolver
from freebody.inverse.solutions import turning_coordinates
from freebody.model.model import Model
from freebody.program import Argument, trace
from freebody.spatial import identity
from freebody.targets import Kernel, compile_program


def branch_kernel(
    solver: NumericalSolver, form: ClosedFormArm, in_front: bool = True
) -> Kernel | None:
    """(target, reference (nq,), rest (nq,), held?) -> (q (branches, nq), residual (branches,),
    within limits (branches,), count), compiled on first use; None for a form that gives
    candidates alone, or a coordinate that moves its joint by a multiple.

    target: the part that counts, see `ClosedFormArm.counted`. reference: next to it angles are
    wrapped; rest: of joints that do not move the frame. in_front: whether solutions stand before
    the branches there are none of, which are NaN; else each branch has its place. count: -1 where
    it is not clear which branches exist, or the target is no pose.
    """
    arm, model = form.branches, solver.model
    if not form.decides or (np.abs(arm.chain.ratio) != 1.0).any():
        return None
    key = ("solutions of inverse kinematics", solver.frame, arm.kind, in_front)
    found = model.compiled.get(key)
    if found is None:
        found = model.compiled[key] = _compiled(model, solver, form, in_front)
    return found


def _compiled(model: Model, solver: NumericalSolver, form: ClosedFormArm, in_front: bool) -> Kernel:
    arm, d, n = form.branches, form.branches.dim, model.nq
    low, high = (tuple(map(float, bound)) for bound in solver.bounds)
    known = JointRanges(low, high, tuple(map(bool, turning_coordinates(model))))

    def evaluate(target: Any, reference: Any, rest: Any, *held: Any) -> tuple[Any, ...]:
        R, p = form.of_counted(target)
        *found, count = solutions(arm, known, R, p, reference, rest, *held, in_front=in_front)
        if arm.kind == "pose":  # its last row too has to be a pose's
            for x, due in zip(target[d], identity(d + 1)[d], strict=True):
                count = where(less(absolute(x - due), 0.5 * ORTHOGONAL), count, -1.0)
        return (*found, count)

    inputs = [
        Argument("target", form.counted(np.eye(d + 1)).shape),
        Argument("reference", (n,)),
        Argument("rest", (n,)),
    ]
    if arm.held is not None:
        inputs.append(Argument("held", ()))
    B = arm.count
    outputs = [
        Argument("q", (B, n)),
        Argument("residual", (B,)),
        Argument("within", (B,)),
        Argument("count", ()),
    ]
    return compile_program(trace("inverse_kinematics", evaluate, inputs, outputs))
