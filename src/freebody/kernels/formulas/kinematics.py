"""Formulas of kinematics: poses of frames, their motion, and positions moved along rates."""

from __future__ import annotations

from functools import partial
from typing import Any

from freebody.algorithms import inverse_rates, kinematics
from freebody.dual import slopes
from freebody.kernels.formulas.record import (
    Formula,
    Option,
    frame_of,
    one,
    still,
)
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.tree import Tree
from freebody.spatial import Vector


def _pose(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    R, p = kinematics.frame_pose_at(tree, q, frame_of(o))
    last = (0.0,) * tree.space.dim + (1.0,)
    return ((*((*row, x) for row, x in zip(R, p, strict=True)), last),)


def _velocity(
    tree: Tree, o: Option, q: Vector, qd: Vector, point: Vector | None = None
) -> tuple[Any, ...]:
    motion = kinematics.outward(tree, q, qd, still(tree))
    (w, v), _ = kinematics.frame_motion(tree, motion, frame_of(o), point)
    return (v + w,)


def _acceleration(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, point: Vector | None = None
) -> tuple[Any, ...]:
    _, (wd, vd) = kinematics.frame_motion(
        tree, kinematics.outward(tree, q, qd, qdd), frame_of(o), point
    )
    return (vd + wd,)


def _jacobian(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    return (kinematics.jacobian(tree, q, frame_of(o), o.reference),)


def _jacobian_dot(tree: Tree, o: Option, q: Vector, qd: Vector) -> tuple[Any, ...]:
    return (kinematics.jacobian_dot(tree, q, qd, frame_of(o), o.reference),)


def _jacobian_by_position(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    """Derivatives of every entry of the Jacobian along every direction of q."""
    J = kinematics.jacobian(
        tree, kinematics.along_every_direction(tree, q), frame_of(o), o.reference
    )
    return (tuple(tuple(slopes(x, tree.nv) for x in row) for row in J),)


_AXES = ("body",)

_along_rows = partial(
    Formula, of_frame=True, of_rows=True, free_rows=True, chains="open", touches=()
)
_in_axes = partial(Formula, of_frame=True, axes=_AXES, touches=())
_of_frame = partial(Formula, of_frame=True, touches=())

FORMULAS = {
    "forward_kinematics": _of_frame(
        ("q",),
        one("T", ("pose", "pose"), "pose of the frame in the world, homogeneous matrix (m)"),
        _pose,
    ),
    "velocity": _of_frame(
        ("q", "qd", "point"),
        one("V", ("six",), "velocity of the point, then angular velocity (m/s, rad/s)"),
        _velocity,
    ),
    "acceleration": _of_frame(
        ("q", "qd", "qdd", "point"),
        one("A", ("six",), "acceleration of the point, then angular acceleration (m/s^2, rad/s^2)"),
        _acceleration,
    ),
    "jacobian": _in_axes(
        ("q",),
        one("J", ("six", "nv"), "Jacobian of the frame: rows linear, then angular"),
        _jacobian,
    ),
    "jacobian_dot": _in_axes(
        ("q", "qd"),
        one("Jd", ("six", "nv"), "rate of the Jacobian"),
        _jacobian_dot,
    ),
    "jacobian_derivatives": _in_axes(
        ("q",),
        one("dJ_dq", ("six", "nv", "nv"), "derivative of the Jacobian with respect to q"),
        _jacobian_by_position,
    ),
    "inverse_velocity": _along_rows(
        ("q", "V_ref"),
        one(
            "qd",
            ("nv",),
            "rates of least norm that move the frame so; NaN next to a singularity (rad/s, m/s)",
        ),
        lambda t, o, q, V_ref: (inverse_rates.inverse_velocity(t, q, frame_of(o), o.rows, V_ref),),
    ),
    "inverse_acceleration": _along_rows(
        ("q", "qd", "A_ref"),
        one(
            "qdd",
            ("nv",),
            "accelerations of least norm that move the frame so; NaN next to a singularity "
            "(rad/s^2, m/s^2)",
        ),
        lambda t, o, q, qd, A_ref: (
            inverse_rates.inverse_acceleration(t, q, qd, frame_of(o), o.rows, A_ref),
        ),
    ),
    "tip_wrench": _of_frame(
        ("q", "tau"),
        one(
            "wrench",
            ("six",),
            "force, then moment of the frame on its surroundings with torques tau alone; NaN next "
            "to a singularity (N, N m)",
        ),
        lambda t, o, q, tau: (inverse_rates.tip_wrench(t, q, frame_of(o), tau),),
        chains="square",
    ),
    "center_of_mass": Formula(
        ("q",),
        one("com", ("dim",), "centre of mass in the world (m)"),
        lambda t, o, q: (kinematics.centre_of_mass(t, q),),
        touches=(MASSES,),
    ),
    "integrate": Formula(
        ("q", "v"),
        one("q1", ("nq",), "positions after the displacement"),
        lambda t, o, q, v: (kinematics.moved(t, q, v),),
        touches=(),
    ),
    "difference": Formula(
        ("q0", "q1"),
        one("v", ("nv",), "displacement from q0 to q1 (rad, m)"),
        lambda t, o, q0, q1: (kinematics.between(t, q0, q1),),
        touches=(),
    ),
}
