"""A thousand UR5e with different payloads, computed at once, have the torques that each has alone:
to 1e-13 of the largest."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
masses = np.linspace(0, 5, 1000)
q, qd, qdd = fb.random_state(arm, seed=6, batch=1000)
together = fb.inverse_dynamics(arm.with_payload(masses), q, qd, qdd)
alone = np.array(
    [
        fb.inverse_dynamics(arm.with_payload(float(masses[k])), q[k], qd[k], qdd[k])
        for k in range(0, 1000, 10)
    ]
)
worst = abs(together[::10] - alone).max() / abs(alone).max()
print(f"largest difference {worst:.1e}")
assert np.ptp(masses) > 0
assert worst < 1e-13
