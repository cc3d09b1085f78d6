"""`freebody simulate`: the same as `fb.simulate`, files that others read, torques from a file, and
what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.command import example, help_of, run


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_limp_arm_is_what_simulate_gives_and_its_file_is_a_motion(capsys):
    assert run(["simulate", "2R", "--q", "30 deg, -0.5", "--time", "0.5", "--every", "0.1"]) == 0
    model = fb.load("2R")
    found = fb.simulate(model, [np.pi / 6, -0.5], [0, 0], np.linspace(0, 0.5, 6))
    motion = fb.read_motion(model, "motion.csv")
    for name in ("q", "qd", "qdd"):
        assert np.abs(getattr(motion, name) - found[name].values).max() < 1e-12
    out = capsys.readouterr().out
    assert "2R: 0.5 s by DOP853." in out
    assert "written: motion.csv" in out


def test_the_example_holds_its_goal():
    assert run(_words(example(help_of("simulate")))) == 0
    motion = fb.read_motion(fb.load("2R"), "motion.csv")
    assert motion.q[-1] == pytest.approx([1.0, 0.5], abs=1e-3)


def _words(text: str) -> list[str]:
    import shlex

    return shlex.split(text)


def test_torques_of_a_file_with_units_and_passive_joints():
    rows = "t [ms], joint1 (kN m)\n0, 0\n200, 0.01\n400, -0.02\n"
    with open("torques.csv", "w", encoding="utf-8") as file:
        file.write(rows)
    options = ["--torque", "torques.csv", "--q", "0, 0", "--friction", "dry"]
    assert run(["simulate", "pendubot", *options, "--restitution", "0"]) == 2  # it has no stops
    assert run(["simulate", "pendubot", *options, "--out", "way.csv"]) == 0
    model = fb.load("pendubot")
    table = np.array([[0.0, 0.0], [10.0, 0.0], [-20.0, 0.0]])
    t = [0.0, 0.2, 0.4]
    found = fb.simulate(model, [0, 0], [0, 0], t, table, friction="dry")
    motion = fb.read_motion(model, "way.csv")
    places = np.searchsorted(motion.t, t)
    assert len(motion.t) == 401
    assert np.abs(motion.q[places] - found.q.values).max() < 1e-8


def test_a_closed_chain_is_assembled_and_its_motion_studied_again():
    assert run(["simulate", "five_bar", "--time", "0.2", "--every", "0.02"]) == 0
    model = fb.load("five_bar")
    found = fb.simulate(model, fb.assemble(model), np.zeros(4), np.linspace(0, 0.2, 11))
    motion = fb.read_motion(model, "motion.csv")
    assert np.abs(motion.q - found.q.values).max() < 1e-9


def test_the_error_under_computed_torque_obeys_its_own_equation():
    """Critically damped at 10 rad/s: e = e0 (1 + 10 t) exp(-10 t), the same for both joints."""
    goal = ["--torque", "computed_torque", "--goal", "1, 0.5", "--time", "1"]
    assert run(["simulate", "2R", "--q", "0.2, -0.3", *goal]) == 0
    motion = fb.read_motion(fb.load("2R"), "motion.csv")
    decay = ((1 + 10 * motion.t) * np.exp(-10 * motion.t))[:, None]
    assert np.abs(motion.q - ([1, 0.5] - decay * [0.8, 0.8])).max() < 1e-6


REFUSED = [
    (["--q", "1"], "--q has 1 values, '2R' takes 2"),
    (["--time", "0"], "--time is 0, expected seconds above 0"),
    (["--time", "1", "--every", "1e-9"], "makes 1e+09 rows"),
    (["--time", "1", "--every", "1"], "makes 2 rows of 1 s; a motion has from 4"),
    (["--kp", "3"], "--kp is of a control law, --torque pd or computed_torque"),
    (["--torque", "pd", "--kp", "-3"], "kp is -3 for 'joint1'"),
    (["--torque", "none.csv"], "'none.csv': there is no such file; write pd, computed_torque"),
    (["--restitution", "2"], "restitution is 2, expected from 0"),
    (["--method", "euler"], "no method 'euler'"),
]


@pytest.mark.parametrize(("options", "words"), REFUSED)
def test_what_is_refused_in_one_line(options: list[str], words: str, capsys):
    assert run(["simulate", "2R", *options]) == 2
    told = capsys.readouterr().err
    assert words in " ".join(told.split())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,joint1\n0,0\n1,0\n", "there is no column for 'joint2'"),
        ("t,joint1,joint2\n0,0,0\n", "fewer than two rows"),
        ("t,joint1,joint2\n0,0,0\n0,1,1\n", "t = 0 does not come after 0"),
        ("t,joint1,joint3\n0,0,0\n1,0,0\n", "no column 'joint3'"),
        ("t,joint1,joint2 tau (N m)\n0,0,0\n1,0,0\n", "no column 'joint2 tau'"),
        ("t,joint1 (N),joint2\n0,0,0\n1,0,0\n", "'N' is not a unit of a torque"),
    ],
)
def test_faulty_files_of_torques_are_refused_with_their_line(text: str, words: str, capsys):
    with open("torques.csv", "w", encoding="utf-8") as file:
        file.write(text)
    assert run(["simulate", "2R", "--torque", "torques.csv"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert words in told
    assert "torques.csv:" in told
