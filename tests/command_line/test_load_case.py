"""The options of the load case: each command uses what it accepts, and refuses the rest with its
reason."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import error, run


@pytest.mark.parametrize(
    ("name", "mounting", "down"),
    [
        ("ur5e", "floor", [0, 0, -1]),
        ("ur5e", "wall", [1, 0, 0]),
        ("ur5e", "ceiling", [0, 0, 1]),
        ("ur5e", "30 deg, 0, 0.4", [0, -0.5, -np.sqrt(0.75)]),
        ("ur5e", "0, 30 deg, 90 deg", [0.5, 0, -np.sqrt(0.75)]),
        ("2R", "wall", [-1, 0]),
        ("2R", "ceiling", [0, 1]),
        ("2R", "30 deg", [-0.5, -np.sqrt(0.75)]),
        ("stewart", "ceiling", [0, 0, 1]),  # its platform is free but for the legs
    ],
)
def test_gravity_as_the_turned_base_feels_it(name, mounting, down, tmp_path):
    """The angles are those of URDF: of the base against the floor, roll first."""
    file = tmp_path / "arm.toml"
    assert run(["convert", name, str(file), "--mounting", mounting]) == 0
    model = fb.load(file)
    assert model.gravity == pytest.approx(9.81 * np.array(down), abs=1e-12)


def test_the_case_is_the_models(tmp_path):
    file = tmp_path / "arm.toml"
    case = ["--gravity", "0, -1.6", "--payload", "2@0.1,0"]
    assert run(["convert", "2R", str(file), *case]) == 0
    changed = fb.load("2R").with_payload(2.0, com=[0.1, 0.0]).replace(gravity=[0.0, -1.6])
    assert fb.load(file) == changed


def test_a_wrench_moves_the_robot(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = ["simulate", "2R", "--time", "0.5", "--gravity", "0,0", "--wrench", "tip:0,-5,1",
             "--wrench", "link2: 1, 0, 0"]  # fmt: skip
    assert run(asked) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Wrenches: force (0, -5) N and moment (1) N m at tip; force (1, 0) N" in said
    found = fb.read_motion(fb.load("2R"), tmp_path / "motion.csv").q
    model, t = fb.load("2R").replace(gravity=[0.0, 0.0]), np.linspace(0.0, 0.5, 401)
    exact = fb.simulate(
        model, [0, 0], [0, 0], t, wrenches={"tip": [0.0, -5.0, 1.0], "link2": [1.0, 0.0, 0.0]}
    )
    assert found == pytest.approx(exact["q"].values, abs=1e-6)
    way = ["plan", "2R", "0,0;1,1", "--by", "time-optimal", "--torque", "200"]
    motions = []
    for more in ([], ["--wrench", "tip:0,-20,0"]):
        assert run([*way, *more]) == 0
        motions.append(fb.read_motion(fb.load("2R"), tmp_path / "motion.csv").duration)
    assert motions[1] > 1.05 * motions[0]


def test_a_study_at_another_speed(tmp_path: Path, monkeypatch, capsys):
    """Half as fast, what grows with the square of the speed is a quarter, and the case says so."""
    monkeypatch.chdir(tmp_path)
    model = fb.load("2R")
    fb.write_motion(model, fb.quintic(model, [[0, 0], [1, 1]], [0.0, 1.0]), "way.csv")
    asked = ["study", "2R", "--motion", "way.csv", "--speed", "0.5", "--mounting", "ceiling"]
    assert run([*asked, "--out", "slow"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "gravity (0, 9.81) m/s² in world axes." in said
    assert "Speed: the motion is run 0.5 times as fast as given." in said
    assert f"again: freebody {' '.join(asked)} --out slow" in said
    about = json.loads(Path("slow/manifest.json").read_text("utf-8"))["about"]
    assert about["speed"].startswith("the motion is run 0.5 times")
    slow, fast = (fb.study(model, "way.csv", speed=x) for x in (0.5, 1.0))
    assert slow.motion.duration == pytest.approx(2.0)
    inertial = [np.abs(x.data["tau_coriolis"].values).max() for x in (slow, fast)]
    assert inertial[0] == pytest.approx(inertial[1] / 4, rel=1e-3)


def test_what_a_command_cannot_use_is_refused_with_its_reason(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words, *asked in (
        ("--speed: the torques make the motion", "simulate", "2R", "--speed", "2"),
        ("--wrench: spline holds no limits of torque", "plan", "2R", "0,0;1,1", "--wrench",
         "tip:1,0,0", "--acceleration", "2"),
        ("--wrench: show tells what the robot is made of", "show", "2R", "--wrench", "tip:1,0,0"),
        ("--speed: a free-body diagram is of one instant", "fbd", "2R", "--speed", "2"),
        ("--gravity and --mounting both say", "show", "2R", "--gravity", "0,1", "--mounting",
         "wall"),
        ("--gravity 'down': write the field x,y (m/s², world axes)", "show", "2R", "--gravity",
         "down"),
        ("--gravity '1,2,3': write the field x,y", "show", "2R", "--gravity", "1,2,3"),
        ("--mounting 'roof': '", "show", "2R", "--mounting", "roof"),
        ("--mounting '1,2': write floor, wall, ceiling", "show", "2R", "--mounting", "1,2"),
        ("--mounting: the base of 'quadrotor' is free", "show", "quadrotor", "--mounting", "wall"),
        ("--wrench '1,2,3': write FRAME:fx,fy,m", "simulate", "2R", "--wrench", "1,2,3"),
        ("--wrench: frame 'tip' has two wrenches", "simulate", "2R", "--wrench", "tip:1,0,0",
         "--wrench", "tip:1,0,0"),
        ("no frame 'hand'", "simulate", "2R", "--wrench", "hand:1,0,0"),
        ("--speed '-1': write a factor above 0", "study", "2R", "--speed", "-1"),
        ("--gravity is given 2 times; give it once.", "show", "2R", "--gravity", "0,1", "--gravity",
         "0,2"),
        ("--motion is given 2 times", "study", "2R", "--motion", "a.csv", "--cycle", "b.toml"),
        ("--lock: 'joint2' is given twice", "show", "2R", "--lock", "joint2=0", "--lock",
         "joint2=1"),
        ("--parameter: 'l1' is given twice", "show", "2R", "--parameter", "l1=1", "--parameter",
         "l1=2"),
    ):  # fmt: skip
        assert words in error(capsys, *asked)


def test_several_payloads_are_all_carried(tmp_path: Path):
    file = tmp_path / "arm.toml"
    two = ["--payload", "2@0.1,0", "--payload", "0.5"]
    assert run(["convert", "2R", str(file), *two]) == 0
    both = fb.load("2R").with_payload(2.0, com=[0.1, 0.0]).with_payload(0.5, name="payload2")
    assert fb.load(file) == both


def test_derive_in_another_field_and_mounting(tmp_path: Path, capsys):
    """At a wall the base feels gravity along its -x."""
    for case, term in ((["--gravity", "3,0"], "3 m₁ lc₁ sin θ₁"),
                       (["--mounting", "wall"], "− 9.81 m₁ lc₁ sin θ₁")):  # fmt: skip
        assert run(["derive", "2R", *case]) == 0
        assert term in " ".join(capsys.readouterr().out.split())
    assert "give one of them" in error(
        capsys, "derive", "2R", "--gravity", "3,0", "--mounting", "wall"
    )


def test_a_robot_is_shown_and_exported_in_its_case(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["show", "2R", "--payload", "5", "--mounting", "ceiling"]) == 0
    mass = fb.load("2R").mass + 5.0
    assert f"{mass:.6g} kg; gravity [0, 9.81] m/s²" in capsys.readouterr().out
    assert run(["export", "2R", "gravity_torque", "--language", "numpy", "--payload", "5"]) == 0
    text = "".join(p.read_text("utf-8") for p in Path("export-2R").glob("*.py"))
    loaded = fb.load("2R").with_payload(5.0)
    assert fb.source(loaded, "gravity_torque", "numpy").split("def ")[-1] in text


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["2R", "ur5e", "five_bar"])
def test_a_study_under_a_wrench(name):
    """Its torques, parts, reactions and replay agree with each other, and with those of the robot
    that is not pulled."""
    model = fb.load(name)
    pull = [20.0, -30.0, 4.0] if model.dim == 2 else [20.0, -30.0, 10.0, 1.0, 2.0, 4.0]
    assert model.tip
    load = {model.tip: np.array(pull)}
    plain = fb.study(model)
    found = fb.study(model, plain.motion, wrenches=load)
    assert found.checked
    assert {x.name for x in found.checks} == {x.name for x in plain.checks}
    at = found.motion.q, found.motion.qd, found.motion.qdd
    more = fb.inverse_dynamics(model, *at, load) - fb.inverse_dynamics(model, *at)
    assert np.allclose(found.data["tau_wrenches"], more, atol=1e-9)
    assert "tau_wrenches" not in plain.data
    assert model.loops or found.replay is not None
    same = fb.joint_wrenches(model, *at, load)[..., : model.dim]
    assert np.allclose(found.data["reaction_force"], same, atol=1e-9)


def test_the_commands_study_under_a_wrench(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = ["study", "2R", "--wrench", "tip:0,-30,0", "--out", "s"]
    assert run(asked) == 0
    said = " ".join(capsys.readouterr().out.split())
    told = "force (0, -30) N and moment (0) N m at tip, exerted on the robot, world axes."
    assert f"Wrenches: {told}" in said
    assert json.loads(Path("s/manifest.json").read_text("utf-8"))["about"]["wrenches"] == told
    page = Path("s/report.html").read_text("utf-8")
    assert f"<dt>Wrenches</dt><dd>{told.replace('-', '−')}</dd>" in page
    assert "tau_wrenches" in Path("s/torques.csv").read_text("utf-8").splitlines()[0]


def test_a_duty_cycle_in_the_place_of_a_motion(tmp_path: Path, monkeypatch, capsys):
    """One option, whatever the file holds, and whatever it is called."""
    monkeypatch.chdir(tmp_path)
    Path("cycle.toml").write_text(
        "[[segment]]\npoints = [[0, 0], [1, 0.5]]\ntimes = [0, 0.8]\npayload = { mass = 1 }\n"
        "dwell = 0.2\n[[segment]]\npoints = [[1, 0.5], [0, 0]]\ntimes = [0, 1]\n"
    )
    assert run(["study", "2R", "--cycle", "cycle.toml", "--speed", "0.5", "--out", "out"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Duty cycle: cycle.toml." in said
    assert "Segment 1. Load: payload, 1 kg at (0, 0) m in tip" in said
    assert "Segment 2. Load: none." in said
    assert "In 3.8 s the drives do" in said
    assert Path("out/segment-2/report.html").is_file()
    case = json.loads(Path("out/card.json").read_text("utf-8"))["load_cases"]
    assert [x["payload"] for x in case] == [1.0, 0.0]
    asked = ["payload", "2R", "--effort", "900,400", "--motion", "cycle.toml"]
    assert run(asked) == 0
    assert "on each of 2 paths" in capsys.readouterr().out
    asked = ["study", "2R", "--cycle", "cycle.toml", "--out", "o", "--smooth", "auto"]
    assert "smooth is for one motion" in error(capsys, *asked)
    asked = ["payload", "2R", "--cycle", "cycle.toml", "--smooth", "8"]
    assert "--smooth is for one motion, and cycle.toml is a duty cycle" in error(capsys, *asked)
