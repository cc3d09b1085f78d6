"""Derivatives of inverse and forward dynamics along positions and rates."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.algorithms.crba import crba
from freebody.algorithms.derivatives import (
    Derivatives,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
)
from freebody.algorithms.kinematics import along_every_direction, position_rates
from freebody.algorithms.rnea import rnea
from freebody.arrays import Array
from freebody.dual import Dual, slopes
from freebody.kernels.formulas.dynamics import mass_by_columns
from freebody.kernels.formulas.record import (
    Fetch,
    Formula,
    Option,
    Output,
    one,
    seeded,
)
from freebody.model.tree import Tree
from freebody.spatial import Vector


def _matrices(derivatives: Derivatives) -> tuple[Any, ...]:
    return derivatives.by_q, derivatives.by_qd, derivatives.by_last


def _by_dual_scalars(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Derivatives:
    """Derivatives of inverse dynamics by forward mode, which takes fewer operations where many of a
    robot's geometric numbers are 0 or 1."""
    if tree.lossy:  # then the derivative by q̈ is not M
        return inverse_dynamics_derivatives(tree, q, qd, qdd)
    n = tree.nv
    faster = tuple(Dual(x, {n + k: 1.0}) for k, x in enumerate(qd))
    rows = [slopes(t, 2 * n) for t in rnea(tree, along_every_direction(tree, q), faster, qdd).tau]
    return Derivatives(
        tuple(tuple(r[:n]) for r in rows), tuple(tuple(r[n:]) for r in rows), crba(tree, q)
    )


def _along(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, dq: Vector, dqd: Vector
) -> tuple[Any, ...]:
    """The change of tau along a direction (dq, dqd) of the tangent space."""
    moved = seeded(q, position_rates(tree, q, dq))
    return (tuple(slopes(t, 1)[0] for t in rnea(tree, moved, seeded(qd, dqd), qdd).tau),)


def _second(tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector) -> tuple[Any, ...]:
    """Second derivatives of tau: its first derivatives along every direction of q, and of q̇."""
    n = tree.nv
    by_q = inverse_dynamics_derivatives(tree, along_every_direction(tree, q), qd, qdd)
    faster = tuple(Dual(x, {k: 1.0}) for k, x in enumerate(qd))
    by_qd = inverse_dynamics_derivatives(tree, q, faster, qdd)
    return tuple(
        tuple(tuple(slopes(x, n) for x in row) for row in table)
        for table in (by_q.by_q, by_q.by_qd, by_qd.by_qd, by_q.by_last)
    )


_MATRIX, _CUBE = ("nv", "nv"), ("nv", "nv", "nv")


def _inverse_derivatives(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of ∂τ/∂q, ∂τ/∂q̇ and M, (..., column, row), from directional derivatives along unit
    vectors."""
    q, qd, qdd = given
    along, none, units = fetch("inverse_dynamics_along"), np.zeros(n), np.eye(n)
    by_q = along(q, qd, qdd, units, none, threads=threads)
    by_qd = along(q, qd, qdd, none, units, threads=threads)
    return by_q, by_qd, *mass_by_columns([q], n, fetch, threads)


def _forward_derivatives(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of ∂q̈/∂q, ∂q̈/∂q̇ and M⁻¹, (..., column, row), from the derivatives of inverse
    dynamics."""
    q, qd, tau = given
    qdd = fetch("forward_dynamics")(q, qd, tau, threads=threads)
    by_q, by_qd, M = (
        np.swapaxes(x, -1, -2) for x in _inverse_derivatives([q, qd, qdd], n, fetch, threads)
    )
    inverse: Array = np.asarray(np.linalg.inv(M), dtype=np.float64)
    results: tuple[Array, ...] = (-inverse @ by_q, -inverse @ by_qd, inverse)
    return tuple(np.swapaxes(x, -1, -2) for x in results)


FORMULAS = {
    "inverse_dynamics_derivatives": Formula(
        ("q", "qd", "qdd"),
        {
            "dtau_dq": Output(_MATRIX, "derivative of tau with respect to q (N m/rad, ...)"),
            "dtau_dqd": Output(_MATRIX, "derivative of tau with respect to qd (N m s/rad, ...)"),
            "M": Output(
                _MATRIX, "derivative of tau with respect to qdd: the mass matrix (kg m^2, kg)"
            ),
        },
        lambda t, o, q, qd, qdd: _matrices(inverse_dynamics_derivatives(t, q, qd, qdd)),
        lambda t, o, q, qd, qdd: _matrices(_by_dual_scalars(t, q, qd, qdd)),
        by_motion=True,
        chains="open",
        by_columns=_inverse_derivatives,
        columns_lossless=True,
    ),
    "forward_dynamics_derivatives": Formula(
        ("q", "qd", "tau"),
        {
            "dqdd_dq": Output(
                _MATRIX, "derivative of the accelerations with respect to q (1/s^2, ...)"
            ),
            "dqdd_dqd": Output(
                _MATRIX, "derivative of the accelerations with respect to qd (1/s, ...)"
            ),
            "Minv": Output(
                _MATRIX,
                "derivative of the accelerations with respect to tau: the inverse mass matrix "
                "(1/(kg m^2), 1/kg)",
            ),
        },
        lambda t, o, q, qd, tau: _matrices(forward_dynamics_derivatives(t, q, qd, tau)),
        lambda t, o, q, qd, tau: _matrices(
            forward_dynamics_derivatives(t, q, qd, tau, _by_dual_scalars)
        ),
        by_motion=True,
        chains="open",
        by_columns=_forward_derivatives,
        columns_lossless=True,
    ),
    "inverse_dynamics_second_derivatives": Formula(
        ("q", "qd", "qdd"),
        {
            "d2tau_dq_dq": Output(_CUBE, "second derivative of tau with respect to q and q"),
            "d2tau_dqd_dq": Output(_CUBE, "second derivative of tau with respect to qd and q"),
            "d2tau_dqd_dqd": Output(_CUBE, "second derivative of tau with respect to qd and qd"),
            "dM_dq": Output(_CUBE, "derivative of the mass matrix with respect to q"),
        },
        _second,
        chains="open",
        lossless=True,
    ),
    "inverse_dynamics_along": Formula(
        ("q", "qd", "qdd", "dq", "dqd"),
        one("dtau", ("nv",), "change of tau along the direction (N m, N)"),
        _along,
        chains="open",
    ),
}
