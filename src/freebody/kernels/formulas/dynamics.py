"""Torques, accelerations, wrenches of joints and loops and how well they balance, and the matrices
of the equations of motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.algorithms import kinematics
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
from freebody.algorithms.loop_constraints import (
    constrained_motion,
    independence,
    loop_loads,
    loop_wrenches,
)
from freebody.algorithms.loop_forces import loose_recursions
from freebody.algorithms.newton_euler_residuals import Moving, balance
from freebody.algorithms.operational_space import mass_matrix_inverse
from freebody.algorithms.rnea import External, joint_wrenches, rnea
from freebody.algorithms.struts import strut_states
from freebody.arrays import Array
from freebody.dual import slopes
from freebody.kernels.formulas.record import (
    Fetch,
    Formula,
    Option,
    Output,
    at_driven_joints,
    external,
    one,
    partition_of,
    seeded,
    still,
)
from freebody.model.doubts import FRICTION, INERTIAL, MASSES, ROTORS
from freebody.model.tree import Tree
from freebody.scalars.time_derivatives import Jet, parts
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
    """Accelerations of a tree or a closed chain, in a tuple of one; also for states of a step that
    are slightly off the loops."""
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
    """Whether the articulated-body algorithm takes fewer operations than factoring the mass matrix,
    as it does for long chains."""
    longest = max((len(above) for above in supports(tree).values()), default=0)
    return longest >= 24 and not tree.follows and not tree.lossy


def _gravity(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    return (rnea(only_inertia(tree), q, still(tree), still(tree)).tau,)


def _static(tree: Tree, o: Option, q: Vector, wrenches: Any = ()) -> tuple[Any, ...]:
    return _inverse(tree, o, q, still(tree), still(tree), wrenches)


def _strut_states(tree: Tree, o: Option, q: Vector, qd: Vector) -> tuple[Any, ...]:
    states = strut_states(tree, q, qd)
    return tuple(tuple(x[k] for x in states) for k in range(3))


def _wrenches(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    return (
        joint_wrenches(tree, rnea(tree, q, qd, qdd, external(tree, o, q, wrenches)), o.reference),
    )


def _every_wrench(
    tree: Tree,
    o: Option,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    multipliers: Vector,
    wrenches: Any = (),
) -> tuple[Any, ...]:
    """Wrenches of every joint, then of every loop."""
    loads = external(tree, o, q, wrenches) + loop_loads(tree, q, multipliers)
    recursion = rnea(tree, q, qd, qdd, loads)
    return (
        [
            *joint_wrenches(tree, recursion, o.reference),
            *loop_wrenches(tree, q, multipliers, o.reference),
        ],
    )


def _loose_wrenches(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    """Wrenches of every joint and loop caused by each combination of multipliers that no motion
    feels."""
    return (
        [
            [
                *joint_wrenches(tree, recursion, o.reference),
                *loop_wrenches(tree, q, multipliers, o.reference),
            ]
            for multipliers, recursion in loose_recursions(tree, q, partition_of(o))
        ],
    )


def _balance(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, reactions: Any, wrenches: Any = ()
) -> tuple[Any, ...]:
    """Residuals of the equations of all bodies under given reactions; poses and their rates are
    computed from q, q̇ and q̈ by truncated Taylor series in time."""
    rates = kinematics.position_rates(tree, q, qd)
    second = kinematics.position_rates(tree, seeded(q, rates), seeded(qd, qdd))
    jets = tuple(Jet(*x) for x in zip(q, rates, (slopes(x, 1)[0] for x in second), strict=True))
    world = kinematics.world_poses(tree, kinematics.joint_poses(tree, jets))
    moving = [Moving(*parts(pose)) for pose in world]
    return balance(tree, moving, reactions, tuple(zip(o.wrench_frames, wrenches, strict=True)))


def mass_by_columns(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of M, (..., column, row), by products of M and unit vectors."""
    (q,) = given
    return (fetch("mass_product")(q, np.eye(n), threads=threads),)


def _inverse_mass_by_columns(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """Columns of M⁻¹, (..., column, row), by inverting M."""
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


_WRENCH = "force, then moment (N, N m)"
_AXES = ("child",)

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
    "strut_states": Formula(
        ("q", "qd"),
        {
            "length": Output(("struts",), "length of each strut (m)"),
            "rate": Output(("struts",), "rate of its length (m/s)"),
            "tension": Output(
                ("struts",), "force with which it pulls its ends together; it pushes below 0 (N)"
            ),
        },
        _strut_states,
        touches=(),
    ),
    "joint_wrenches": Formula(
        ("q", "qd", "qdd", "wrenches"),
        one("W", ("nj", "six"), f"wrench of each joint on its body: {_WRENCH}"),
        _wrenches,
        axes=_AXES,
        chains="open",
        touches=INERTIAL,
    ),
    "closed_wrenches": Formula(
        ("q", "qd", "qdd", "multipliers", "wrenches"),
        one("W", ("reactions", "six"), f"wrench of each joint, then of each loop: {_WRENCH}"),
        _every_wrench,
        axes=_AXES,
        touches=INERTIAL,
    ),
    "loose_wrenches": Formula(
        ("q",),
        one(
            "W",
            ("loose", "reactions", "six"),
            f"wrenches that balance among themselves, of each joint and loop: {_WRENCH}",
        ),
        _loose_wrenches,
        axes=_AXES,
        chains="closed",
        settled="loops",
        touches=(),
    ),
    "balance": Formula(
        ("q", "qd", "qdd", "reactions", "wrenches"),
        {
            "force": Output(("nj", "dim"), "force that the balance of each body lacks (N)"),
            "moment": Output(("nj", "angular"), "moment that the balance of each body lacks (N m)"),
            "largest": Output((2,), "largest force and moment in any balance (N, N m)"),
        },
        _balance,
        touches=INERTIAL,
    ),
}
