"""The largest payload along motions and at postures, and load diagrams: the robot that carries it
is at one limit, and beyond none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import error, run

WAY = [[0, -1, 1, 0, 0, 0], [1, -0.5, 0.5, 0.3, 0.2, 0.1]]


@pytest.fixture(scope="module")
def arm() -> fb.Model:
    return fb.load("ur5e")


def share(model: fb.Model, motion: fb.Motion, effort: np.ndarray, wrenches=None) -> np.ndarray:
    """The largest torque of each drive over its limit, at ten thousand instants."""
    t = np.linspace(motion.t[0], motion.t[-1], 10_001)
    tau = fb.inverse_dynamics(model, *motion.at(t), wrenches)
    return np.abs(tau).max(axis=0) / effort


@pytest.mark.parametrize("planner", ["quintic", "trapezoid"])
@pytest.mark.parametrize(
    "load", [{}, {"com": [0.05, 0.0, 0.2]}, {"com": [0, 0, 0.1], "box": (0.2, 0.2, 0.4)}]
)
def test_that_mass_and_no_more(arm, planner, load):
    """Some drive is at its limit then, none beyond; with jumps of accelerations too."""
    motion = getattr(fb, planner)(arm, WAY, [0.0, 1.0], acceleration=30.0)
    found = fb.payload(arm, motion, **load)
    most = share(arm.with_payload(float(found.mass), **load), motion, arm.limits.effort)
    assert most.max() == pytest.approx(1.0, abs=2e-5)
    assert int(np.argmax(most)) == found.joint
    k = int(found.joint)
    alone = np.argsort(found.by_joint)[1]
    other = share(arm.with_payload(float(found.by_joint[alone]), **load), motion, arm.limits.effort)
    assert other[alone] == pytest.approx(1.0, abs=1e-3)
    time = np.full(2, float(found.time))  # accelerations may jump there
    carrying = arm.with_payload(float(found.mass), **load)
    sides = fb.inverse_dynamics(carrying, *motion.at(time, time + [-1e-6, 1e-6]))
    assert np.abs(sides[:, k]).max() == pytest.approx(arm.limits.effort[k], rel=1e-4)


def test_gears_that_lose_torque_friction_and_rotors(arm):
    """What gears lose depends on the way of the power, which the payload may turn round."""
    model = arm
    for name in arm.joint_names:
        model = model.with_drive(name, rotor=1e-4, gear=100.0, viscous=3.0, coulomb=4.0)
    lossy = model
    for name in arm.joint_names:
        lossy = lossy.with_drive(name, efficiency=0.7, back_efficiency=0.5)
    for robot in (model, lossy):
        motion = fb.quintic(robot, [WAY[1], WAY[0]], [0.0, 1.5])
        found = fb.payload(robot, motion)
        carrying = robot.with_payload(float(found.mass))
        most = share(carrying, motion, arm.limits.effort)
        assert most.max() == pytest.approx(1.0, abs=2e-5)
        assert int(np.argmax(most)) == found.joint
    assert fb.payload(lossy, motion).mass < fb.payload(model, motion).mass


def test_many_motions_are_each_alone_and_postures_are_the_map(arm):
    q, _, _ = fb.random_state(arm, 3, 8)
    motions = [fb.quintic(arm, q[k : k + 2], [0.0, 9.0]) for k in range(4)]
    every = fb.payload(arm, motions, com=[0, 0, 0.1])
    for k, motion in enumerate(motions):
        one = fb.payload(arm, motion, com=[0, 0, 0.1])
        assert (one.mass, one.joint, one.time) == (every.mass[k], every.joint[k], every.time[k])
    least = np.floor(10 * every.mass.min()) / 10  # three digits, and no more than it carries
    assert every.card.startswith(
        f"carries {least:.1f} kg by its effort limits on each of 4 paths · "
    )
    still = fb.payload(arm, q, com=[0.1, 0.0, 0.2])
    known = fb.payload_map(arm, q, point=[0.1, 0.0, 0.2])
    assert np.allclose(still.mass, known.mass, rtol=1e-10)
    assert (still.joint == known.joint).all()
    assert still.to_xarray()["mass"].dims == ("case",)
    loaded = fb.payload(arm.with_payload(2.0, com=[0.1, 0.0, 0.2]), q, com=[0.1, 0.0, 0.2])
    assert np.allclose(loaded.mass, still.mass - 2.0, rtol=1e-9)


def test_a_wrench_and_a_closed_chain():
    model = fb.load("five_bar")
    closed = fb.assemble(model, {"theta1": 2.0, "theta2": 0.9})
    effort = [40.0, 25.0, 1.0, 1.0]
    pull = {"P": [0.0, -5.0, 0.0]}
    found = fb.payload(model, closed, effort=effort, wrenches=pull)
    tau = fb.static_torque(model.with_payload(float(found.mass), frame=model.tip), closed, pull)
    assert (np.abs(tau) / effort).max() == pytest.approx(1.0, abs=1e-10)
    named = fb.payload(model, closed, effort={"theta1": 40.0, "theta2": 25.0})
    assert found.mass < named.mass == fb.payload(model, closed, effort=effort).mass


def test_the_card(arm):
    motion = fb.quintic(arm, WAY, [0.0, 1.0])
    found = fb.payload(arm, motion)
    mass, factor = (np.floor(10.0 * x) / 10.0 for x in (found.mass, found.faster))  # rounded down
    carried = f"carries {mass:.1f} kg by its effort limits on this path · "
    assert found.card.startswith(f"{carried}shoulder_lift_joint limits at t = ")
    assert found.card.endswith(f"without it {factor:.1f} times as fast")
    quick = motion.faster(found.faster * (1 - 1e-6))
    assert fb.study(arm, quick).verdict.outcome != "not feasible"
    assert found.carries
    fast = fb.payload(arm, motion.faster(8.0))
    assert "would exceed the speed limit" in fast.card
    assert not fast.carries
    t = np.linspace(0.0, 9.0, 91)
    q, qd = np.outer(t, [0.8, 0, 0, 0, 0, 0]) + WAY[0], np.tile([0.8, 0, 0, 0, 0, 0], (91, 1))
    far = fb.Motion.of(arm, t, q, qd, 0.0 * qd)  # 2π is passed
    for where, words in ((far, "on this path"), (far.q[-1], "at this posture")):
        out = fb.payload(arm, where)
        assert out.outside == ("shoulder_pan_joint",)
        assert out.card == f"not {words}: shoulder_pan_joint would leave the position range"
        assert not out.carries
    weak = fb.payload(arm, motion, effort=np.full(6, 20.0))
    assert "carries nothing on this path · shoulder_lift_joint is overloaded" in weak.card
    assert weak.mass == 0.0
    assert weak.overloaded
    most = [np.inf, 1e3, np.inf, np.inf, np.inf, np.inf]
    assert "shoulder_lift_joint limits" in fb.payload(arm, motion, effort=most).card
    rod = fb.planar("R", l=[1.0], lc=[0.5], m=[2.0], I=[0.1])
    hangs = fb.payload(rod, [-np.pi / 2], effort=[30.0])  # of which the cosine is 6e-17
    assert hangs.card == "carries any mass at this posture: no effort limit is in the way"
    free = fb.payload(arm.replace(gravity=[0, 0, 0]), [0.0] * 6)
    assert free.card == "carries any mass at this posture: no effort limit is in the way"
    bare = fb.planar("R", l=[1.0], limits=[fb.Limits(effort=5.0)])
    assert fb.payload(bare.bind(lc1=0.0, m1=0.0, I1=0.0), [0.0]).card.startswith("not judged")


def test_a_load_diagram_by_hand(tmp_path: Path):
    """M g (L + d) + m g lc at the drive's torque: a hyperbola over the offset d."""
    limits = [fb.Limits(effort=100.0)]
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1], limits=limits)
    found = fb.load_diagram(arm, [0.0], offsets=[0.0, 0.1, 0.4])
    by_hand = (100.0 / 9.81 - 3.0) / (2.0 + np.array([0.0, 0.1, 0.4]))
    assert found.mass == pytest.approx(by_hand, rel=1e-12)
    assert found.to_xarray()["mass"].dims == ("offset",)
    # rounded down: 3.5968 and 2.9973
    assert "3.59 kg at 0 mm to 2.99 kg at 400 mm along x of 'tip', by its effort limits" in repr(
        found
    )
    free = fb.load_diagram(arm, [np.pi / 2], effort=[np.inf])
    assert "any mass at 0 mm" in repr(free)
    text = found.save(tmp_path / "loads.svg").read_text("utf-8")
    for words in ("offset in mm", "kg", "joint1", "offset along x of tip, by its effort limits"):
        assert words in text


def test_the_command(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("ur5e")
    motion = fb.quintic(arm, WAY, [0.0, 1.0])
    fb.write_motion(arm, motion, "pick.csv")
    asked = ["payload", "ur5e", "--motion", "pick.csv", "--out", "loads.svg", "--farthest", "200"]
    assert run(asked) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith(fb.payload(arm, fb.read_motion(arm, "pick.csv")).card[:30])
    assert "Load: none. Mounting: base fixed" in said
    assert said.endswith(f"again: freebody {' '.join(asked)}")
    assert "offset in mm" in Path("loads.svg").read_text("utf-8")
    assert run(["payload", "ur5e", "--postures", "200", "--mounting", "wall"]) == 0
    assert "at each of 200 postures" in capsys.readouterr().out
    assert run(["payload", "ur5e", "--motion", "pick.csv", "--speed", "8"]) == 1
    assert "speed limit" in capsys.readouterr().out
    assert run(["payload", "2R", "--q", "0,0", "--effort", "500,200"]) == 0
    by_code = fb.payload(fb.load("2R"), [0.0, 0.0], effort=[500.0, 200.0]).card
    assert by_code in " ".join(capsys.readouterr().out.split())
    asked = ["payload", "ur5e", "--q", "0,0,0,0,0,0", "--catalogue", "invented"]
    fitted = ["--brake", "elbow_joint=M200,W25-100", "--bearing", "elbow_joint=B70"]
    assert run([*asked, *fitted]) == 0
    parts, elbow = fb.catalogue("invented"), "elbow_joint"
    by_code = fb.payload(
        arm, [0.0] * 6, bearings={elbow: parts.bearing("B70")},
        brakes={elbow: (parts.motor("M200"), parts.gear("W25-100"))},
    )  # fmt: skip
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith(by_code.card)
    assert "brake of elbow_joint (M200)" in said
    for words, *more in (
        ("--bearing: give the file in which the parts are", "--bearing", "elbow_joint=B70"),
        ("--catalogue: say which of its parts", "--catalogue", "invented"),
        ("no bearing 'B7'", "--catalogue", "invented", "--bearing", "elbow_joint=B7"),
        ("give a motion or a posture", "--motion", "pick.csv", "--q", "0"),
        ("--speed: there is no motion", "--speed", "2"),
        ("the load diagram has offsets of its own", "--q", "0,0,0,0,0,0", "--com", "0,0,1",
         "--out", "x.svg"),
    ):  # fmt: skip
        assert words in error(capsys, "payload", "ur5e", *more)


def test_refusals(arm):
    for words, call in (
        ("no joint of 'R' has an effort limit", lambda: fb.payload(
            fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1]), [0.0])),
        ("'joint1' of 'acrobot' is passive", lambda: fb.payload(
            fb.load("acrobot"), [0.0, 0.0], effort=[1.0] * 2)),
        ("one positive number", lambda: fb.payload(arm, WAY, effort=[-1.0] * 6)),
        ("the motion has 2 positions", lambda: fb.payload(
            arm, fb.quintic(fb.load("2R"), [[0, 0], [1, 1]], [0, 1]))),
        ("there are no postures", lambda: fb.load_diagram(arm, np.zeros((0, 6)))),
        ("offsets must increase", lambda: fb.load_diagram(arm, WAY, offsets=[0.0, 0.0])),
        ("no axis 'w'", lambda: fb.load_diagram(arm, WAY, along="w")),
        ("at least two, along an axis", lambda: fb.load_diagram(arm, WAY, offsets=[0.1])),
    ):  # fmt: skip
        with pytest.raises(fb.FreebodyError, match=words):
            call()
