"""Load tables of floor, flange and joints: closed forms, the balance of momentum of whole robots,
and rows found by looking at every sample."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")


def test_a_turntable_by_hand():
    """10 kg at 0.3 m beside a vertical axis: 98 N down, 29.4 N m that turn with it."""
    table = fb.dh([{"a": 0.3, "m": 10.0}], convention="standard").replace(gravity=(0, 0, -9.8))
    slow = fb.quintic(table, [[0.0], [math.pi]], [0.0, 10.0])
    floor = fb.floor_loads(table, slow)
    assert np.abs(floor.wrench[:, 2] + 98.0).max() < 1e-6
    assert np.abs(floor.greatest[3:5, 3:5]).max() == pytest.approx(29.4, rel=1e-4)
    pressed = fb.Segment(slow, wrenches={table.frame_names[0]: [0.0, 5.0, -2.0, 1.0, 0.0, 0.0]})
    more = fb.floor_loads(table, pressed).wrench - floor.wrench
    assert np.allclose(more, [0.0, 5.0, -2.0, 1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["ur5e", "3RRR"])
def test_the_floor_carries_the_whole_robot(name: str):
    """Force and moment are the weight less the rate of momentum, about the base, of open and closed
    chains; what struts take they give back."""
    robot = fb.load(name)
    motion = fb.default_motion(robot, samples=41)
    floor = fb.floor_loads(robot, fb.Segment(motion, payload=2.0))
    loaded, d = robot.with_payload(2.0), robot.dim
    h, t = 1e-5, motion.t[1:-1]
    before, after = (
        fb.momentum(loaded, *motion.at(x)[:2], about=[0.0] * d) for x in (t - h, t + h)
    )
    centre, based = fb.center_of_mass(loaded, motion.q), _of_base(loaded)
    mass = loaded.mass - float(sum(part.m for part in loaded.tree.base))
    weight = np.zeros_like(floor.wrench) + based
    weight[:, :d] += mass * loaded.gravity
    weight[:, d:] += _moment(centre, mass * loaded.gravity)
    scale = np.abs(floor.wrench).max()
    missed = floor.wrench[1:-1] - weight[1:-1] + (after - before) / (2.0 * h)
    assert np.abs(missed).max() < 2e-6 * scale
    ends = (robot.frame_names[0], robot.bodies[1].name)
    tied = robot.with_strut("gas spring", ends, stiffness=1e3, rest=0.1)
    again = fb.floor_loads(tied, fb.Segment(motion, payload=2.0))
    assert np.allclose(again.wrench, floor.wrench, atol=1e-9 * scale)


def _of_base(model: fb.Model) -> np.ndarray:
    weights = [
        np.append(mass.m * model.gravity, _moment(np.asarray(mass.c), mass.m * model.gravity))
        for mass in model.tree.base
    ]
    return sum(weights, np.zeros(6 if model.dim == 3 else 3))


def _moment(at: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Of one force at points (..., dim): (..., 3 or 1)."""
    if len(force) == 3:
        return np.cross(at, force)
    return (at[..., 0] * force[1] - at[..., 1] * force[0])[..., None]


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["ur5e", "gantry_crane", "bricard"])
def test_a_flange_bears_what_it_carries(name: str):
    """The robot with a payload less the robot without it, and the wrench at the tip: at a frame
    fixed to a link, at a body's own frame, and in a closed chain."""
    robot = fb.load(name)
    motion = fb.default_motion(robot, samples=9)
    push = np.array([3.0, -4.0, 5.0, 0.6, 0.7, -0.8])
    carried = {"mass": 2.0, "com": [0.01, 0.02, 0.1], "box": [0.1, 0.2, 0.3]}
    found = fb.load_table(robot, fb.Segment(motion, carried, push, dwell=1.0), reference="world")
    at, loads = (motion.q, motion.qd, motion.qdd), []
    for one, w in ((robot.with_payload(**carried), push), (robot, None)):
        loads.append(-fb.joint_wrenches(one.opened, *at, w))
    body = robot.frame().body
    turned = loads[0][:, body] - loads[1][:, body]
    arm = (
        fb.forward_kinematics(robot, motion.q)[:, :3, 3]
        - fb.forward_kinematics(robot, motion.q, robot.bodies[body].name)[:, :3, 3]
    )
    turned[:, 3:] -= np.cross(arm, turned[:, :3])
    assert np.allclose(found.wrench[:-1], turned, atol=1e-9 * np.abs(loads).max())
    own = fb.load_table(robot, fb.Segment(motion, carried, push, dwell=1.0))
    R = fb.forward_kinematics(robot, motion.q)[:, :3, :3]
    assert np.allclose(R @ own.wrench[:-1, :3, None], found.wrench[:-1, :3, None])
    assert ("alone" in "".join(own.notices)) == (name == "bricard")


def test_rows_are_the_samples_where_each_is_greatest():
    arm = fb.load("ur5e")
    there = fb.quintic(arm, [np.linspace(0.2, 0.8, 6), np.linspace(1.2, 1.8, 6)], [0.0, 1.0])
    duty = fb.DutyCycle([fb.Segment(there, payload=3.0, dwell=0.5)])
    found = fb.load_table(arm, [fb.Segment(there), duty], "elbow_joint")
    again = fb.joint_wrenches(
        arm.with_payload(3.0), there.q, there.qd, there.qdd, reference="child", joint="elbow_joint"
    )
    second = np.flatnonzero(found.cycle == 1)
    assert np.array_equal(-again, found.wrench[second[:-1]])
    assert found.time[second[-1]] == pytest.approx(1.0)
    wholes = [np.linalg.norm(found.wrench[:, part], axis=1) for part in (slice(3), slice(3, 6))]
    for k, (name, row) in enumerate(zip(found.rows, found.greatest, strict=True)):
        sizes = wholes[k - 6] if k >= 6 else np.abs(found.wrench[:, k])
        mine = np.linalg.norm(row[3 * (k - 6) : 3 * (k - 5)]) if k >= 6 else abs(row[k])
        assert mine == sizes.max(), name
        assert row in found.wrench
    assert found.rows[-2:] == ("force", "moment")
    assert "at most" in repr(found)
    assert found._table().rows[0][-1] == "2"


def test_what_is_refused_and_what_is_not_determined():
    free, linkage = fb.load("quadrotor"), fb.load("bricard")
    with pytest.raises(fb.FreebodyError, match="is free and stands on nothing"):
        fb.floor_loads(free, fb.default_motion(free, samples=8))
    motion = fb.default_motion(linkage, samples=8)
    found = fb.load_table(linkage, motion, "joint1")
    assert np.isnan(found.wrench).any()
    assert "held more than once" in found.notices[-1]
    assert not np.isnan(fb.load_table(linkage, motion).wrench).any()
    with pytest.raises(fb.UnknownNameError, match="elbow"):
        fb.load_table(linkage, motion, "elbow")
