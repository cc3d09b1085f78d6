"""Planned motions of closed chains: the driven joints as an open arm's would move, the others led
by the loops."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.helpers import numbers

WAY = [[1.9, 1.0], [2.2, 1.2], [2.0, 0.8]]
PLANS = {
    "quintic": (fb.quintic, {"acceleration": 2.0}),
    "trapezoid": (fb.trapezoid, {"acceleration": 2.0}),
    "s_curve": (fb.s_curve, {"acceleration": 2.0, "jerk": 10.0}),
    "spline": (fb.spline, {"acceleration": 2.0}),
}


@cache
def five_bar() -> fb.Model:
    return fb.load("five_bar")


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", PLANS)
def test_driven_joints_move_as_those_of_an_arm_and_the_loops_stay_closed(name: str):
    plan, limits = PLANS[name]
    found, arm = plan(five_bar(), WAY, **limits), plan(fb.load("2R"), WAY, **limits)
    assert found.duration == pytest.approx(arm.duration, rel=1e-12)
    t = np.linspace(*found.t[[0, -1]], 1777)
    q, qd, qdd = found.at(t)
    for mine, other in zip((q, qd, qdd), arm.at(t), strict=True):
        np.testing.assert_allclose(mine[:, :2], other, rtol=0, atol=1e-8)
    assert np.abs(numbers(five_bar(), "constraint", q)).max() < 1e-11
    np.testing.assert_allclose(qd, fb.loop_velocity(five_bar(), q, qd), rtol=0, atol=1e-9)
    kept = fb.loop_acceleration(five_bar(), q, fb.loop_velocity(five_bar(), q, qd), qdd)
    np.testing.assert_allclose(qdd, kept, rtol=0, atol=1e-5)
    np.testing.assert_allclose(found.jumps, arm.jumps, rtol=0, atol=1e-9)


def test_closed_positions_say_the_branch():
    """Both ways of closing at the same angles of the motors: mirror images of the elbows."""
    model = five_bar()
    here = fb.quintic(model, WAY, acceleration=2.0)
    start = here.q[0]
    flipped = fb.assemble(model, start * [1, 1, -1, -1], free=model.velocity_names[2:])
    assert np.abs(flipped - start).max() > 0.5
    end = fb.assemble(model, flipped + [0.3, 0.2, 0, 0], free=model.velocity_names[2:])
    found = fb.quintic(model, [flipped, end], acceleration=2.0)
    np.testing.assert_allclose(found.q[[0, -1]], [flipped, end], atol=1e-9)
    other = here.at(here.t[-1] / 2)[0]
    with pytest.raises(fb.FreebodyError, match="waypoint 1 is on another branch than the first"):
        fb.quintic(model, [flipped, other], acceleration=2.0)
    with pytest.raises(fb.FreebodyError, match="is open by"):
        fb.quintic(model, [start, start + 0.1], acceleration=2.0)


def test_whole_turns_of_joints_that_the_loops_lead_are_no_other_branch():
    model = five_bar()
    here = fb.quintic(model, WAY, acceleration=2.0)
    turned = here.q[-1] + [0, 0, 0, 2 * np.pi]
    found = fb.quintic(model, [here.q[0], turned], acceleration=2.0)
    np.testing.assert_allclose(found.q[-1], here.q[-1], atol=1e-9)
    limited = model.bind({"D.limits.lower": -9.0, "D.limits.upper": 9.0})
    with pytest.raises(fb.FreebodyError, match=r"the loops lead D to a place 6\.28 away"):
        fb.quintic(limited, [here.q[0], turned], acceleration=2.0)


def test_a_led_joint_slows_the_motion_where_its_speed_is_limited():
    quick = fb.spline(five_bar(), WAY, acceleration=2.0)
    top = quick.peaks.velocity.size[2]
    model = five_bar().bind({"B.limits.velocity": 0.5 * top})
    slow = fb.spline(model, WAY, acceleration=2.0)
    assert slow.duration == pytest.approx(2.0 * quick.duration, rel=1e-6)
    assert fb.exceeded_limits(model, slow) == ()
    with pytest.raises(fb.FreebodyError, match=r"the velocity of B is .* take 1\.709"):
        fb.spline(
            model, WAY, [0.0, 0.5 * quick.duration, quick.duration], acceleration=[9, 9, 9, 9]
        )


def test_motions_of_closed_chains_follow_each_other_and_are_studied():
    model = five_bar()
    there = fb.quintic(model, WAY, acceleration=2.0)
    back = fb.quintic(model, there.q[[-1, 0]], acceleration=2.0)
    whole = there.then(fb.dwell(model, there.q[-1], 0.2)).then(back)
    found = fb.study(model, whole)
    assert found.checked


@pytest.mark.long
def test_a_platform_on_six_legs_is_moved_by_their_lengths():
    """Its own coordinates have a quaternion; the legs are planned."""
    model = fb.load("stewart")
    start = fb.assemble(model)
    legs = start[[model.position_names.index(name) for name in model.driven_names]]
    way = legs + 0.03 * np.array([[0, 0, 0, 0, 0, 0], [1, 0, 1, 0, 1, 0], [0, 1, 1, 0, 0, 1]])
    found = fb.spline(model, way, acceleration=1.0)
    assert np.abs(numbers(model, "constraint", found.at(np.linspace(0, 0.8, 33))[0])).max() < 1e-11
    led = found.at(found.t[-1])[0][[model.position_names.index(x) for x in model.driven_names]]
    np.testing.assert_allclose(led, way[-1], atol=1e-12)


REFUSED = [
    ([[1.9], [2.2]], "waypoints has shape (2, 1), expected (k, 2) or (k, 4): positions of the dri"),
    ([[1.9, 1.0]], "waypoints has shape (1, 2), expected (k, 2) or (k, 4)"),
    ([[1.9, np.nan], [2.0, 1.0]], "waypoints is nan"),
    ([[1.9, 1.0], [3.1, 0.0]], "quintic: the loops of 'five_bar' block the driven joints at t = "),
]


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_cannot_be_is_refused(case: int):
    way, told = REFUSED[case]
    with pytest.raises(fb.FreebodyError) as problem:
        fb.quintic(five_bar(), way, acceleration=2.0)
    assert told in str(problem.value)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "stewart"])
def test_a_file_is_read_as_it_was_planned(tmp_path: Path, name: str):
    model = fb.load(name)
    start = fb.assemble(model)[[model.position_names.index(n) for n in model.driven_names]]
    way = np.stack([start, start + 0.03 * np.arange(1, len(start) + 1)])
    planned = fb.trapezoid(model, way, velocity=0.2, acceleration=1.0)
    read = fb.read_motion(model, fb.write_motion(model, planned, tmp_path / "motion.csv"))
    assert (read.notices, read.differentiated, len(read.jumps)) == ((), "", len(planned.jumps))
    assert len(planned.jumps)
    t = np.linspace(0.0, planned.duration, 777)
    for found, expected in zip(read.at(t), planned.at(t), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-7)


def test_the_command_plans_the_driven_joints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    Path("way.csv").write_text("theta1,theta2 (deg)\n1.9,60\n2.2,70\n")
    limits = ["--acceleration", "2"]
    assert run(["plan", "five_bar", "way.csv", *limits]) == 0
    told = capsys.readouterr().out
    assert "theta1    1.9 rad    2.2 rad" in told
    assert "B " not in told
    read = fb.read_motion(five_bar(), "motion.csv")
    np.testing.assert_allclose(read.q[-1, :2], [2.2, np.radians(70)], atol=1e-12)
    assert run(["plan", "five_bar", "1.9, 1; 2.2, 1.2", *limits]) == 0
    assert run(["plan", "five_bar", "1.9; 2.2", *limits]) == 2
    assert "'five_bar' has 2 driven joints: theta1 and theta2." in capsys.readouterr().err
