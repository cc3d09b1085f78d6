"""The forward dynamics of a UR5e and an iiwa equal Pinocchio's, to 1e-9 of the largest
acceleration, in 200 random states each."""

import numpy as np
import pinocchio as pin

import freebody as fb

worst = 0.0
for name in ("ur5e", "iiwa14"):
    arm = fb.load(name).without("friction", "rotors")
    fb.save(arm, f"{name}.urdf", lossy=True)
    theirs = pin.buildModelFromUrdf(f"{name}.urdf")
    data = theirs.createData()
    q, qd, tau = fb.random_state(arm, seed=2, batch=200)
    qdd = np.array([pin.aba(theirs, data, *row) for row in zip(q, qd, tau, strict=True)])
    worst = max(worst, abs(fb.forward_dynamics(arm, q, qd, tau) - qdd).max() / abs(qdd).max())
print(f"largest difference {worst:.1e} of the largest acceleration")
assert worst < 1e-9
