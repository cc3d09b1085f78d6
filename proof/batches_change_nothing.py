"""A state has the same torques, bit for bit, alone, in a batch of 7 and in one of 100 000, with
one thread or two."""

import numpy as np

import freebody as fb

arm = fb.load("panda")
states = fb.random_state(arm, seed=10, batch=100_000)
all_at_once = fb.inverse_dynamics(arm, *states)
for k in range(0, 700, 7):
    few = fb.inverse_dynamics(arm, *(x[k : k + 7] for x in states))
    one = fb.inverse_dynamics(arm, *(x[k] for x in states))
    assert np.array_equal(few, all_at_once[k : k + 7])
    assert np.array_equal(one, all_at_once[k])
kernel = fb.kernel(arm, "inverse_dynamics")
assert np.array_equal(kernel(*states, threads=1), kernel(*states, threads=2))
print("100 single states, 100 batches of 7: equal to the last bit")
