"""The torques of a Puma 560 without rotors depend on 36 combinations of its inertial parameters,
by the regrouping along the tree and by the rank of the regressors of 400 random states."""

import numpy as np

import freebody as fb

arm = fb.load("puma560", physical="ignore").without("friction", "rotors")
base = fb.base_parameters(arm)
Y = fb.regressor(arm, *fb.random_state(arm, seed=6, batch=400))
Y = Y.reshape(-1, Y.shape[-1])
rank = np.linalg.matrix_rank(Y, tol=1e-9 * np.linalg.norm(Y))
print(f"rank {rank}, regrouped {len(base.names)}")
assert rank == len(base.names) == 36
