"""Formulas of closed chains: loop equations, the rates and accelerations that they allow, and the
loops' effect on motion and drives."""

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
)
from freebody.algorithms.loop_forces import drive_torques, loop_multipliers
from freebody.algorithms.loop_rates import led, nearest
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
from freebody.model.tree import Tree
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
    """The third time derivative of Φ for q̈ = x and zero jerk, which is affine in x; it shows how a
    mechanism moves on where Φ_q loses rank."""
    moved = seeded(q, kinematics.position_rates(tree, q, qd))
    second = sub(
        times(constraint_jacobian(tree, moved), x), constraint_bias(tree, moved, seeded(qd, x))
    )
    return (tuple(slopes(value, 1)[0] for value in second),)


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
}
