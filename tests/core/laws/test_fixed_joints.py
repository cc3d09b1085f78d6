"""The wrench through fixed joints: beside Pinocchio, which keeps the joint as one that stands
still, and by laws of what is behind it."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.extras import extra
from support.helpers import close, refused
from support.springs import loaded

INERTIAL = """<inertial><origin xyz="{0} 0.03 -0.1" rpy="0.2 -0.4 0.5"/><mass value="{1}"/>
<inertia ixx="0.03" iyy="0.04" izz="0.05" ixy="0.002" ixz="-0.003" iyz="0.004"/></inertial>"""


def urdf(kind: str) -> str:
    """An arm with a sensor at its wrist, a hand behind it and a finger that slides on the hand; the
    sensor's joint of a kind."""
    joints = (
        ("shoulder", "revolute", "base", "upper", "0 0 0.3", "0 0 0", "0 0 1"),
        ("elbow", "revolute", "upper", "fore", "0.1 0 0.4", "0.3 0.1 -0.2", "0 1 0"),
        ("sensor", kind, "fore", "plate", "0.05 0.1 0.3", "0.4 -0.6 0.9", "0.6 0 0.8"),
        ("bolts", "fixed", "plate", "hand", "0 0.02 0.1", "0 0.7 0", "1 0 0"),
        ("finger", "prismatic", "hand", "claw", "0.02 0 0.05", "0.1 0 0", "0 1 0"),
    )
    links = ("base", "upper", "fore", "plate", "hand", "claw")
    parts = [
        f'<link name="{name}">{INERTIAL.format(0.01 * k, 3.0 / (k + 1))}</link>'
        for k, name in enumerate(links)
    ]
    parts += [
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        f'<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
        for name, kind, parent, child, xyz, rpy, axis in joints
    ]
    return f'<robot name="arm">{"".join(parts)}</robot>'


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_beside_pinocchio(base):
    pin = extra("pinocchio", "Pinocchio")
    model = fb.load(text=urdf("fixed"), format="urdf", base=base)
    assert model.fixed_joint_names == ("sensor", "bolts")
    free = (pin.JointModelFreeFlyer(),) if base == "free" else ()
    theirs = pin.buildModelFromXML(urdf("revolute"), *free)
    data = theirs.createData()
    joint = theirs.getJointId("sensor")
    at = theirs.joints[joint].idx_v
    for seed in range(2):
        q, qd, qdd = fb.random_state(model, seed)
        hidden = [np.insert(x, at - x.size + model.nv, 0.0) for x in (qd, qdd)]
        their_q = np.insert(q, at + len(q) - model.nv, 0.0)
        if free:  # their quaternions end with the real part
            their_q[3:7] = their_q[[4, 5, 6, 3]]
        pin.rnea(theirs, data, their_q, *hidden)
        found = fb.joint_wrenches(model, q, qd, qdd, reference="child", joint="sensor")
        close(found, data.f[joint].vector, 1e-9)
        R = fb.forward_kinematics(model, q, "plate")[:3, :3]
        world = fb.joint_wrenches(model, q, qd, qdd, joint="sensor")
        close(world, np.concatenate([R @ found[:3], R @ found[3:]]), 1e-9)


def test_what_is_behind_a_joint_of_no_mass():
    model = fb.load("ur5e")
    tip = model.tip
    model = model.with_frame("probe", [0.1, 0.2, 0.3], frame=tip)
    q, qd, qdd = (np.stack([x, 0.5 * x]) for x in fb.random_state(model, 3))
    w = np.array([[1.0, -2, 3, 0.4, 0.5, -0.6], [0.0, 1, 0, 2, 0, 0]])
    found = fb.joint_wrenches(model, q, qd, qdd, {"probe": w}, joint="probe")
    close(found, -w, 1e-12)
    # a load behind it is held; one before it is not
    loaded = model.with_payload(2.0, frame="probe").with_payload(5.0, frame=tip, name="other")
    still = (fb.neutral(model), np.zeros(6), np.zeros(6))
    close(fb.joint_wrenches(loaded, *still, joint="probe"), [0, 0, 2 * 9.81, 0, 0, 0], 1e-9)
    moved = fb.joint_wrenches(loaded, q, qd, qdd, joint="probe")
    alone = fb.joint_wrenches(model, q, qd, qdd, {"probe": -moved}, joint="probe")
    close(moved, alone, 1e-9)


def test_in_the_plane_and_of_families():
    rod = fb.planar("RR", l=[0.5, 0.4], lc=[0.2, 0.2], m=[2.0, 1.0], I=[0.1, 0.1])
    model = rod.with_tool("hand", [0.1, -0.1], inertia=fb.Inertia(0.7, (0.05, 0.02), (0.01,)))
    q, qd, qdd = fb.random_state(model, 1)
    found = fb.joint_wrenches(model, q, qd, qdd, joint="hand", reference="child")
    space = fb.joint_wrenches(model.to_space(), q, qd, qdd, joint="hand", reference="child")
    close(found, space[[0, 1, 5]], 1e-12)
    many = model.bind({"hand.mass": np.array([0.7, 1.4])})
    close(fb.joint_wrenches(many, q, qd, qdd, joint="hand")[0],
          fb.joint_wrenches(model, q, qd, qdd, joint="hand"), 1e-12)  # fmt: skip


def test_in_a_closed_chain():
    model, (q, qd), _ = loaded("four_bar")
    qdd = fb.loop_acceleration(model, q, qd, np.zeros(model.nv))
    loop = model.loops[0]
    found = fb.joint_wrenches(model, q, qd, qdd, joint=loop.frames[1])
    every = fb.joint_wrenches(model, q, qd, qdd)
    close(found, -every[-1], 1e-9)  # nothing else holds a frame without mass
    close(fb.joint_wrenches(model, q, qd, qdd, joint=loop.name), every[-1], 0.0)
    close(fb.joint_wrenches(model, q, qd, qdd, joint=model.joint_names[1]), every[1], 0.0)


def test_names(tmp_path):
    model = fb.load(text=urdf("fixed"), format="urdf")
    saved = tmp_path / "arm.toml"
    fb.save(model, saved)
    assert fb.load(saved).fixed_joint_names == ("sensor", "bolts")
    motion = fb.random_state(model, 0)
    refused(
        "no joint 'senser' in joint_wrenches. Did you mean 'sensor'? Joints: shoulder, elbow, "
        "finger, plate, hand, sensor, bolts.",
        lambda: fb.joint_wrenches(model, *motion, joint="senser"),
    )
