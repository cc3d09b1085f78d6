"""Compiled code and NumPy evaluate a UR5e's forward dynamics alike, in 1000 random states: to 1e-12
of the largest acceleration."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
q, qd, tau = fb.random_state(arm, seed=7, batch=1000)
compiled = fb.kernel(arm, "forward_dynamics")(q, qd, tau)
interpreted = fb.kernel(arm, "forward_dynamics", target="numpy")(q, qd, tau)
worst = abs(compiled - interpreted).max() / abs(compiled).max()
print(f"largest difference {worst:.1e} of the largest acceleration")
assert np.isfinite(compiled).all()
assert worst < 1e-12
