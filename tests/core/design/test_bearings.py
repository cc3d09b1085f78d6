"""Bearings and floor: closed forms, the balance of the whole robot, and given bearings' lives."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

CROSSED = fb.Bearing(
    "B", "crossed roller", 20_000.0, static_load=30_000.0, pitch_diameter=0.1, load_factor=1.2,
    moment_limit=500.0,
)  # fmt: skip


def loop(model: fb.Model, seconds: float = 1.0) -> fb.Motion:
    q = np.linspace(0.2, 0.8, model.nq)
    return fb.quintic(model, [q, q + 1.0, q], [0.0, seconds, 2.0 * seconds])


def test_a_turntable_at_rest_by_hand():
    """10 kg at 0.3 m beside a vertical axis: 98 N along it, 29.4 N m across it, nothing else."""
    table = fb.dh([{"a": 0.3, "m": 10.0}], convention="standard").replace(gravity=(0, 0, -9.8))
    slow = fb.quintic(table, [[0.0], [math.pi]], [0.0, 1e4])
    (joint,) = table.joint_names
    found = fb.bearing_loads(table, slow, {joint: CROSSED})
    of = found.summary.isel(cycle=0, joint=0)
    assert float(of.peak_axial_force) == pytest.approx(98.0)
    assert float(of.peak_tilting_moment) == pytest.approx(29.4)
    assert float(of.peak_radial_force) < 1e-3
    # 2·29.4/0.1 = 588 N across; 98 N along it is less than 1.5 of that: 588 + 0.45·98
    assert float(of.equivalent_load) == pytest.approx(588.0 + 44.1, rel=1e-6)
    rpm = 0.5 / (1e4 / 60.0)
    life = 1e6 / (60.0 * rpm) * (20_000.0 / (1.2 * 632.1)) ** (10 / 3)
    assert float(of.bearing_life) == pytest.approx(life, rel=1e-5)
    assert float(of.static_safety) == pytest.approx(30_000.0 / (588.0 + 0.44 * 98.0), rel=1e-5)
    assert float(of.moment_share) == pytest.approx(29.4 / 500.0)
    floor = fb.floor_loads(table, slow)
    assert np.abs(floor.wrench[:, 2] + 98.0).max() < 1e-6
    assert np.abs(floor.greatest[3:5, 3:5]).max() == pytest.approx(29.4, rel=1e-4)


def test_bearings_carry_what_is_across_and_wear_as_the_sum_says():
    arm = fb.load("ur5e")
    segment = fb.Segment(loop(arm), payload=3.0, dwell=0.5)
    found = fb.bearing_loads(arm, segment, {"elbow_joint": CROSSED})
    motion, axis = segment.motion, np.array(arm.bodies[2].joint.axis)
    w = fb.joint_wrenches(
        arm.with_payload(3.0), motion.q, motion.qd, motion.qdd, reference="child",
        joint="elbow_joint",
    )  # fmt: skip
    across = [x - np.outer(x @ axis, axis) for x in (w[:, :3], w[:, 3:])]
    radial, tilting = (np.linalg.norm(x, axis=1) for x in across)
    expected = {"radial_force": radial, "axial_force": w[:, :3] @ axis, "tilting_moment": tilting}
    for name, values in expected.items():
        got = found.data[name].sel(joint="elbow_joint").values[:-1]
        assert got == pytest.approx(values, rel=1e-9, abs=1e-9)
    of = found.data.sel(joint="elbow_joint")
    turned = np.abs(of.rate.values) * of.seconds.values
    worn = float(turned @ of.equivalent_load.values ** (10 / 3))
    mean = found.summary["equivalent_load"].sel(joint="elbow_joint").item()
    assert worn == pytest.approx(turned.sum() * mean ** (10 / 3))
    assert found.summary["bearing_life"].isnull().sum() == 5
    assert "the shortest life" in repr(found)


def test_the_floor_carries_the_whole_robot():
    """Force and moment are the weight less the rate of momentum, about the base."""
    arm = fb.load("ur5e")
    motion = fb.quintic(arm, [np.linspace(0.2, 0.8, 6), np.linspace(1.2, 1.8, 6)], [0.0, 1.0])
    floor = fb.floor_loads(arm, fb.Segment(motion, payload=2.0))
    loaded = arm.with_payload(2.0)
    h, t = 1e-5, motion.t[1:-1]
    before, after = (
        fb.momentum(loaded, *motion.at(x)[:2], about=(0.0, 0.0, 0.0)) for x in (t - h, t + h)
    )
    rate = (after - before) / (2.0 * h)
    based = float(sum(mass.m for mass in loaded.tree.base))
    centre = fb.center_of_mass(loaded, motion.q[1:-1])
    weight = (loaded.mass - based) * loaded.gravity
    force, moment = -rate[:, :3] + weight, -rate[:, 3:] + np.cross(centre, weight)
    scale = np.abs(floor.wrench).max()
    on_base = floor.wrench[1:-1] - _of_base(loaded)
    assert np.abs(on_base[:, :3] - force).max() < 1e-6 * scale
    assert np.abs(on_base[:, 3:] - moment).max() < 1e-6 * scale
    worst = np.abs(floor.wrench).argmax(axis=0)
    assert np.array_equal(floor.greatest, floor.wrench[worst])


def _of_base(model: fb.Model) -> np.ndarray:
    weights = [(mass.m * model.gravity, np.asarray(mass.c)) for mass in model.tree.base]
    return sum((np.r_[w, np.cross(c, w)] for w, c in weights), np.zeros(6))


def test_what_is_refused():
    arm = fb.load("scara")
    motion = fb.default_motion(arm, samples=41)
    with pytest.raises(fb.UnknownNameError, match="joint3"):
        fb.bearing_loads(arm, motion, {"joint3": CROSSED})
    with pytest.raises(fb.KindError, match=r"an fb\.Bearing"):
        fb.bearing_loads(arm, motion, {"joint1": 3.0})  # type: ignore[dict-item]
    free = fb.load("quadrotor")
    hover = fb.default_motion(free, samples=41)
    with pytest.raises(fb.FreebodyError, match="is free and stands on nothing"):
        fb.floor_loads(free, hover)
