"""The six forces that hold a Stewart platform do the work that its weight gives up, for random
small motions of the platform: to 1e-6 of that work."""

import numpy as np

import freebody as fb

robot = fb.load("stewart")
q = fb.assemble(robot)
legs = fb.static_torque(robot, q)
rng = np.random.default_rng(13)
worst = 0.0
for _ in range(10):
    v = fb.loop_velocity(robot, q, dict(zip(robot.driven_names, rng.normal(size=6), strict=True)))
    h = 1e-5
    up, down = (fb.potential_energy(robot, fb.integrate(robot, q, s * h * v)) for s in (1, -1))
    rate = (up - down) / (2 * h)
    worst = max(worst, abs(legs @ v - rate) / abs(rate))
print(f"largest difference {worst:.1e} of the work")
assert worst < 1e-6
