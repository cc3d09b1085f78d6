"""The quickest move of a joint by 1.2 rad from rest to rest, within 3 rad/s² and no limit of speed
that counts, lasts 2 √(d/a), as `fb.trapezoid` plans it: to 1e-12 s."""

import numpy as np

import freebody as fb

arm = fb.planar("R", l=[1.0], lc=[0.5], m=[1.0], I=[0.1])
motion = fb.trapezoid(arm, [[0.0], [1.2]], velocity=100.0, acceleration=3.0)
expected = 2 * np.sqrt(1.2 / 3.0)
print(f"{motion.duration:.12f} s, closed form {expected:.12f} s")
assert abs(motion.duration - expected) < 1e-12
