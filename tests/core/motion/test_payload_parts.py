"""Payloads limited by brakes and bearings: closed forms, and the robot that carries so much is at
the limit of that part by functions that know nothing of payloads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

MOTOR = fb.Motor("M", 1e-4, 1.0, 3.0, 400.0, 2.0, brake_torque=2.0)
GEAR = fb.Gear("G", 0.8, 1e-5, 1.0, ratio=50.0)
CROSSED = fb.Bearing(
    "B", "crossed roller", 20_000.0, static_load=3_000.0, pitch_diameter=0.1, static_factor=1.5,
    moment_limit=60.0,
)  # fmt: skip


def rod(effort: float = 500.0) -> fb.Model:
    """3 kg halfway along 2 m, whose tip carries."""
    limits = [fb.Limits(effort=effort)]
    return fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1], limits=limits)


def test_a_turntable_by_hand():
    """W = 9.8 (10 + m) N at 0.3 m beside a vertical axis: M = 0.3 W, F_a = W, F_r = 0. By IKO,
    Crossed Roller Bearings, equation 2: P₀ = F_r + 2 M/d + 0.44 F_a = (6 + 0.44) W, to be at most
    C₀/f_s = 2000 N; and 0.3 W at most 60 N m, at 200 N already."""
    table = fb.dh([{"a": 0.3, "m": 10.0}], convention="standard").replace(gravity=(0, 0, -9.8))
    (joint,) = table.joint_names
    found = fb.payload(
        table, [0.4], effort=[1.0], bearings={joint: CROSSED}, brakes={joint: (MOTOR, GEAR)}
    )
    assert found.limits == ("effort", "brake", "static load", "tilting moment")
    by_hand = [np.inf, np.inf, 2000.0 / 6.44 / 9.8 - 10.0, 200.0 / 9.8 - 10.0]
    assert found.by_joint == pytest.approx(by_hand, rel=1e-12)
    part = f"tilting moment on the bearing of {joint} (B) limits"
    assert (
        found.card
        == f"carries 10.4 kg by its effort limits, brakes and bearings at this posture · {part}"
    )
    small = replace(CROSSED, moment_limit=29.0)
    weak = fb.payload(table, [0.4], effort=[1.0], bearings={joint: small})
    words = f"tilting moment on the bearing of {joint} (B) is too large already"
    assert weak.card == f"carries nothing at this posture · {words}"
    assert weak.by_joint[-1] == 0.0
    strong = replace(CROSSED, moment_limit=None)
    alone = fb.payload(table, [0.4], effort=[1.0], bearings={joint: strong})
    assert alone.card.endswith(f"static load on the bearing of {joint} (B) limits")
    weightless = fb.payload(
        table.replace(gravity=(0, 0, 0)), [0.4], effort=[1.0], bearings={joint: strong}
    )
    assert (
        weightless.card
        == "carries any mass at this posture: no effort limit or bearing is in the way"
    )


def test_a_brake_by_hand():
    """2 N m behind 50:1 hold 100 N m, what the gear loses not counted on; level, the rod asks for
    9.81 (3·1 + m·2). What lifts the tip may end as the drives do, what pulls it down may stay."""
    arm, brakes = rod(), {"joint1": (MOTOR, GEAR)}
    by_hand = (100.0 / 9.81 - 3.0) / 2.0
    up, down = {"tip": [0.0, 10.0, 0.0]}, {"tip": [0.0, -10.0, 0.0]}
    for pull, less in ((None, 0.0), (up, 0.0), (down, 10.0 / 9.81)):
        found = fb.payload(arm, [0.0], brakes=brakes, wrenches=pull)
        assert found.mass == pytest.approx(by_hand - less, rel=1e-12)
    motion = fb.quintic(arm, [[-0.3], [1.1]], [0.0, 4.0], step=0.3)  # level between samples
    found = fb.payload(arm, motion, brakes=brakes)
    level = motion.t[0] + found.time
    assert motion.at(np.array([level]))[0] == pytest.approx(0.0, abs=5e-3)
    assert found.mass == pytest.approx(by_hand, rel=1e-4)
    assert f" · brake of joint1 (M) limits at t = {float(found.time):.3g} s · " in found.card
    none = replace(MOTOR, brake_torque=None)
    free = fb.payload(arm, [[0.0], [-math.pi / 2]], brakes={"joint1": (none, GEAR)})
    assert free.mass.tolist() == [0.0, np.inf]  # it hangs
    assert "brake of joint1 (M) is overloaded already" in free.card


LOAD = {"com": [0.05, 0.1, 0.2]}
ELBOW = "elbow_joint"
STRONG = replace(CROSSED, static_load=12_000.0, moment_limit=250.0)


def shares(arm: fb.Model, mass: float, states: tuple[np.ndarray, ...]) -> dict[str, np.ndarray]:
    """Shares of the limits of the elbow's brake and bearing, by reaction wrenches, static torques
    and the data sheet's own formula, of an arm that carries so much."""
    carrying, k = arm.with_payload(mass, **LOAD), arm.joint_names.index(ELBOW)
    axis = np.array(arm.bodies[k].joint.axis)
    w = fb.joint_wrenches(carrying, *states, reference="child", joint=ELBOW)
    force, moment = w[..., :3], w[..., 3:]
    along = force @ axis
    radial, tilting = (
        np.linalg.norm(x - (x @ axis)[..., None] * axis, axis=-1) for x in (force, moment)
    )
    static = STRONG.static_equivalent_load(radial, along, tilting)
    return {
        "brake": np.abs(fb.static_torque(carrying, states[0])[..., k]) / 100.0,
        "static load": static / 8_000.0,
        "tilting moment": tilting / 250.0,
    }


def test_that_mass_and_no_more_at_postures():
    arm = fb.load("ur5e")
    q, _, _ = fb.random_state(arm, 5, 25)
    found = fb.payload(
        arm, q, bearings={ELBOW: STRONG}, brakes={ELBOW: (MOTOR, GEAR)}, effort=[500.0] * 6, **LOAD
    )
    checked, still = 0, np.zeros(6)
    for at, row in zip(q, found.by_joint[:, 6:], strict=True):
        for mass, limit in zip(row, found.limits[6:], strict=True):
            if np.isfinite(mass):
                checked += 1
                used = shares(arm, float(mass), (at, still, still))[limit]
                assert used == pytest.approx(1.0, rel=1e-11)
    assert checked > 70
    data = found.to_xarray()
    assert set(data["limit"].values) <= {"effort", "brake", "static load", "tilting moment"}
    assert f"brake of {ELBOW} (M)" in data["coordinate"].values


def test_that_mass_and_no_more_along_a_motion_and_in_a_cycle():
    """A bearing carries what accelerations add; a brake has to hold the arm wherever it is."""
    arm = fb.load("ur5e")
    way = [[0, -1, 1, 0, 0, 0], [1, -0.5, 0.5, 0.3, 0.2, 0.1]]
    motion = fb.trapezoid(arm, way, [0.0, 0.8], acceleration=30.0)
    parts = {"bearings": {ELBOW: STRONG}, "brakes": {ELBOW: (MOTOR, GEAR)}}
    found = fb.payload(arm, motion, **parts, **LOAD)
    states = motion.at(np.linspace(0.0, 0.8, 2001))
    for k, limit in enumerate(found.limits[6:], 6):
        assert found.joint_names[k] == ELBOW
        most = shares(arm, float(found.by_joint[k]), states)[limit].max()
        assert most == pytest.approx(1.0, abs=2e-3)
    rest = fb.Segment(motion, payload={"mass": 2.0, **LOAD}, dwell=0.2)
    loaded = fb.payload(arm, fb.DutyCycle([rest]), **parts, **LOAD)
    assert loaded.by_joint[0, 6:] == pytest.approx(found.by_joint[6:] - 2.0, rel=1e-6)


def test_a_load_diagram_has_curves_of_brakes_and_bearings():
    """Level, a crossed roller bearing at the root of a planar arm carries W across it and no
    moment: P₀ = F_r. A brake's curve is a hyperbola over the offset."""
    bearing = replace(CROSSED, static_load=300.0, static_factor=1.0, moment_limit=None)
    found = fb.load_diagram(
        rod(), [0.0], offsets=[0.0, 0.5, 1.0, 3.0], brakes={"joint1": (MOTOR, GEAR)},
        bearings={"joint1": bearing},
    )  # fmt: skip
    weight = 300.0 / 9.81 - 3.0
    assert found.by_joint[:, 2] == pytest.approx(weight, rel=1e-12)
    arm = 2.0 + found.offsets
    assert found.by_joint[:, 1] == pytest.approx((100.0 / 9.81 - 3.0) / arm, rel=1e-12)
    assert "brake of joint1 (M)" in found.svg
    assert found.to_xarray()["limit"].values.tolist() == ["brake"] * 4


def test_refusals():
    arm = rod()
    ball = fb.Bearing("K", "radial", 1e4, static_load=5e3, x=0.56, y=1.7, e=0.26)
    for error, words, parts in (
        (fb.FreebodyError, "bearing 'K': payload: it limits no load", {
            "bearings": {"joint1": ball}}),
        (fb.UnknownNameError, "no joint that turns about one axis 'wrist'", {
            "bearings": {"wrist": CROSSED}}),
        (fb.KindError, "bearings", {"bearings": {"joint1": 3.0}}),
        (fb.KindError, r"brakes\['joint1'\]", {"brakes": {"joint1": MOTOR}}),
        (fb.UnknownNameError, "no driven joint 'wrist'", {"brakes": {"wrist": (MOTOR, GEAR)}}),
        (fb.FreebodyError, "joint 'joint1' turns, and this gear has a lead", {
            "brakes": {"joint1": (MOTOR, replace(GEAR, ratio=None, lead=0.01))}}),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            fb.payload(arm, [0.0], **parts)
    held_twice = fb.load("bricard")
    motion = fb.default_motion(held_twice, samples=8)
    names = held_twice.joint_names
    with pytest.raises(fb.FreebodyError, match=r"bearing loads are nan at .*held more than once"):
        fb.payload(
            held_twice, motion, effort=dict.fromkeys(held_twice.driven_names, 10.0),
            bearings=dict.fromkeys(names, CROSSED),
        )  # fmt: skip
