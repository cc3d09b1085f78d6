"""The gradient of a torque through JAX equals freebody's own derivatives, to 1e-12."""

import jax
import numpy as np

import freebody as fb

jax.config.update("jax_enable_x64", True)
arm = fb.load("ur5e")
rnea = fb.to_jax(arm, "inverse_dynamics")
q, qd, qdd = fb.random_state(arm, seed=14)
J = np.asarray(jax.jacobian(rnea)(q, qd, qdd))
exact = fb.inverse_dynamics_derivatives(arm, q, qd, qdd)[0]
worst = abs(J - exact).max() / abs(exact).max()
print(f"largest difference {worst:.1e}")
assert worst < 1e-12
