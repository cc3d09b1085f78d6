"""At rest the first joint of a UR5e, a Panda and an iiwa carries the whole weight beyond it, in 100
random postures each: to 1e-12 of it."""

import numpy as np

import freebody as fb

worst = 0.0
for name, base in (("ur5e", ""), ("panda", "panda_link0.mass"), ("iiwa14", "link_0.mass")):
    arm = fb.load(name)
    q = fb.random_state(arm, seed=2, batch=100)[0]
    still = np.zeros((100, arm.nv))
    force = fb.joint_wrenches(arm, q, still, still)[:, 0, :3]
    fixed = fb.parameters(arm)[base].value if base else 0.0  # the ur5e's base has no mass
    weight = np.array([0.0, 0.0, (arm.mass - fixed) * 9.81])
    worst = max(worst, abs(force - weight).max() / weight[2])
print(f"largest difference {worst:.1e} of the weight")
assert worst < 1e-12
