"""The gravity torques of a Puma 560 in its nominal pose are those that the Robotics Toolbox prints,
0, 31.64, 6.035, 0, 0.02825 and 0 N m, to their digits."""

import numpy as np

import freebody as fb

arm = fb.load("puma560", physical="ignore")
nominal = [0, np.pi / 4, np.pi, 0, np.pi / 4, 0]
found = fb.gravity_torque(arm, nominal)
print(found.round(5).tolist())
assert np.allclose(found, [0, 31.64, 6.035, 0, 0.02825, 0], rtol=0, atol=6e-3)
assert abs(found[4] - 0.02825) < 6e-6
