"""A double pendulum without friction keeps its energy over 60 s of simulation, to 1e-8 of what it
exchanges."""

import numpy as np

import freebody as fb

arm = fb.load("2R").without("friction")
t = np.linspace(0, 60, 601)
run = fb.simulate(arm, [0.5, 1.0], [0.0, 0.0], t)
q, qd = run.q.values, run.qd.values
kinetic, potential = fb.kinetic_energy(arm, q, qd), fb.potential_energy(arm, q)
drift = np.ptp(kinetic + potential) / kinetic.max()
print(f"the energy changes by {drift:.1e} of the largest kinetic energy")
assert kinetic.max() > 10
assert drift < 1e-8
