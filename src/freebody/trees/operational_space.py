"""Quantities for control and identification: operational space, the centre of mass, linear
parameters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import NO_CENTRE
from freebody.algorithms.regressor import parameter_values
from freebody.arrays import Array, at_sample
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.options import motion_rows, require_few_rows
from freebody.model.geometry import fact
from freebody.model.inertial_parameters import parameter_names
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.tree import about_origin
from freebody.spatial import of_dimension
from freebody.trees.closer_looks import looking_closer
from freebody.trees.dynamics import bias, mass_matrix, where_all_move_mass
from freebody.trees.kinematics import jacobian, jacobian_dot
from freebody.trees.public_calls import JointVector, careful, evaluate, refuse_overflow
from freebody.trees.special_joints import refuse_massless, refuse_passive


def mass_matrix_inverse(model: Model, q: JointVector) -> Array:
    """M⁻¹ (..., nv, nv). q: (..., nq). Raises SingularError naming the joint that moves no
    inertia."""
    return evaluate("mass_matrix_inverse", model, (q,), None, None, where_all_move_mass)


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
    """Frame and rows, which must be at most as many as there are joint coordinates."""
    refuse_massless(model, function)
    option = Option(model.frame(frame).name, rows=motion_rows(model, rows))
    require_few_rows(function, model, option.rows)
    return option


def as_it_is(model: Model, option: Option) -> Option:
    """An option that is the key's own."""
    return option


def refuse_dependent_rows(function: str, model: Model, q: JointVector, option: Option) -> None:
    """Raise SingularError where the arm cannot move the frame along all rows."""
    option = Option(option.frame, rows=option.rows)
    answer = looking_closer(partial(_inertia, function))
    evaluate(("operational_space_inertia", option), model, (q,), as_it_is, None, answer)


def _inertia(function: str, model: Model, option: Option, at: np.ndarray, *state: Array) -> Array:
    """Λ (k, …, r, r), where the arm can move the frame along all rows; at: of the samples."""
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


def centroidal_momentum_matrix(model: Model, q: JointVector) -> Array:
    """A (..., 6, nv): A q̇ is the momentum about the centre of mass of what moves, linear then
    angular, world axes.

    (..., 3, nv) in the plane. q: (..., nq). Raises SingularError where nothing that moves has a
    mass. Source: Orin, Goswami, Lee 2013.
    """
    return evaluate(
        "centroidal_momentum_matrix", model, (q,), None, None, _centroidal_momentum_matrix
    )


def _centroidal_momentum_matrix(
    function: str, model: Model, inputs: tuple[JointVector, ...], *_: None
) -> Array:
    require_model(function, model)
    if not _moves_mass(model):
        raise SingularError(NO_CENTRE.format("no link that moves"))
    return careful(function, model, inputs)


@fact
def _moves_mass(model: Model) -> bool:
    """Whether what moves has a centre of mass."""
    space = of_dimension(model.dim)
    total = sum(about_origin(space, body.masses)[0] for body in model.tree.bodies)
    return bool(np.all(total != 0.0))


def regressor(model: Model, q: JointVector, qd: JointVector, qdd: JointVector) -> Array:
    """Y (..., nv, p) with tau = Y π, π = `fb.inertial_parameters(model)`, in its order."""
    return evaluate("regressor", model, (q, qd, qdd))


def energy_regressor(model: Model, q: JointVector, qd: JointVector) -> Array:
    """(..., 2, p): kinetic and potential energy (without the constants of springs and of links
    fixed to the base) as linear functions of π."""
    return evaluate("energy_regressor", model, (q, qd))


def inertial_parameters(model: Model) -> dict[str, Any]:
    """π by name: of each body m, hx, hy, hz (first moment), Ixx, Ixy, Ixz, Iyy, Iyz, Izz about its
    joint's origin, in its axes (plane: m, hx, hy, I); then of each joint with a drive the
    numbers of the laws that act there by their names, such as viscous, rotor (J gear²) and
    stiffness. Of a family arrays where members differ."""
    require_model("inertial_parameters", model)
    values = (x if isinstance(x, np.ndarray) else float(x) for x in parameter_values(model.tree))
    return dict(zip(parameter_names(model), values, strict=True))


def forward_dynamics_parameter_derivatives(
    model: Model, q: JointVector, qd: JointVector, tau: JointVector
) -> Array:
    """∂q̈/∂π (..., nv, p) = -M⁻¹ Y, π in the order of `fb.inertial_parameters`; the regressor Y is
    ∂tau/∂π.

    Raises as `forward_dynamics_derivatives` does.
    """
    name = "forward_dynamics_parameter_derivatives"
    if isinstance(model, Model) and model.passive:
        refuse_passive(name, model, tau)
    return evaluate(name, model, (q, qd, tau), None, None, where_all_move_mass)
