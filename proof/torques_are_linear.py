"""The torques of a UR5e, a Panda and a Puma are their regressors times their inertial parameters,
in 200 random states each: to 1e-11 of the largest torque."""

import numpy as np

import freebody as fb

worst = 0.0
for name in ("ur5e", "panda", "puma560"):
    arm = fb.load(name, physical="ignore")
    q, qd, qdd = fb.random_state(arm, seed=3, batch=200)
    tau = fb.inverse_dynamics(arm, q, qd, qdd)
    parameters = np.array(list(fb.inertial_parameters(arm).values()))
    by_regressor = fb.regressor(arm, q, qd, qdd) @ parameters
    worst = max(worst, abs(by_regressor - tau).max() / abs(tau).max())
print(f"largest difference {worst:.1e} of the largest torque")
assert worst < 1e-11
