"""Loop equations, what they do to the motion, and the wrenches in joints and loops of closed
chains."""

from __future__ import annotations

from functools import partial
from typing import Any

from freebody.algorithms import kinematics
from freebody.algorithms.loop_checks import closure_margins, sure
from freebody.algorithms.loop_constraints import (
    constrained_dynamics,
    constraint,
    constraint_bias,
    constraint_jacobian,
    constraint_rate,
    loop_loads,
    loop_wrenches,
)
from freebody.algorithms.loop_forces import drive_torques, loop_multipliers, loose_recursions
from freebody.algorithms.loop_rates import led, nearest
from freebody.algorithms.newton_euler_residuals import Moving, balance
from freebody.algorithms.rnea import joint_wrenches, rnea
from freebody.dual import slopes
from freebody.kernels.formulas.record import (
    Formula,
    Option,
    Output,
    external,
    one,
    partition_of,
    seeded,
)
from freebody.model.doubts import INERTIAL
from freebody.model.tree import Tree
from freebody.scalars.time_derivatives import Jet, parts
from freebody.spatial import Vector, sub, times


def _constrained(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    found = constrained_dynamics(tree, q, qd, tau, external(tree, o, q, wrenches), o.equations)
    return found.qdd, found.multipliers, found.pivots


def _velocity(tree: Tree, o: Option, q: Vector, x: Vector) -> tuple[Any, ...]:
    return _consistent(tree, o, q, None, x, (0.0,) * tree.constraints)


def _acceleration(tree: Tree, o: Option, q: Vector, qd: Vector, x: Vector) -> tuple[Any, ...]:
    return _consistent(tree, o, q, qd, x, constraint_bias(tree, q, qd))


def _consistent(
    tree: Tree, o: Option, q: Vector, qd: Vector | None, x: Vector, right: Vector
) -> tuple[Any, ...]:
    if o.held is None:
        found, margins = nearest(tree, q, x, right, partition_of(o))
    else:
        found, margins = led(tree, q, x, right, o.held, o.equations.rows if o.equations else ())
    return (sure(found, margins + (closure_margins(tree, q, qd) if o.checks == "state" else [])),)


def _jerk(tree: Tree, o: Option, q: Vector, qd: Vector, x: Vector) -> tuple[Any, ...]:
    """Φ's third derivative when q̈ = x and q⃛ = 0: affine in x. It tells how a mechanism goes on
    where Φ_q loses rank."""
    moved = seeded(q, kinematics.position_rates(tree, q, qd))
    second = sub(
        times(constraint_jacobian(tree, moved), x), constraint_bias(tree, moved, seeded(qd, x))
    )
    return (tuple(slopes(value, 1)[0] for value in second),)


def _wrenches(
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
    """Wrenches of every joint and loop by each combination of multipliers that no motion feels."""
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
    """Poses and their derivatives come from the positions' alone, by jets in time."""
    rates = kinematics.position_rates(tree, q, qd)
    second = kinematics.position_rates(tree, seeded(q, rates), seeded(qd, qdd))
    jets = tuple(Jet(*x) for x in zip(q, rates, (slopes(x, 1)[0] for x in second), strict=True))
    world = kinematics.world_poses(tree, kinematics.joint_poses(tree, jets))
    moving = [Moving(*parts(pose)) for pose in world]
    return balance(tree, moving, reactions, tuple(zip(o.wrench_frames, wrenches, strict=True)))


_WRENCH = "force, then moment (N, N m)"
_AXES = ("child",)

_by_loops = partial(Formula, chains="closed", settled="loops", touches=())
_geometric = partial(Formula, touches=())

FORMULAS = {
    "constraint": _geometric(
        ("q",),
        one(
            "Phi",
            ("constraints",),
            "loop equations, zero where the loops are closed (m, or no unit)",
        ),
        lambda t, o, q: (constraint(t, q),),
    ),
    "constraint_jacobian": _geometric(
        ("q",),
        one("Phi_q", ("constraints", "nv"), "derivative of the loop equations along the rates"),
        lambda t, o, q: (constraint_jacobian(t, q),),
    ),
    "constraint_bias": _geometric(
        ("q", "qd"),
        one("c", ("constraints",), "right-hand side of Phi_q qdd = c"),
        lambda t, o, q, qd: (constraint_bias(t, q, qd),),
    ),
    "constraint_rate": _geometric(
        ("q", "qd"),
        one("Phid", ("constraints",), "rate of the loop equations"),
        lambda t, o, q, qd: (constraint_rate(t, q, qd),),
    ),
    "constraint_jerk": _geometric(
        ("q", "qd", "x"),
        one("jerk", ("constraints",), "third derivative of the loop equations at accelerations x"),
        _jerk,
    ),
    "constrained_dynamics": Formula(
        ("q", "qd", "tau", "wrenches"),
        {
            "qdd": Output(("nv",), "accelerations (rad/s^2, m/s^2)"),
            "multipliers": Output(
                ("equations",), "one for each loop equation that counts (N, N m)"
            ),
            "pivots": Output(
                ("equations",), "pivots of the elimination: small ones near singular positions"
            ),
        },
        _constrained,
        lossless=True,
    ),
    "loop_velocity": _by_loops(
        ("q", "x"),
        one("qd", ("nv",), "rates nearest to x that keep the loops closed (rad/s, m/s)"),
        _velocity,
    ),
    "loop_acceleration": _by_loops(
        ("q", "qd", "x"),
        one(
            "qdd", ("nv",), "accelerations nearest to x that keep the loops closed (rad/s^2, m/s^2)"
        ),
        _acceleration,
    ),
    "drive_torques": _geometric(
        ("q", "x"),
        one(
            "tau",
            ("nv",),
            "torques and forces of the drives that do what x does at all joints (N m, N)",
        ),
        lambda t, o, q, x: (drive_torques(t, q, x, partition_of(o)),),
        chains="closed",
        settled="partition",
    ),
    "loop_multipliers": _by_loops(
        ("q", "x"),
        one("multipliers", ("constraints",), "one for each loop equation (N, N m)"),
        lambda t, o, q, x: (loop_multipliers(t, q, x, partition_of(o)),),
    ),
    "closed_wrenches": Formula(
        ("q", "qd", "qdd", "multipliers", "wrenches"),
        one("W", ("reactions", "six"), f"wrench of each joint, then of each loop: {_WRENCH}"),
        _wrenches,
        axes=_AXES,
        touches=INERTIAL,
    ),
    "loose_wrenches": _by_loops(
        ("q",),
        one(
            "W",
            ("loose", "reactions", "six"),
            f"wrenches that balance among themselves, of each joint and loop: {_WRENCH}",
        ),
        _loose_wrenches,
        axes=_AXES,
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
