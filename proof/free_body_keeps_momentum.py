"""A spinning quadrotor without gravity and thrust keeps its momentum and angular momentum over 10 s
of simulation, to 1e-7 of them, while it tumbles."""

import numpy as np

import freebody as fb

body = fb.load("quadrotor").replace(gravity=[0.0, 0.0, 0.0])
q = fb.neutral(body)
qd = np.array([0.3, -0.2, 0.1, 4.0, 0.3, 0.5])
flight = fb.simulate(body, q, qd, np.linspace(0, 10, 21))
momentum = fb.momentum(body, flight.q.values, flight.qd.values)
turned = abs(flight.q.values - q).max()
drift = abs(momentum - momentum[0]).max() / abs(momentum[0]).max()
print(f"drift {drift:.1e}")
assert turned > 0.5
assert drift < 1e-7
