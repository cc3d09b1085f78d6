"""More than ten million inverse dynamics of a UR5e a second, public function, new arrays and all
checks included, on one thread of this machine."""

import time

import freebody as fb

arm = fb.load("ur5e")
states = fb.random_state(arm, seed=12, batch=100_000)
fb.inverse_dynamics(arm, *states)
best = float("inf")
for _ in range(10):
    start = time.process_time()
    fb.inverse_dynamics(arm, *states)
    best = min(best, time.process_time() - start)
print(f"{0.1 / best:.0f} million a second")
assert best < 0.01
