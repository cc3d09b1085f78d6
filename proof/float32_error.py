"""Inverse dynamics of a UR5e with 32-bit numbers: the median error is below 5e-7 of a state's
largest torque."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
states = fb.random_state(arm, seed=15, batch=10_000)
exact = fb.inverse_dynamics(arm, *states)
rough = fb.kernel(arm, "inverse_dynamics", dtype="float32")(*states)
error = np.median(abs(rough - exact).max(axis=1) / abs(exact).max(axis=1))
print(f"median error {error:.1e}")
assert error < 5e-7
