"""The derivatives of a UR5e's inverse dynamics, by positions, rates and accelerations, equal
Pinocchio's, to 1e-11 of their largest entry."""

import numpy as np
import pinocchio as pin

import freebody as fb

arm = fb.load("ur5e").without("friction")
fb.save(arm, "ur5e.urdf")
theirs = pin.buildModelFromUrdf("ur5e.urdf")
data = theirs.createData()
q, qd, qdd = fb.random_state(arm, seed=3, batch=100)
worst = 0.0
for k, found in enumerate(zip(*fb.inverse_dynamics_derivatives(arm, q, qd, qdd), strict=True)):
    pin.computeRNEADerivatives(theirs, data, q[k], qd[k], qdd[k])
    M = np.triu(data.M) + np.triu(data.M, 1).T
    for mine, other in zip(found, (data.dtau_dq, data.dtau_dv, M), strict=True):
        worst = max(worst, abs(mine - other).max() / abs(other).max())
print(f"largest difference {worst:.1e} of the largest entry")
assert worst < 1e-11
