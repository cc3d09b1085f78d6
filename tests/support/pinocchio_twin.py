"""URDF files as Pinocchio reads them, joints and rates in our order.

Joints are paired by name: Pinocchio sorts children, and keeps a continuous joint as (cos, sin) and
quaternions as xyzw.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import freebody as fb
from support.extras import extra
from support.helpers import close
from support.real_files import FILES, REFUSED, ROBOTS

pin = extra("pinocchio", "Pinocchio")
EPS = np.finfo(float).eps
BASES = ("fixed", "free")
LOADED = [name for name in FILES if name not in REFUSED or "mimic" in REFUSED[name]]
EVERY = [(name, base) for name in LOADED for base in BASES]
IDS = [f"{name.removesuffix('.urdf')}-{base}" for name, base in EVERY]
every_robot = pytest.mark.parametrize(("name", "base"), EVERY, ids=IDS)
DOZEN = (
    "ur_description/urdf/ur5_robot.urdf",
    "panda_description/urdf/panda.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "kinova_description/robots/kinova.urdf",
    "talos_data/robots/talos_left_arm.urdf",
    "double_pendulum_description/urdf/double_pendulum.urdf",
    "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
    "so_arm_description/urdf/so101.urdf",
    "z1_description/urdf/z1.urdf",
    "baxter_description/urdf/baxter.urdf",
    "solo_description/robots/solo12.urdf",
    "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
    "finger_edu_description/robots/finger_edu.urdf",
)


class Theirs:
    """A file as Pinocchio reads it, its vectors in our order."""

    def __init__(self, name: str, base: str, ours: fb.Model):
        root = [pin.JointModelFreeFlyer()] if base == "free" else []
        self.model = pin.buildModelFromUrdf(str(ROBOTS / name), *root, mimic=False)
        self.data = self.model.createData()
        self.ours = ours
        assert self.model.nv == ours.nv
        joints = [
            self.model.getJointId("root_joint" if j == "base" else j) for j in ours.joint_names
        ]
        assert sorted(joints) == list(range(1, self.model.njoints))
        assert all(
            body.kind.nv == self.model.joints[j].nv
            for body, j in zip(ours.bodies, joints, strict=True)
        )
        self.joints = joints
        self.v = np.array(
            [k for j in joints for k in range(*span(self.model.joints[j]))], dtype=int
        )

    def q(self, q: np.ndarray) -> np.ndarray:
        """One position in Pinocchio's coordinates."""
        theirs = np.empty(self.model.nq)
        for j, at in zip(self.joints, self.ours.coordinates, strict=True):
            joint, own = self.model.joints[j], q[list(at.q)]
            if joint.nq == 7:
                own = np.concatenate([own[:3], own[4:], own[3:4]])
            elif joint.nq == 2:
                own = np.array([np.cos(own[0]), np.sin(own[0])])
            theirs[joint.idx_q : joint.idx_q + joint.nq] = own
        return theirs

    def rates(self, x: np.ndarray) -> np.ndarray:
        """q̇ or q̈ in Pinocchio's order."""
        theirs = np.empty(self.model.nv)
        theirs[self.v] = x
        return theirs

    def of(self, compute, q: np.ndarray, *rates: np.ndarray) -> np.ndarray:
        """A vector or matrix over joints, of a batch of states, in our order."""
        rows = []
        for state in zip(q, *rates, strict=True):
            value = compute(
                self.model, self.data, self.q(state[0]), *(self.rates(x) for x in state[1:])
            )
            value = np.array(value)[self.v]
            rows.append(value[:, self.v] if value.ndim == 2 else value)
        return np.array(rows)


def span(joint) -> tuple[int, int]:
    return joint.idx_v, joint.idx_v + joint.nv


@cache
def pair(name: str, base: str) -> tuple[fb.Model, Theirs]:
    """The file as read by freebody, to the letter, and by Pinocchio; read once by a process, for
    every test goes through all files."""
    model = fb.load(str(ROBOTS / name), base=base, mimic="free", snap_angles=0, physical="ignore")
    return model, Theirs(name, base, model)


def state(model: fb.Model, name: str, batch: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return fb.random_state(model, sum(name.encode()), batch)


def relative(found: np.ndarray, expected: np.ndarray, what: str, tolerance: float = 1e-10) -> None:
    """Max difference over max reference; against one where the reference is nothing at all."""
    scale = 0.0 if np.abs(expected).max(initial=0.0) > 1e-9 else 1.0
    close(found, expected, tolerance, scale, what)


def dry(model: fb.Model) -> fb.Model:
    return model.without("friction", "rotors", "springs")


def symmetric(m: np.ndarray) -> np.ndarray:
    """Pinocchio fills what is above its own diagonal."""
    upper = np.where(m != 0, m, m.T)
    assert np.array_equal(upper, upper.T)
    return upper


SINGULAR = {
    "romeo_description/urdf/romeo.urdf": ("LHand", "RThumb3"),
    "romeo_description/urdf/romeo_laas_small.urdf": ("l_gripper_joint", "r_gripper_joint"),
}
