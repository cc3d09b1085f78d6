"""Formulas of torques, energies and accelerations as functions of inertial parameters."""

from __future__ import annotations

from typing import Any

from freebody.algorithms.crba import crba, factor, substitute
from freebody.algorithms.forward_dynamics import forward_dynamics
from freebody.algorithms.regressor import energy_regressor, regressor
from freebody.kernels.formulas.record import Formula, Option, one
from freebody.model.tree import Tree
from freebody.spatial import Vector, neg, transposed


def _forward_by_parameters(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector
) -> tuple[Any, ...]:
    """Derivative of the acceleration by the parameters, ∂q̈/∂π = -M⁻¹ Y."""
    qdd = forward_dynamics(tree, q, qd, tau)
    factors = factor(tree, crba(tree, q))
    columns = transposed(regressor(tree, q, qd, qdd))
    return (transposed(tuple(neg(substitute(tree, factors, column)) for column in columns)),)


FORMULAS = {
    "regressor": Formula(
        ("q", "qd", "qdd"),
        one("Y", ("nv", "parameters"), "factors of the inertial parameters in the torques"),
        lambda t, o, q, qd, qdd: (regressor(t, q, qd, qdd),),
        chains="open",
        without_struts=True,
        lossless=True,
        touches=(),
    ),
    "energy_regressor": Formula(
        ("q", "qd"),
        one(
            "E",
            (2, "parameters"),
            "factors of the inertial parameters in the kinetic, then the potential energy",
        ),
        lambda t, o, q, qd: (energy_regressor(t, q, qd),),
        without_struts=True,
        touches=(),
    ),
    "forward_dynamics_parameter_derivatives": Formula(
        ("q", "qd", "tau"),
        one(
            "dqdd_dpi",
            ("nv", "parameters"),
            "derivative of the accelerations with respect to the inertial parameters",
        ),
        _forward_by_parameters,
        chains="open",
        lossless=True,
    ),
}
