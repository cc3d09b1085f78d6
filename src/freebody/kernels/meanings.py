"""What the inputs and outputs of formulas are, in words with units: for whoever reads a text without its model."""

from __future__ import annotations

INPUTS = {
    "q": "positions of the joints (rad, m; unit quaternions as w, x, y, z)",
    "q0": "positions to begin with, as q",
    "q1": "positions to end with, as q",
    "qd": "rates (rad/s, m/s; of free joints the velocity, then the angular velocity, body axes)",
    "qdd": "rates of qd (rad/s^2, m/s^2)",
    "v": "a displacement along the rates (rad, m)",
    "tau": "torques and forces of the joints (N m, N)",
    "x": "a vector along the rates",
    "dq": "a direction along the rates (rad, m)",
    "dqd": "a direction of the rates (rad/s, m/s)",
    "multipliers": "one for each loop equation (N, N m)",
    "h": "length of the step (s)",
    "q_ref": "positions that the feedback leads to, as q",
    "qd_ref": "rates that the feedback leads to (rad/s, m/s)",
    "kp": "feedback by position (N m/rad, N/m)",
    "kd": "feedback by rate (N m s/rad, N s/m)",
    "reactions": "wrench of each joint, then of each loop: force, then moment (N, N m)",
    "p": "numbers of the robot, listed below (SI units)",
    "point": "a point, world axes (m)",
}
"""By name; wrench0, wrench1, … are worded where their frames are known."""

_WRENCH = "force, then moment (N, N m)"
_STEP = {"q1": "positions at the end of the step, as q", "qd1": "rates at the end of the step, as qd"}
_BY_Q, _BY_QD = "by q (N m/rad, ...)", "by qd (N m s/rad, ...)"
OUTPUTS = {
    "forward_kinematics": {"T": "pose of the frame in the world, homogeneous matrix (m)"},
    "velocity": {"V": "velocity of the point, then angular velocity (m/s, rad/s)"},
    "acceleration": {"A": "acceleration of the point, then angular acceleration (m/s^2, rad/s^2)"},
    "jacobian": {"J": "Jacobian of the frame: rows linear, then angular"},
    "jacobian_dot": {"Jd": "rate of the Jacobian"},
    "center_of_mass": {"com": "centre of mass in the world (m)"},
    "inverse_dynamics": {"tau": "torques and forces of the joints (N m, N)"},
    "forward_dynamics": {"qdd": "accelerations (rad/s^2, m/s^2)"},
    "mass_matrix": {"M": "mass matrix (kg m^2, kg)"},
    "coriolis_matrix": {"C": "Coriolis matrix (N m s/rad, N s/m)"},
    "bias": {"bias": "torques at zero accelerations (N m, N)"},
    "gravity_torque": {"g": "torques that hold against gravity (N m, N)"},
    "static_torque": {"tau": "torques that hold the robot still (N m, N)"},
    "joint_wrenches": {"W": f"wrench of each joint on its body: {_WRENCH}"},
    "inverse_dynamics_derivatives": {
        "dtau_dq": f"derivative of tau {_BY_Q}",
        "dtau_dqd": f"derivative of tau {_BY_QD}",
        "M": "derivative of tau by qdd: the mass matrix (kg m^2, kg)",
    },
    "forward_dynamics_derivatives": {
        "dqdd_dq": "derivative of the accelerations by q (1/s^2, ...)",
        "dqdd_dqd": "derivative of the accelerations by qd (1/s, ...)",
        "Minv": "derivative of the accelerations by tau: the inverse mass matrix (1/(kg m^2), 1/kg)",
    },
    "inverse_dynamics_second_derivatives": {
        "d2tau_dq_dq": "second derivative of tau by q and q",
        "d2tau_dqd_dq": "second derivative of tau by qd and q",
        "d2tau_dqd_dqd": "second derivative of tau by qd and qd",
        "dM_dq": "derivative of the mass matrix by q",
    },
    "jacobian_derivatives": {"dJ_dq": "derivative of the Jacobian by q"},
    "forward_dynamics_parameter_derivatives": {
        "dqdd_dpi": "derivative of the accelerations by the inertial parameters"
    },
    "mass_product": {"Mx": "mass matrix times x"},
    "coriolis_product": {"Cx": "Coriolis matrix times x"},
    "inverse_dynamics_along": {"dtau": "change of tau along the direction (N m, N)"},
    "mass_matrix_inverse": {"Minv": "inverse of the mass matrix (1/(kg m^2), 1/kg)"},
    "operational_space_inertia": {"Lambda": "inertia of the motion of the frame (kg, kg m, kg m^2)"},
    "operational_space_bias": {"mu": f"bias of the motion of the frame: {_WRENCH}"},
    "centroidal_momentum_matrix": {"A": "momentum about the centre of mass by rates (kg m, kg m^2)"},
    "regressor": {"Y": "torques by inertial parameters"},
    "energy_regressor": {"E": "kinetic, then potential energy by inertial parameters"},
    "integrate": {"q1": "positions after the displacement"},
    "difference": {"v": "displacement from q0 to q1 (rad, m)"},
    "semi_implicit_step": _STEP,
    "rk4_step": _STEP,
    "implicit_step": _STEP,
    "implicit_feedback_step": _STEP,
    "balance": {
        "force": "force that the balance of each body lacks (N)",
        "moment": "moment that the balance of each body lacks (N m)",
        "largest": "largest force and moment in any balance (N, N m)",
    },
    "constraint": {"Phi": "loop equations, zero where the loops are closed (m, or no unit)"},
    "constraint_jacobian": {"Phi_q": "derivative of the loop equations along the rates"},
    "constraint_bias": {"c": "right-hand side of Phi_q qdd = c"},
    "constraint_rate": {"Phid": "rate of the loop equations"},
    "constraint_jerk": {"jerk": "third derivative of the loop equations at accelerations x"},
    "constrained_dynamics": {
        "qdd": "accelerations (rad/s^2, m/s^2)",
        "multipliers": "one for each loop equation that counts (N, N m)",
        "pivots": "pivots of the elimination: small ones near singular positions",
    },
    "drive_torques": {"tau": "torques and forces of the drives that do what x does at all joints (N m, N)"},
    "loop_multipliers": {"multipliers": "one for each loop equation (N, N m)"},
    "loose_wrenches": {"W": f"wrenches that balance among themselves, of each joint and loop: {_WRENCH}"},
    "closed_wrenches": {"W": f"wrench of each joint, then of each loop: {_WRENCH}"},
    "kinetic_energy": {"T": "kinetic energy (J)"},
    "potential_energy": {"V": "potential energy (J)"},
    "momentum": {"h": "linear, then angular momentum (kg m/s, kg m^2/s)"},
}
"""By formula and output."""
