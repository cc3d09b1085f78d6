"""Torques, accelerations, wrenches of joints, and the matrices of the equations of motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.algorithms.aba import aba
from freebody.algorithms.coriolis import coriolis_matrix, coriolis_product
from freebody.algorithms.crba import (
    bias,
    crba,
    factor,
    mass_product,
    only_inertia,
    supports,
)
from freebody.algorithms.forward_dynamics import forward_dynamics
from freebody.algorithms.loop_checks import (
    closure_margins,
    consistent_margin,
    following_margins,
    solution_margins,
    sure,
)
from freebody.algorithms.loop_constraints import constrained_motion, independence
from freebody.algorithms.operational_space import mass_matrix_inverse
from freebody.algorithms.rnea import External, joint_wrenches, rnea
from freebody.arrays import Array
from freebody.kernels.formulas.record import (
    Fetch,
    Formula,
    Option,
    at_driven_joints,
    external,
    one,
    still,
)
from freebody.model.doubts import FRICTION, INERTIAL, MASSES, ROTORS
from freebody.model.tree import Tree
from freebody.spatial import Vector, sub


def _inverse(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    tau = at_driven_joints(tree, o, q, rnea(tree, q, qd, qdd, external(tree, o, q, wrenches)).tau)
    if not o.checks:
        return (tau,)
    return (sure(tau, [*closure_margins(tree, q, qd), consistent_margin(tree, q, qd, qdd)]),)


def forward(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    """Accelerations of a tree or a closed chain, as the one entry of a tuple; at a stage of a step
    too, which is a little beside the loops."""
    if tree.loops:
        return (_closed_forward(tree, o, q, qd, tau, external(tree, o, q, wrenches)),)
    method = aba if _prefers_articulated_bodies(tree) else forward_dynamics
    return (method(tree, q, qd, tau, external(tree, o, q, wrenches)),)


def _closed_forward(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, loads: list[External]
) -> Vector:
    M = crba(tree, q)
    factors = factor(tree, M)
    found = constrained_motion(
        tree, q, qd, factors, sub(tau, bias(tree, q, qd, loads)), o.equations
    )
    if not o.checks:
        return sure(found.qdd, [independence(tree, found.pivots, o.equations)])
    margins = solution_margins(tree, M, factors, found, o.equations)
    margins.append(consistent_margin(tree, q, qd, found.qdd))
    return sure(found.qdd, margins + (closure_margins(tree, q, qd) if o.checks == "state" else []))


def _forward(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    (qdd,) = forward(tree, o, q, qd, tau, wrenches)
    stage = o.checks == "solution"  # of an integration, a little beside the loops
    followed = [] if stage else following_margins(tree, q, qd, qdd, o.equations)
    return (sure(qdd, followed) if followed else qdd,)


def _prefers_articulated_bodies(tree: Tree) -> bool:
    """Whether articulated bodies take fewer operations than factoring the mass matrix: chains are
    long."""
    longest = max((len(above) for above in supports(tree).values()), default=0)
    return longest >= 24 and not tree.follows and not tree.lossy


def _gravity(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    return (rnea(only_inertia(tree), q, still(tree), still(tree)).tau,)


def _static(tree: Tree, o: Option, q: Vector, wrenches: Any = ()) -> tuple[Any, ...]:
    return _inverse(tree, o, q, still(tree), still(tree), wrenches)


def _wrenches(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    return (
        joint_wrenches(tree, rnea(tree, q, qd, qdd, external(tree, o, q, wrenches)), o.reference),
    )


def mass_by_columns(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of M, (..., column, row), by products of M and unit vectors."""
    (q,) = given
    return (fetch("mass_product")(q, np.eye(n), threads=threads),)


def _inverse_mass_by_columns(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of M⁻¹, (..., column, row)."""
    inverse: Array = np.asarray(
        np.linalg.inv(mass_by_columns(given, n, fetch, threads)[0]), dtype=np.float64
    )
    return (inverse,)


def _coriolis_by_columns(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of C, (..., column, row), by products of C and unit vectors."""
    q, qd = given
    return (fetch("coriolis_product")(q, qd, np.eye(n), threads=threads),)


FORMULAS = {
    "inverse_dynamics": Formula(
        ("q", "qd", "qdd", "wrenches"),
        one("tau", ("nv",), "torques and forces of the joints (N m, N)"),
        _inverse,
        by_motion=True,
        settled="partition",
        derivatives={"inverse_dynamics_derivatives": ("q", "qd", "qdd"), "mass_matrix": ("qdd",)},
    ),
    "forward_dynamics": Formula(
        ("q", "qd", "tau", "wrenches"),
        one("qdd", ("nv",), "accelerations (rad/s^2, m/s^2)"),
        _forward,
        by_motion=True,
        settled="equations",
        derivatives={
            "forward_dynamics_derivatives": ("q", "qd", "tau"),
            "mass_matrix_inverse": ("tau",),
        },
    ),
    "mass_matrix": Formula(
        ("q",),
        one("M", ("nv", "nv"), "mass matrix (kg m^2, kg)"),
        lambda t, o, q: (crba(t, q),),
        by_motion=True,
        by_columns=mass_by_columns,
        touches=(*INERTIAL, ROTORS),
    ),
    "mass_matrix_inverse": Formula(
        ("q",),
        one("Minv", ("nv", "nv"), "inverse of the mass matrix (1/(kg m^2), 1/kg)"),
        lambda t, o, q: (mass_matrix_inverse(t, q),),
        chains="open",
        by_columns=_inverse_mass_by_columns,
        touches=(*INERTIAL, ROTORS),
    ),
    "mass_product": Formula(
        ("q", "x"),
        one("Mx", ("nv",), "mass matrix times x"),
        lambda t, o, q, x: (mass_product(t, q, x),),
        touches=(*INERTIAL, ROTORS),
    ),
    "coriolis_matrix": Formula(
        ("q", "qd"),
        one("C", ("nv", "nv"), "Coriolis matrix (N m s/rad, N s/m)"),
        lambda t, o, q, qd: (coriolis_matrix(t, q, qd),),
        by_columns=_coriolis_by_columns,
        touches=INERTIAL,
    ),
    "coriolis_product": Formula(
        ("q", "qd", "x"),
        one("Cx", ("nv",), "Coriolis matrix times x"),
        lambda t, o, q, qd, x: (coriolis_product(t, q, qd, x),),
        touches=INERTIAL,
    ),
    "bias": Formula(
        ("q", "qd"),
        one("bias", ("nv",), "torques at zero accelerations (N m, N)"),
        lambda t, o, q, qd: (bias(t, q, qd),),
        by_motion=True,
        lossless=True,
        touches=(*INERTIAL, FRICTION),
    ),
    "gravity_torque": Formula(
        ("q",),
        one("g", ("nv",), "torques that balance gravity (N m, N)"),
        _gravity,
        touches=(MASSES,),
    ),
    "static_torque": Formula(
        ("q", "wrenches"),
        one("tau", ("nv",), "torques that hold the robot still (N m, N)"),
        _static,
        settled="partition",
        touches=(MASSES,),
    ),
    "joint_wrenches": Formula(
        ("q", "qd", "qdd", "wrenches"),
        one("W", ("nj", "six"), "wrench of each joint on its body: force, then moment (N, N m)"),
        _wrenches,
        axes=("child",),
        chains="open",
        touches=INERTIAL,
    ),
}
