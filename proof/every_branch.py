"""The inverse kinematics of a UR5e finds, for 500 random poses, the posture from which the pose
was made, and every solution it gives reaches the pose to 1e-9."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
q, *_ = fb.random_state(arm, seed=7, batch=500)
poses = fb.forward_kinematics(arm, q)
found = fb.inverse_kinematics(arm, poses)
reached = fb.forward_kinematics(arm, np.where(found.valid[..., None], found.q, 0.0))
off = np.where(found.valid, abs(reached - poses[:, None]).max(axis=(-1, -2)), 0.0).max()
turned = (found.q - q[:, None] + np.pi) % (2 * np.pi) - np.pi
missed = np.where(found.valid, abs(turned).max(axis=-1), np.inf).min(axis=-1).max()
print(
    f"{found.valid.sum(axis=1).mean():.1f} ways a pose, at most {off:.0e} off; own {missed:.0e} rad"
)
assert off < 1e-9
assert missed < 1e-6
