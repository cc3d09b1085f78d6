"""Operational space: inertia and bias of a frame's motion (Khatib 1987)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from freebody.arrays import Array, at_sample
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.options import motion_rows, require_few_rows
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.closer_looks import looking_closer
from freebody.trees.dynamics import bias, mass_matrix
from freebody.trees.kinematics import jacobian, jacobian_dot
from freebody.trees.public_calls import JointVector, evaluate, refuse_overflow
from freebody.trees.special_joints import refuse_massless


def operational_space_inertia(
    model: Model, q: JointVector, frame: str | None = None, rows: Sequence[str] | None = None
) -> Array:
    """Λ = (J M⁻¹ Jᵀ)⁻¹ (..., r, r) of a frame's motion, rows linear then angular, world axes
    (Khatib 1987).

    q: (..., nq). frame: name, default the tip. rows: which of "vx", "vy", "vz", "wx", "wy", "wz"
    (plane: "vx", "vy", "w"); default all. Raises SingularError where the arm cannot move the frame
    along all of them.
    """
    require_model("operational_space_inertia", model)
    option = operational_option(model, frame, rows, "operational_space_inertia")
    key = "operational_space_inertia", option
    return evaluate(key, model, (q,), as_it_is, None, _INERTIA)


def operational_space_bias(
    model: Model,
    q: JointVector,
    qd: JointVector,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
) -> Array:
    """μ (..., r) with Λ ẍ + μ = the wrench at the frame that produces ẍ: velocity, gravity,
    friction, springs.

    qd: (..., nv); other arguments and errors as for `operational_space_inertia`.
    """
    require_model("operational_space_bias", model)
    option = operational_option(model, frame, rows, "operational_space_bias")
    key = "operational_space_bias", option
    return evaluate(key, model, (q, qd), as_it_is, None, _BIAS)


def operational_option(
    model: Model, frame: str | None, rows: Sequence[str] | None, function: str
) -> Option:
    """The option of a frame and rows, of which there must be at most as many as joint coordinates;
    refuses massless joints."""
    refuse_massless(model, function)
    option = Option(model.frame(frame).name, rows=motion_rows(model, rows))
    require_few_rows(function, model, option.rows)
    return option


def as_it_is(model: Model, option: Option) -> Option:
    """The option unchanged, for functions whose key already holds the final one."""
    return option


def refuse_dependent_rows(function: str, model: Model, q: JointVector, option: Option) -> None:
    """Raise SingularError where the arm cannot move the frame along all chosen rows."""
    option = Option(option.frame, rows=option.rows)
    answer = looking_closer(partial(_inertia, function))
    evaluate(("operational_space_inertia", option), model, (q,), as_it_is, None, answer)


def _inertia(function: str, model: Model, option: Option, at: np.ndarray, *state: Array) -> Array:
    """The inertia Λ (k, …, r, r) where the arm can move the frame along all rows, else an error;
    at: the samples' indices."""
    q = state[0]
    J = jacobian(model, q, option.frame)[..., option.rows, :]
    values = np.linalg.svd(J, compute_uv=False)
    singular = np.argwhere(values[..., -1] <= _DEPENDENT * values[..., 0])
    if len(singular):
        first, *member = singular[0]
        raise SingularError(
            f"{function}: frame {option.frame!r} of {model.name!r} is at a "
            f"singularity{at_sample((*at[first], *member))}: "
            "the rows of its Jacobian are linearly dependent. Choose fewer rows, or another q."
        )
    mobility = J @ np.linalg.solve(mass_matrix(model, q), np.swapaxes(J, -1, -2))
    return np.asarray(np.linalg.inv(mobility), dtype=float)


def _bias(model: Model, option: Option, at: np.ndarray, *state: Array) -> Array:
    q, qd = state
    inertia = _inertia("operational_space_bias", model, option, at, q)
    refuse_overflow("operational_space_bias", {"qd": qd})  # else `bias` says it of itself
    J, drift = (
        x[..., option.rows, :]
        for x in (jacobian(model, q, option.frame), jacobian_dot(model, q, qd, option.frame))
    )
    torque = bias(model, q, qd)
    rest = J @ np.linalg.solve(mass_matrix(model, q), torque[..., None]) - drift @ qd[..., None]
    return (inertia @ rest)[..., 0]


_INERTIA = looking_closer(partial(_inertia, "operational_space_inertia"))
_BIAS = looking_closer(_bias)
_DEPENDENT = 1e-10
"""Smallest singular value, relative to the largest, of rows that depend on one another."""
