"""Kinematics of frames and points."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.model.families import of_member
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.public_calls import JointVector, careful, checked_reference, evaluate

FrameAxes = Literal["world", "body"]


def forward_kinematics(model: Model, q: JointVector, frame: str | None = None) -> Array:
    """Pose T_WF of a frame in the world (2.10-2.13).

    Parameters
    ----------
    model : Model
    q : (..., nq)
        Positions, rad and m.
    frame : str, optional
        Name, default the tip.

    Returns
    -------
    (..., 4, 4)
        Lengths in m; (..., 3, 3) in the plane.

    Raises
    ------
    ShapeError, NotFiniteError, UnknownNameError
    """
    return evaluate(("forward_kinematics", frame), model, (q,), _of_frame)


def velocity(
    model: Model,
    q: JointVector,
    qd: JointVector,
    frame: str | None = None,
    point: ArrayLike | None = None,
) -> Array:
    """Velocity of a frame, or of a point fixed to it.

    Parameters
    ----------
    model : Model
    q, qd : (..., nq), (..., nv)
        Positions and rates, rad or m and s.
    frame : str, optional
        Name, default the tip.
    point : (..., dim), optional
        Fixed to the frame, in its axes (m); default its origin.

    Returns
    -------
    (..., 6)
        Linear (m/s) of the origin or point, then angular (rad/s), world axes. In the plane (...,
        3): ẋ, ẏ, ω.

    References
    ----------
    (2.16-2.18), (4.3), (6.16-6.19).
    """
    if point is None:
        return evaluate(("velocity", frame), model, (q, qd), _of_frame)
    return evaluate(("velocity", frame, "world", True), model, (q, qd, point), _of_frame)


def acceleration(
    model: Model,
    q: JointVector,
    qd: JointVector,
    qdd: JointVector,
    frame: str | None = None,
    point: ArrayLike | None = None,
) -> Array:
    """Acceleration of a frame, or of a point fixed to it: the time derivative of `velocity`.

    It is the acceleration of the point itself, not a spatial (Plücker) one.

    Parameters
    ----------
    model, q, qd, frame, point
        As for `velocity`.
    qdd : (..., nv)
        Accelerations of the joints, rad/s² and m/s².

    Returns
    -------
    (..., 6)
        Linear (m/s²), then angular (rad/s²), world axes; in the plane (..., 3).

    References
    ----------
    (2.24), (4.5), (6.20-6.22).
    """
    if point is None:
        return evaluate(("acceleration", frame), model, (q, qd, qdd), _of_frame)
    return evaluate(("acceleration", frame, "world", True), model, (q, qd, qdd, point), _of_frame)


def jacobian(
    model: Model, q: JointVector, frame: str | None = None, reference: FrameAxes = "world"
) -> Array:
    """Jacobian of a frame: its velocity is J q̇.

    Parameters
    ----------
    model : Model
    q : (..., nq)
        Positions, rad and m.
    frame : str, optional
        Name, default the tip.
    reference : "world" or "body"
        Axes of the rows: the world's, or those of the frame.

    Returns
    -------
    (..., 6, nv)
        Rows linear velocity of the frame's origin, then angular; (..., 3, nv) in the plane. The
        notes' planar J (2.19) is [..., :2, :].
    """
    return evaluate(("jacobian", frame, reference), model, (q,), _of_frame)


def jacobian_dot(
    model: Model,
    q: JointVector,
    qd: JointVector,
    frame: str | None = None,
    reference: FrameAxes = "world",
) -> Array:
    """Time derivative (..., 6, nv) of `jacobian` along qd (..., nv): acceleration = J qdd + J̇ qd
    (2.24)."""
    return evaluate(("jacobian_dot", frame, reference), model, (q, qd), _of_frame)


def jacobian_derivatives(
    model: Model, q: JointVector, frame: str | None = None, reference: FrameAxes = "world"
) -> Array:
    """∂J/∂q (..., 6, nv, nv), (..., 3, nv, nv) in the plane, the last axis the direction, on the
    tangent space.

    Arguments as for `jacobian`; `jacobian_dot` is its product with qd.
    """
    return evaluate(("jacobian_derivatives", frame, reference), model, (q,), _of_frame)


def center_of_mass(model: Model, q: JointVector) -> Array:
    """Centre of mass (..., dim) of all links, the base's included, in the world (m) (1.15).

    q: (..., nq). Raises SingularError without mass.
    """
    return evaluate("center_of_mass", model, (q,), None, None, _center_of_mass)


def _center_of_mass(
    function: str, model: Model, inputs: tuple[JointVector, ...], *_: None
) -> Array:
    require_model(function, model)
    nothing = np.argwhere(np.asarray(model.mass) == 0.0)
    if len(nothing):
        member = of_member(tuple(map(int, nothing[0])))
        raise SingularError(
            f"center_of_mass: {model.name!r} has no mass{member}; give its links an inertia."
        )
    return careful(function, model, inputs)


def _of_frame(
    model: Model, frame: str | None, reference: str = "world", point: bool = False
) -> Option:
    return Option(model.frame(frame).name, checked_reference(reference), point=point)
