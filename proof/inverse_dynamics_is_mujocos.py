"""A model of MuJoCo with armature, damping and springs, read as it is, has the inverse dynamics of
`mj_inverse`, to 1e-10 of the largest torque."""

import mujoco
import numpy as np

import freebody as fb

TEXT = """
<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="a" pos="0 0 1">
  <joint name="j1" axis="0 1 0" damping="0.3" armature="0.05" stiffness="2" springref="20"/>
  <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
  <body name="b" pos="0.4 0 0"><joint name="j2" axis="0 0 1" damping="0.1" armature="0.01"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0.1" size="0.03"/></body>
</body></worldbody></mujoco>"""
theirs = mujoco.MjModel.from_xml_string(TEXT)
theirs.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
data = mujoco.MjData(theirs)
arm = fb.load(text=TEXT, format="mjcf")
q, qd, qdd = fb.random_state(arm, seed=5, batch=100)
worst = 0.0
for k, tau in enumerate(fb.inverse_dynamics(arm, q, qd, qdd)):
    data.qpos[:], data.qvel[:], data.qacc[:] = q[k], qd[k], qdd[k]
    mujoco.mj_inverse(theirs, data)
    worst = max(worst, np.abs(tau - data.qfrc_inverse).max() / np.abs(tau).max())
print(f"largest difference {worst:.1e} of the largest torque")
assert worst < 1e-10
