"""Control laws and observers: the torques of the drives from the state and its reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, at_sample, refuse_not_finite
from freebody.errors import FreebodyError, PassiveJointError, listed
from freebody.kernels.formula_variants import motion_rows
from freebody.kernels.formulas import Option
from freebody.labels import aligned, is_labelled
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.dynamics import mass_matrix
from freebody.trees.operational_space import (
    as_it_is,
    operational_option,
    refuse_dependent_rows,
)
from freebody.trees.public_calls import JointVector, evaluate, labels, vector


def default_pd_gains(model: Model, q: JointVector) -> tuple[Array, Array]:
    """(kp, kd) (nv,) with which each coordinate alone, with its inertia m at q, returns to its goal
    at 10 rad/s, critically damped: 100 m and 20 m."""
    inertia = np.diagonal(mass_matrix(model, q))
    return _RATE**2 * inertia, 2.0 * _RATE * inertia


_RATE = 10.0  # rad/s


def pd_gravity(
    model: Model,
    q: JointVector,
    qd: JointVector,
    q_ref: JointVector,
    kp: JointVector,
    kd: JointVector,
) -> Array:
    """PD control with gravity compensation: tau = g + springs + kp (q_ref ⊖ q) - kd q̇.

    With kp and kd above 0 the robot comes to rest at q_ref alone. `fb.simulate` and `fb.export`
    take `fb.kernel(model, "pd_gravity")`.

    Parameters
    ----------
    model : Model
    q, q_ref : (..., nq)
        Positions, rad and m; q_ref ⊖ q is `fb.difference(model, q, q_ref)`.
    qd : (..., nv)
        Rates, rad/s and m/s.
    kp, kd : (..., nv) or one number for all joints
        At least 0; N m/rad, N m s/rad and N/m, N s/m.

    Returns
    -------
    (..., nv)
        N m and N.

    Raises
    ------
    PassiveJointError, ShapeError, NotFiniteError
    FreebodyError
        A negative gain.

    References
    ----------
    Takegaki and Arimoto 1981.
    """
    _require_drives("pd_gravity", model)
    gains = [_gain("pd_gravity", model, name, x) for name, x in (("kp", kp), ("kd", kd))]
    return evaluate("pd_gravity", model, (q, qd, q_ref, *gains))


def computed_torque(
    model: Model,
    q: JointVector,
    qd: JointVector,
    q_ref: JointVector,
    qd_ref: JointVector,
    qdd_ref: JointVector,
    kp: JointVector,
    kd: JointVector,
) -> Array:
    """Computed torque M (q̈_ref + kd ė + kp e) + c + g + friction + springs, so that ë + kd ė + kp
    e = 0.

    e = q_ref ⊖ q (`fb.difference(model, q, q_ref)`), ė = qd_ref - qd. Dry friction is
    compensated with the sign of q̇. As a kernel: `fb.kernel(model, "computed_torque")`.

    Parameters
    ----------
    model : Model
    q, q_ref : (..., nq)
        Positions, rad and m.
    qd, qd_ref, qdd_ref : (..., nv)
        Rates and accelerations.
    kp, kd : (..., nv) or one number for all joints
        1/s² and 1/s, at least 0; kd = 2 √kp is critical damping.

    Returns
    -------
    (..., nv)
        N m and N.

    Raises
    ------
    PassiveJointError, ShapeError, NotFiniteError, FreebodyError
        As `pd_gravity` does.

    References
    ----------
    Luh, Walker, Paul 1980.
    """
    _require_drives("computed_torque", model)
    gains = [_gain("computed_torque", model, name, x) for name, x in (("kp", kp), ("kd", kd))]
    return evaluate("computed_torque", model, (q, qd, q_ref, qd_ref, qdd_ref, *gains))


def operational_space_control(
    model: Model,
    q: JointVector,
    qd: JointVector,
    pose_ref: ArrayLike,
    V_ref: JointVector,
    A_ref: JointVector,
    kp_task: JointVector,
    kd_task: JointVector,
    tau_null: JointVector | None = None,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
) -> Array:
    """Torques with which a frame's motion has ë + kd ė + kp e = 0, by inverse dynamics in
    operational space.

    e is what the origin lacks, then the rotation vector of the rotation that is missing, at most π.

    Parameters
    ----------
    model : Model
    q, qd : (..., nq), (..., nv)
        Positions and rates, rad or m and s.
    pose_ref : (..., 4, 4)
        Pose of the frame, in the plane (..., 3, 3).
    V_ref, A_ref : (..., r)
        Velocity and acceleration, of the rows of the frame's motion, m and rad, world axes.
    kp_task, kd_task : (..., r) or one number
        1/s² and 1/s, at least 0.
    tau_null : (..., nv), optional
        N m and N, projected so that it does not accelerate the frame (such as a damping of a
        redundant arm's joints); default 0.
    frame : str, optional
        Name, default the tip.
    rows : names, optional
        Among "vx", "vy", "vz", "wx", "wy", "wz" (plane: "vx", "vy", "w"); default all.

    Returns
    -------
    (..., nv)
        N m and N.

    Raises
    ------
    SingularError
        The frame cannot move along all rows.
    PassiveJointError, ShapeError, NotFiniteError, FreebodyError
        As `pd_gravity` does.

    References
    ----------
    Khatib 1987.
    """
    function = "operational_space_control"
    _require_drives(function, model)
    pose = _pose(function, model, pose_ref)
    option = operational_option(model, frame, rows, function)
    refuse_dependent_rows(function, model, q, option)
    aims = [
        _of_rows(function, model, option, n, x) for n, x in (("V_ref", V_ref), ("A_ref", A_ref))
    ]
    gains = [
        _gain_of_rows(function, model, option, name, x)
        for name, x in (("kp_task", kp_task), ("kd_task", kd_task))
    ]
    null = np.zeros(model.nv) if tau_null is None else tau_null
    return evaluate((function, option), model, (q, qd, pose, *aims, *gains, null), as_it_is)


def impedance(
    model: Model,
    q: JointVector,
    qd: JointVector,
    pose_ref: ArrayLike,
    V_ref: JointVector,
    stiffness: JointVector,
    damping: JointVector,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
) -> Array:
    """Torques (..., nv) that put a spring and a damper between a frame and its reference: tau = g +
    springs + Jᵀ (stiffness e + damping (V_ref - V)).

    pose_ref, V_ref, e, frame, rows: as for `operational_space_control`. stiffness (N/m, N m/rad),
    damping (N s/m, N m s/rad): (..., r) or one number, at least 0. The robot's inertia stays as it
    is; at rest a wrench w on the frame moves it until stiffness e = -w. Joints that do not move the
    rows are held by nothing. Raises as `pd_gravity`. Source: Hogan 1985.
    """
    function = "impedance"
    _require_drives(function, model)
    option = Option(model.frame(frame).name, rows=motion_rows(model, rows))
    aim = _of_rows(function, model, option, "V_ref", V_ref)
    gains = [
        _gain_of_rows(function, model, option, name, x)
        for name, x in (("stiffness", stiffness), ("damping", damping))
    ]
    pose = _pose(function, model, pose_ref)
    return evaluate((function, option), model, (q, qd, pose, aim, *gains), as_it_is)


def admittance(
    model: Model,
    h: float,
    offset: JointVector,
    offset_rate: JointVector,
    w_ext: JointVector,
    inertia: JointVector,
    stiffness: JointVector,
    damping: JointVector,
    rows: Sequence[str] | None = None,
) -> tuple[Array, Array]:
    """(offset, rate) after h seconds, each (..., r), of inertia ẍ + damping ẋ + stiffness x =
    w_ext: how far a measured wrench displaces the reference.

    offset (m, rad), offset_rate: (..., r), of the rows of a frame's motion; both 0 at the start.
    w_ext: (..., r), N and N m, world axes. inertia (kg, kg m²), above 0, stiffness, damping, at
    least 0: (..., r) or one number. By the trapezoidal rule, stable for every h. The reference that
    a position controller follows is the given one displaced by the offset. Raises FreebodyError,
    ShapeError, NotFiniteError.
    """
    function = "admittance"
    require_model(function, model)
    option = Option(rows=motion_rows(model, rows))
    state = [
        _of_rows(function, model, option, name, x)
        for name, x in (("offset", offset), ("offset_rate", offset_rate), ("w_ext", w_ext))
    ]
    gains = [
        _gain_of_rows(function, model, option, name, x)
        for name, x in (("inertia", inertia), ("stiffness", stiffness), ("damping", damping))
    ]
    if not (gains[0] > 0.0).all():
        raise FreebodyError(f"{function}: inertia must be above 0; without it nothing is defined.")
    inputs = (_step(function, h), *state, *gains)
    return evaluate((function, option), model, inputs, as_it_is)


def momentum_observer(
    model: Model,
    q: JointVector,
    qd: JointVector,
    tau: JointVector,
    h: float,
    integral: JointVector,
    ko: JointVector,
) -> tuple[Array, Array]:
    """(r, integral), each (..., nv): the torque that acts in addition to tau, by the generalized
    momentum, and the integral to pass to the next call.

    Called every h seconds with the state, and the torque tau (..., nv) that acted since the last
    call; integral: at first `fb.kernel(model, "mass_product")(q, qd)`, the momentum, 0 at rest. r
    follows the torque of a collision, a load or friction that the model lacks as ṙ = ko (tau_ext -
    r), without measured accelerations. ko (1/s): (..., nv) or one number, at least 0. Raises
    FreebodyError, ShapeError, NotFiniteError. Source: De Luca and Mattone 2003.
    """
    require_model("momentum_observer", model)
    gain = _gain("momentum_observer", model, "ko", ko)
    inputs = (q, qd, tau, _step("momentum_observer", h), integral, gain)
    return evaluate("momentum_observer", model, inputs)


def _require_drives(function: str, model: Model) -> None:
    require_model(function, model)
    model.require_tree(function)
    if model.passive_names:
        raise PassiveJointError(
            f"{function}: nothing drives {listed(model.passive_names)} of {model.name!r}; the law "
            f"needs a drive in every joint."
        )


def _step(function: str, h: float) -> Array:
    step = as_floats(function, "h", h)
    if not (step > 0.0).all():
        raise FreebodyError(f"{function}: h is {h}, expected seconds above 0.")
    return step


def _gain(function: str, model: Model, name: str, value: Any) -> Array:
    """A gain as one number for each coordinate; refuses negative ones."""
    given = value if is_labelled(value) else as_floats(function, name, value)
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = np.full(model.nv, given)
    array = vector(function, model, name, given)
    return not_negative(function, name, array, labels(model, name))


def _gain_of_rows(function: str, model: Model, option: Option, name: str, value: Any) -> Array:
    given = value if is_labelled(value) else as_floats(function, name, value)
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = np.full(len(option.rows), given)
    array = _of_rows(function, model, option, name, given)
    return not_negative(function, name, array, _row_names(model, option))


def not_negative(function: str, name: str, array: Array, names: Sequence[str]) -> Array:
    """The gains (..., len(names)), checked not to be negative."""
    bad = np.argwhere(array < 0.0)
    if len(bad):
        *sample, k = map(int, bad[0])
        raise FreebodyError(
            f"{function}: {name} is {array[tuple(bad[0])]:g} for {names[k]!r}{at_sample(sample)}; "
            f"a negative gain drives away from the reference: expected at least 0."
        )
    return array


def _of_rows(function: str, model: Model, option: Option, name: str, value: Any) -> Array:
    """A vector with an entry for each chosen row, in their order."""
    names = _row_names(model, option, "f" if name == "w_ext" else "v")
    given = aligned(function, name, value, names, ("component", "axis"))
    return vector(function, model, name, given, option)


def _row_names(model: Model, option: Option, letter: str = "v") -> tuple[str, ...]:
    """Names of the rows of a velocity or, with the letter f, of a wrench."""
    turn = "m" if letter == "f" else "w"
    axes = ("x", "y", "z")[: model.dim]
    linear = tuple(f"{letter}{axis}" for axis in axes)
    angular = (turn,) if model.dim == 2 else tuple(f"{turn}{axis}" for axis in axes)
    names = linear + angular
    return tuple(names[r] for r in option.rows)


def _pose(function: str, model: Model, value: ArrayLike) -> Array:
    """Homogeneous matrices, checked to contain rotations."""
    pose, d = vector(function, model, "pose_ref", value), model.dim
    refuse_not_finite(function, "pose_ref", pose, 2)
    R, last = pose[..., :d, :d], np.eye(d + 1)[d]
    gram = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(d)).max(axis=(-1, -2), initial=0.0)
    sound = (gram < _ROUNDED) & (np.linalg.det(R) > 0.0) & (pose[..., d, :] == last).all(axis=-1)
    if not sound.all():
        sample = tuple(map(int, np.argwhere(~sound)[0]))
        raise FreebodyError(
            f"{function}: pose_ref{at_sample(sample)} is no pose: expected a homogeneous matrix of "
            f"a rotation (R Rᵀ = 1, det R = 1) with the last row {last.astype(int).tolist()}, as "
            f"fb.forward_kinematics returns."
        )
    return pose


_ROUNDED = 1e-6
"""Error that a rotation of six digits may have."""
