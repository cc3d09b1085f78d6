"""Time-optimal motions of closed chains: a parallelogram is as quick as its pendulum, torques of
the drives are held and reached, as inverse dynamics tells."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import freebody as fb
from support.command import run

FRICTION = {"viscous": 0.4, "coulomb": 0.5}


def parallelogram(**drive: float) -> fb.Model:
    """Cranks of 0.6 m, a coupler that stays level; in each joint what drives have besides."""
    model = fb.load("four_bar").bind(l1=0.6, l3=0.6, d=0.8, l2=0.8)
    for joint in model.joint_names if drive else ():
        model = model.with_drive(joint, **drive)
    return model


def its_pendulum(**drive: float) -> fb.Model:
    """The same motion of one body: all that turns, and the coupler, which does not, at the cranks'
    ends."""
    p = {x.name: x.value for x in fb.parameters(parallelogram())}
    mass = p["m1"] + p["m2"] + p["m3"]
    first = p["m1"] * p["lc1"] + p["m3"] * p["lc3"] + p["m2"] * 0.6
    second = sum(p[f"I{k}"] + p[f"m{k}"] * p[f"lc{k}"] ** 2 for k in (1, 3)) + p["m2"] * 0.36
    model = fb.planar("R").bind(l1=0.6, m1=mass, lc1=first / mass, I1=second - first**2 / mass)
    return model.with_drive("joint1", **{k: 3.0 * x for k, x in drive.items()}) if drive else model


@pytest.mark.parametrize("friction", [{}, FRICTION])
def test_a_parallelogram_is_as_quick_as_its_pendulum(friction: dict[str, float]):
    angles = np.array([0.5, 1.4, 2.6])
    way = angles[:, None] * [1.0, -1.0, 1.0]
    limits: dict[str, Any] = {"torque": 40.0, "velocity": 4.0, "points": 2001}
    found = fb.time_optimal(parallelogram(**friction), way, **limits)
    single = fb.time_optimal(its_pendulum(**friction), angles[:, None], **limits)
    assert found.duration == pytest.approx(single.duration, rel=1e-7)
    t = np.linspace(0.0, 0.9999, 300) * single.duration
    q, qd, _ = found.at(t)
    theta, rate, _ = single.at(t)
    assert q == pytest.approx(theta * [1.0, -1.0, 1.0], abs=1e-6)
    assert qd == pytest.approx(rate * [1.0, -1.0, 1.0], abs=1e-5)


WAY = np.array([[1.9, 1.0], [2.2, 1.2], [2.0, 0.8]])


@pytest.mark.sample(1)
@pytest.mark.parametrize("wrench", [None, [3.0, -4.0, 0.5]])
def test_torques_of_the_drives_are_held_and_reached(wrench: list[float] | None):
    model = fb.load("five_bar").with_drive("theta2", rotor=0.02).with_payload(0.5)
    for joint in model.joint_names:  # those that nothing drives have friction too
        model = model.with_drive(joint, **FRICTION)
    most = np.array([9.0, 11.0, 0.0, 0.0])
    motion = fb.time_optimal(model, WAY, torque=most + [0, 0, 0.1, 0.1], wrenches=wrench)
    assert motion.notices == ()
    t = np.linspace(0.0, motion.duration, 3001)[1:-1]
    q, qd, qdd = motion.at(t)
    fb.loop_velocity(model, q, {"theta1": qd[:, 0], "theta2": qd[:, 1]})  # closed all the way
    torque = np.abs(fb.inverse_dynamics(model, q, qd, qdd, wrench))
    assert (torque <= most * 1.001).all()
    assert np.mean((torque[:, :2] / most[:2]).max(axis=1) > 0.98) > 0.95


POINTER = """
[[link]]
name = "pointer"
mass = 1.0
com = [0.3, 0]
inertia = 0.01

[[joint]]
name = "gauge"
kind = "revolute"
parent = "ground"
child = "pointer"
mimic = { joint = "theta1" }
limits = { effort = 2.0 }
"""


def test_limits_of_followers_are_not_held_and_that_is_said():
    text = (files("freebody.robots") / "templates" / "five_bar.toml").read_text()
    model = fb.load(text=text.replace("masses_estimated", "#") + POINTER, format="toml")
    limits = {"theta1": 9.0, "theta2": 11.0}
    motion = fb.time_optimal(model, WAY, torque=[9.0, 11.0, 0.1, 0.1], points=201)
    (notice,) = motion.notices
    assert notice.startswith("What the loops bring to gauge is not held within its own limit")
    judged = fb.payload(model, motion, effort=limits)
    assert "gauge is overloaded already" in judged.card


def test_near_a_singular_position_loops_stay_closed_and_torques_are_held():
    """A coupler 10 µm longer than the parallelogram's: it passes crank and coupler in line, where
    the rocker turns quickly. Inverse dynamics refuses rates that open a loop."""
    model = fb.load("four_bar").bind(l1=0.6, l3=0.6, d=0.8, l2=0.80001)
    quick = fb.time_optimal(model, [[0.5], [3.7]], torque=40.0)
    t = np.linspace(0.0, quick.duration, 20001)[1:-1]
    assert np.abs(fb.inverse_dynamics(model, *quick.at(t))).max() < 40.0
    slow = fb.quintic(model, [[0.5], [3.7]], velocity=2.0)
    fb.inverse_dynamics(model, *slow.at(np.linspace(0.0, slow.duration, 20001)))


def test_joints_that_are_led_have_limits_too():
    model = fb.load("five_bar")
    model = model.bind({"B.limits.velocity": 0.7})
    motion = fb.time_optimal(model, WAY, torque=5.0)
    speed = motion.peaks.velocity.size
    assert speed[2] == pytest.approx(0.7, rel=1e-4)
    assert speed[2] < 0.7
    slow = fb.time_optimal(model, WAY, acceleration=[np.inf, np.inf, 2.0, np.inf], torque=5.0)
    assert np.abs(slow.qdd[:, 2]).max() == pytest.approx(2.0, rel=1e-3)


def test_paths_given_in_other_ways_are_the_same():
    model = fb.load("five_bar")
    plain = fb.time_optimal(model, WAY, torque=5.0)
    closed = [fb.assemble(model, fb.time_optimal(model, WAY, torque=5.0).q[0])]
    for point in WAY[1:]:
        closed.append(fb.assemble(model, [*point, *closed[-1][2:]], free=["B", "D"]))
    assert fb.time_optimal(model, closed, torque=5.0).duration == pytest.approx(plain.duration)
    several = fb.time_optimal(model, np.stack([WAY, WAY[::-1]]), torque=5.0)
    assert isinstance(several, tuple)
    assert several[0] == plain
    again = fb.time_optimal(model, plain, torque=5.0)
    assert again.duration == pytest.approx(plain.duration, rel=1e-3)


def flat() -> Any:
    """Through where a parallelogram's crank and coupler are in line."""
    way = np.array([[0.5], [3.6]]) * [1.0, -1.0, 1.0]
    return fb.time_optimal(parallelogram(), way, torque=40.0)


def shared() -> Any:
    model = fb.load("five_bar").replace(actuated=["theta1", "theta2", "B"])
    return fb.time_optimal(model, np.zeros((2, 3)), torque=5.0)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (flat, r"at s = 0\.85.* the drives of 'four_bar' do not determine its motion"),
        (shared, "3 drives for 2 independent motions"),
        (
            lambda: fb.time_optimal(fb.load("five_bar"), [[1.9, 1.0], [4.2, -1.0]], torque=5.0),
            r"block the driven joints at s = 0\.28.*theta1 = 2\.5",
        ),
        (
            lambda: fb.time_optimal(
                fb.load("five_bar"), CubicSpline([0, 1, 2], np.ones((3, 4))), torque=5.0
            ),
            "is a PPoly, and the positions of 'five_bar', a closed chain, must satisfy its loops",
        ),
        (
            lambda: fb.time_optimal(fb.load("five_bar"), WAY, torque=0.1),
            "theta2 needs 3.948 N m to move slowly, and its largest torque is 0.1 N m",
        ),
        (
            lambda: fb.time_optimal(fb.load("stewart"), np.zeros((2, 6)), torque=5.0),
            "positions are quaternions",
        ),
    ],
)
def test_what_cannot_be_is_refused(call: Callable[[], object], told: str):
    with pytest.raises(fb.FreebodyError, match=told):
        call()


def test_the_command_plans_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = tmp_path / "motion.csv"
    way = "1.9, 1.0; 2.2, 1.2; 2.0, 0.8"
    asked = ["plan", "five_bar", way, "--by", "time-optimal", "--torque", "5", "--out", str(file)]
    assert run(asked) == 0, capsys.readouterr()
    assert "Warning" not in capsys.readouterr().err
    read = fb.read_motion(fb.load("five_bar"), file)
    quick = fb.time_optimal(fb.load("five_bar"), WAY, torque=5.0)
    assert not read.notices
    np.testing.assert_allclose(read.jumps, quick.jumps, atol=1e-12)
    model, t = fb.load("five_bar"), np.linspace(0.0, 0.9999, 301) * quick.duration
    torques = [fb.inverse_dynamics(model, *motion.at(t)) for motion in (quick, read)]
    # of positions alone up to 5.467, not 4.999
    np.testing.assert_allclose(torques[1], torques[0], atol=1e-6)
    assert read.duration == pytest.approx(quick.duration, rel=1e-9)
