"""The time-optimal motion of a UR5e along a spline, within limits of speed and torque, takes as
long as TOPP-RA's on a grid of 2000 points, to a thousandth."""

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from scipy.interpolate import CubicSpline

import freebody as fb

arm = fb.load("ur5e")
points = [[0, -1.6, 1.4, 0, 0, 0], [0.8, -1.2, 0.9, 0.5, 0.3, 0], [1.5, -1.5, 1.3, 0, 0.5, 0.4]]
path = CubicSpline(np.linspace(0, 1, 3), np.array(points), bc_type="natural")
mine = fb.time_optimal(arm, path).t[-1]


def both(limit: np.ndarray) -> np.ndarray:
    return np.stack([-limit, limit], axis=-1)


scheme = toppra.constraint.DiscretizationType.Interpolation
limits = [
    toppra.constraint.JointVelocityConstraint(both(arm.limits.velocity)),
    toppra.constraint.JointTorqueConstraint(
        lambda *state: fb.inverse_dynamics(arm, *state),
        both(arm.limits.effort),
        np.zeros(6),
        discretization_scheme=scheme,
    ),
]
curve = toppra.SplineInterpolator(path.x, path(path.x), bc_type="natural")
s = np.linspace(0, 1, 2001)
_, speed, _ = toppra.algorithm.TOPPRA(limits, curve, gridpoints=s).compute_parameterization(0, 0)
theirs = np.sum(2 * np.diff(s) / (speed[1:] + speed[:-1]))
print(f"{mine:.4f} s, TOPP-RA {theirs:.4f} s")
assert abs(mine / theirs - 1) < 1e-3
