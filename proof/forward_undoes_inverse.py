"""Forward dynamics of inverse dynamics gives back the accelerations of 100 000 states of a UR5e,
to 1e-9 of the largest."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
q, qd, qdd = fb.random_state(arm, seed=9, batch=100_000)
tau = fb.inverse_dynamics(arm, q, qd, qdd)
worst = np.abs(fb.forward_dynamics(arm, q, qd, tau) - qdd).max() / np.abs(qdd).max()
print(f"largest difference {worst:.1e} of the largest acceleration")
assert worst < 1e-9
