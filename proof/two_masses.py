"""A joint with a twisting shaft has the natural frequency of two masses and a spring, to 1e-12."""

import numpy as np

import freebody as fb

link = fb.planar("R", l=[1.0], lc=[0.0], m=[1.0], I=[2.0]).replace(gravity=[0.0, 0.0])
arm = link.with_drive("joint1", rotor=3e-4, gear=100).with_flexible_joint("joint1", stiffness=1e4)
found = np.sort(fb.natural_frequencies(arm, fb.neutral(arm)).frequencies.ravel())[-1]
expected = np.sqrt(1e4 * (1 / 2.0 + 1 / 3.0)) / (2 * np.pi)
print(f"{found:.6f} Hz, closed form {expected:.6f} Hz")
assert abs(found / expected - 1) < 1e-12
