"""A pendulum released at 150° swings with the period that elliptic integrals give, to 1e-8."""

import numpy as np
from scipy.special import ellipk

import freebody as fb

pendulum = fb.planar("R", l=[1.0], lc=[0.7], m=[2.0], I=[0.1])
start = np.radians(150)
omega = np.sqrt(2.0 * 9.81 * 0.7 / (0.1 + 2.0 * 0.7**2))
period = 4 * ellipk(np.sin(start / 2) ** 2) / omega
run = fb.simulate(pendulum, [start - np.pi / 2], [0.0], [0.0, period / 2, period])
error = abs(run.q.values[-1, 0] - (start - np.pi / 2))
opposite = abs(run.q.values[1, 0] - (-start - np.pi / 2))
print(f"after one period {error:.1e} rad from the start, after half of it {opposite:.1e}")
assert max(error, opposite) < 1e-8
