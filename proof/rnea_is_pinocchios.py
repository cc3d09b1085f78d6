"""The inverse dynamics of a UR5e, a Panda, an iiwa and a Puma equal Pinocchio's, to 1e-11 of the
largest torque, in 200 random states each."""

import numpy as np
import pinocchio as pin

import freebody as fb

worst = 0.0
for name in ("ur5e", "panda", "iiwa14", "puma560"):
    arm = fb.load(name, mimic="free", physical="ignore").without("friction", "rotors")
    fb.save(arm, f"{name}.urdf", lossy=True)
    theirs = pin.buildModelFromUrdf(f"{name}.urdf")
    data = theirs.createData()
    q, qd, qdd = fb.random_state(arm, seed=1, batch=200)
    tau = np.array([pin.rnea(theirs, data, *row) for row in zip(q, qd, qdd, strict=True)])
    worst = max(worst, abs(fb.inverse_dynamics(arm, q, qd, qdd) - tau).max() / abs(tau).max())
print(f"largest difference {worst:.1e} of the largest torque")
assert worst < 1e-11
