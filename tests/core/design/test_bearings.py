"""Bearings: closed forms, what joints carry, and given bearings' lives."""

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


def test_loads_that_rigid_bodies_do_not_determine_are_not_told():
    """Six hinges hold Bricard's linkage once more than it needs; those of a planar loop do not."""
    held_twice, planar = fb.load("bricard"), fb.load("five_bar")
    found = fb.bearing_loads(held_twice, fb.default_motion(held_twice, samples=8))
    assert found.summary["peak_radial_force"].isnull().any()
    assert "held more than once" in found.notices[-1]
    sure = fb.bearing_loads(planar, fb.default_motion(planar, samples=8))
    assert not sure.summary["peak_radial_force"].isnull().any()
    assert sure.notices == ()


def test_a_joint_that_follows_several_has_one_bearing():
    """The hand of a palletiser: its bearing turns as the forearm does against the hand, the sum of
    shoulder and elbow, and wears at that speed."""
    arm = fb.load(text=LEVEL, format="toml")
    motion = loop(arm)
    found = fb.bearing_loads(arm, motion, {"wrist": CROSSED})
    assert found.data.joint.values.tolist() == ["shoulder", "elbow", "wrist"]
    assert found.data.rate.sel(joint="wrist").values == pytest.approx(-motion.qd.sum(axis=1))


LEVEL = """
name = "level hand"
link = [
  { name = "base" }, { name = "upper", mass = 3 }, { name = "fore", mass = 2 },
  { name = "hand", mass = 1, com = [0.1, 0, 0] },
]
[[joint]]
name = "shoulder"
kind = "revolute"
axis = "y"
parent = "base"
child = "upper"
[[joint]]
name = "elbow"
kind = "revolute"
axis = "y"
parent = "upper"
child = "fore"
origin = [0, 0, 0.8]
[[joint]]
name = "wrist"
kind = "revolute"
axis = "y"
parent = "fore"
child = "hand"
origin = [0.7, 0, 0]
mimic = { joints = { shoulder = -1, elbow = -1 } }
"""


def test_what_is_refused():
    arm = fb.load("scara")
    motion = fb.default_motion(arm, samples=41)
    with pytest.raises(fb.UnknownNameError, match="joint3"):
        fb.bearing_loads(arm, motion, {"joint3": CROSSED})
    with pytest.raises(fb.KindError, match=r"an fb\.Bearing"):
        fb.bearing_loads(arm, motion, {"joint1": 3.0})  # type: ignore[dict-item]
