"""Studies that judge brakes and bearings: numbers by hand, and the pace at which they are at their
limits is that at which a study finds them there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import told

MOTOR = fb.Motor("M", 1e-4, 1.0, 3.0, 400.0, 2.0, brake_torque=2.0)
GEAR = fb.Gear("G", 0.8, 1e-5, 1.0, ratio=50.0)
CROSSED = fb.Bearing("B", "crossed roller", 2e4, static_load=48.0, pitch_diameter=0.1)
ELBOW = replace(CROSSED, static_load=2_100.0, static_factor=1.5)


def rod(gravity: float = -9.81) -> fb.Model:
    """3 kg halfway along 2 m, whose tip carries."""
    limits = [fb.Limits(effort=500.0, velocity=50.0, lower=-10.0, upper=10.0)]
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1], limits=limits)
    return arm.replace(gravity=(0.0, gravity))


def used(study: fb.Study | fb.CycleStudy) -> dict[str, float]:
    """Shares of the limits of brakes and bearings."""
    named = ("brake torque", "static load", "tilting moment")
    return {x.quantity: x.fraction for x in study.verdict.uses if x.quantity in named}


def test_a_spinning_rod_by_hand():
    """At 2 rad/s 3 kg at 1 m pull with 12 N, a quarter of 48 N: twice as fast is the limit, and at
    this speed 4.5 kg at 2 m."""
    t = np.linspace(0.0, 1.0, 21)
    study = fb.study(
        rod(0.0), fb.Motion.of(rod(0.0), t, 2.0 * t[:, None]), bearings={"joint1": CROSSED},
        brakes={"joint1": (MOTOR, GEAR)},
    )  # fmt: skip
    assert used(study) == {"static load": pytest.approx(0.25), "brake torque": pytest.approx(0.0)}
    card, verdict = study.card, study.verdict
    assert verdict.factor == pytest.approx(2.0, rel=1e-8)
    assert (card.faster, card.faster_quantity) == (verdict.factor, "static load")
    assert card.payload == pytest.approx(4.5, rel=1e-8)
    assert card.payload_remark.startswith("static load on the bearing of joint1 (B) limits")
    assert (card.first.quantity, card.first.unit) == ("static load", "N")
    assert ("parts", "", "", "judged too: the brake of joint1 (M); the bearing of joint1 (B).") in (
        study.load_case.rows
    )


def test_a_brake_that_does_not_hold_is_helped_by_no_slowing():
    """Level, 3 kg at 1 m ask for 29.43 N m; 0.5 N m behind 50:1 hold 25."""
    motion = fb.quintic(rod(), [[0.0], [1.0]], [0.0, 2.0])
    weak = {"joint1": (replace(MOTOR, brake_torque=0.5), GEAR)}
    study = fb.study(rod(), motion, brakes=weak)
    assert used(study) == {"brake torque": pytest.approx(29.43 / 25.0)}
    assert (study.verdict.outcome, study.verdict.factor) == ("not feasible", 0.0)
    assert "gravity alone requires 118 % of what joint1's brake holds at t = 0 s" in (
        study.verdict.text
    )
    assert (study.card.payload, study.card.faster_quantity) == (0.0, "brake torque")
    none = fb.study(rod(), motion, brakes={"joint1": (replace(MOTOR, brake_torque=None), GEAR)})
    assert (used(none), none.verdict.factor) == ({"brake torque": np.inf}, 0.0)


def test_a_rest_loads_brakes_and_bearings():
    """It ends level: W = (3 + 2) g at its bearing, 3 g + 2·2 g at its brake."""
    up = fb.quintic(rod(), [[-1.2], [0.0]], [0.0, 20.0])
    cycle = fb.DutyCycle([fb.Segment(up, payload=2.0, dwell=1.0)])
    bearing = replace(CROSSED, static_load=100.0)
    study = fb.study(rod(), cycle, bearings={"joint1": bearing}, brakes={"joint1": (MOTOR, GEAR)})
    assert used(study)["brake torque"] == pytest.approx(7.0 * 9.81 / 100.0)
    assert used(study)["static load"] == pytest.approx(5.0 * 9.81 / 100.0, rel=2e-2)
    assert study.card.payload == pytest.approx((100.0 / 9.81 - 7.0) / 2.0)
    assert study.card.payload_remark.startswith("in every segment, besides")
    weak = replace(MOTOR, brake_torque=1.0)
    assert fb.study(rod(), cycle, brakes={"joint1": (weak, GEAR)}).verdict.factor == 0.0


@pytest.mark.usefixtures("numpy_kernels")
def test_at_the_pace_found_a_bearing_is_at_its_limit():
    """An arm in space, whose elbow bears forces and moments, and a closed chain, in which friction
    loads bearings."""
    arm = fb.load("ur5e").with_payload(2.0, com=[0.05, 0.1, 0.2])
    way = [[0, -1, 1, 0, 0, 0], [0.5, -0.5, 0.5, 0.3, 0.2, 0.1]]
    five = fb.load("five_bar").with_drive("B", coulomb=0.3, viscous=0.4)
    for model, motion, joint, bearing in (
        (arm, fb.quintic(arm, way, [0.0, 1.5]), "elbow_joint", ELBOW),
        (five, fb.default_motion(five, samples=60), "B", CROSSED),
    ):
        fitted = {"bearings": {joint: bearing}}
        effort = dict.fromkeys(model.driven_names, 1e4)
        plain = fb.payload(model, motion, effort=effort, **fitted).faster
        assert 1.0 < plain < 100.0
        found = fb.bearing_loads(model, motion.faster(plain), {joint: bearing})
        safety = found.summary["static_safety"].sel(joint=joint)
        assert float(safety[0]) == pytest.approx(bearing.static_factor, rel=1e-6)
    changing = five.with_drive("B", coulomb=0.3, stribeck=0.4, stribeck_speed=0.2)
    effort = dict.fromkeys(five.driven_names, 1e4)
    motion = fb.default_motion(five, samples=60)
    assert np.isnan(fb.payload(changing, motion, effort=effort, bearings={"B": CROSSED}).faster)


def test_by_command(tmp_path: Path):
    asked = ["study", "scara", "--catalogue", "invented", "--bearing", "joint1=B120"]
    status, said = told([*asked, "--out", str(tmp_path)])
    assert status == 0, said
    assert "the bearing of joint1 (B120)" in " ".join(said.split())
    assert "the bearing of joint1 (B120)" in (tmp_path / "report.html").read_text()
    status, said = told([*asked[:2], *asked[4:], "--out", str(tmp_path)])
    assert status == 2
    assert "--catalogue FILE" in said


def test_refusals():
    ball = fb.Bearing("K", "radial", 1e4, static_load=5e3, x=0.56, y=1.7, e=0.26)
    with pytest.raises(fb.FreebodyError, match="bearing 'K': study: it limits no load"):
        fb.study(rod(), bearings={"joint1": ball})
