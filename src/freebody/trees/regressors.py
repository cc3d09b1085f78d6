"""Regressors, a kernel's call each: torques, energies and accelerations as linear functions of the
inertial parameters, of which `base_parameters` tells those that count."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.algorithms.regressor import parameter_values
from freebody.arrays import Array
from freebody.model.inertial_parameters import parameter_names
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.dynamics import where_all_move_mass
from freebody.trees.public_calls import JointVector, evaluate
from freebody.trees.special_joints import refuse_passive


def regressor(model: Model, q: JointVector, qd: JointVector, qdd: JointVector) -> Array:
    """Y (..., nv, p) with tau = Y π, π = `fb.inertial_parameters(model)`, in its order."""
    return evaluate("regressor", model, (q, qd, qdd))


def energy_regressor(model: Model, q: JointVector, qd: JointVector) -> Array:
    """Factors (..., 2, p) of π in the kinetic and in the potential energy, without the constants of
    springs and of links fixed to the base."""
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
