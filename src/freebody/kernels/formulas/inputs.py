"""The inputs of all formulas, in the order in which a kernel takes them."""

from __future__ import annotations

from typing import NamedTuple

from freebody.kernels.formulas.record import Dimensions


class Input(NamedTuple):
    """An input of a formula: its dimensions, its meaning with units, and a usual size for inputs
    that must be positive."""

    dims: Dimensions
    meaning: str
    positive: float | None = None


INPUTS = {
    "q": Input(("nq",), "positions of the joints (rad, m; unit quaternions as w, x, y, z)"),
    "q0": Input(("nq",), "initial positions, as q"),
    "q1": Input(("nq",), "final positions, as q"),
    "qd": Input(
        ("nv",),
        "rates (rad/s, m/s; of free joints the velocity, then the angular velocity, body axes)",
    ),
    "qdd": Input(("nv",), "accelerations, rates of qd (rad/s^2, m/s^2)"),
    "v": Input(("nv",), "a displacement along the rates (rad, m)"),
    "tau": Input(("nv",), "torques and forces of the joints (N m, N)"),
    "x": Input(("nv",), "a vector along the rates"),
    "dq": Input(("nv",), "a direction along the rates (rad, m)"),
    "dqd": Input(("nv",), "a direction of the rates (rad/s, m/s)"),
    "multipliers": Input(("constraints",), "one for each loop equation (N, N m)"),
    "reactions": Input(
        ("reactions", "six"), "wrench of each joint, then of each loop: force, then moment (N, N m)"
    ),
    "point": Input(("dim",), "a point, world axes (m)"),
    "target": Input(("pose", "pose"), "pose to be reached, homogeneous matrix, world axes (m)"),
    "redundancy": Input(
        (), "position of the joint that is held: the last of seven, or the first (rad, m)"
    ),
    "h": Input((), "length of the step (s)", 1e-2),
    "q_ref": Input(("nq",), "reference positions of the feedback, as q"),
    "qd_ref": Input(("nv",), "reference rates of the feedback (rad/s, m/s)"),
    "qdd_ref": Input(("nv",), "reference accelerations (rad/s^2, m/s^2)"),
    "kp": Input(
        ("nv",), "position gains of the feedback (N m/rad, N/m; of computed torque 1/s^2)", 1.0
    ),
    "kd": Input(
        ("nv",), "rate gains of the feedback (N m s/rad, N s/m; of computed torque 1/s)", 1.0
    ),
    "pose_ref": Input(("pose", "pose"), "reference pose, homogeneous matrix, world axes (m)"),
    "V_ref": Input(("rows",), "reference velocity of the frame, world axes (m/s, rad/s)"),
    "A_ref": Input(("rows",), "reference acceleration of the frame, world axes (m/s^2, rad/s^2)"),
    "kp_task": Input(("rows",), "position gains of the motion of the frame (1/s^2)", 1.0),
    "kd_task": Input(("rows",), "rate gains of the motion of the frame (1/s)", 1.0),
    "tau_null": Input(("nv",), "torques of which acts what does not accelerate the frame (N m, N)"),
    "offset": Input(("rows",), "displacement from the reference (m, rad)"),
    "offset_rate": Input(("rows",), "rate of the displacement (m/s, rad/s)"),
    "w_ext": Input(("rows",), "measured wrench on the frame: force, then moment (N, N m)"),
    "inertia": Input(("rows",), "virtual inertia (kg, kg m^2)", 1.0),
    "stiffness": Input(("rows",), "stiffness of the motion of the frame (N/m, N m/rad)", 1.0),
    "damping": Input(("rows",), "damping of the motion of the frame (N s/m, N m s/rad)", 1.0),
    "integral": Input(("nv",), "what the observer remembers, at first M qd (kg m^2/s, kg m/s)"),
    "ko": Input(("nv",), "gains of the observer (1/s)", 1.0),
}
"""Inputs of formulas by name, all but the wrenches on frames, whose number a call says: wrench0,
wrench1, …, which come last."""

POSITIONS = tuple(name for name, given in INPUTS.items() if given.dims == ("nq",))
"""Inputs that are positions; a derivative by them is one along the rates."""
