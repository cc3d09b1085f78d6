"""The command `freebody size`: from a duty cycle and a catalogue to motors and gears."""

from __future__ import annotations

from pathlib import Path

import pytest

import freebody as fb
from support.command import told

CYCLE = """
[[segment]]
points = [[0, 0], ["60 deg", "-40 deg"]]
times = [0, 0.8]
payload = { mass = 2, com = [0.05, 0] }
dwell = 0.2

[[segment]]
points = [["60 deg", "-40 deg"], [0, 0]]
times = [0, 0.8]
dwell = 0.2
"""


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    Path("cycle.toml").write_text(CYCLE)


@pytest.mark.usefixtures("numpy_kernels")
def test_loaded_there_empty_back():
    arm = fb.load("2R")
    options = (
        f"--motion cycle.toml --life 5000 --hold --rejected {arm.joint_names[0]} --out sized.toml"
    )
    status, said = told(["size", "2R", "--catalogue", "invented", *options.split()])
    assert status == 0, said
    text = " ".join(said.split())
    assert "no maker sells any of it" in text
    assert "Duty cycle: 2 segments in 2 s; cycle.toml" in text
    assert "again: freebody size 2R" in text
    assert "used, at most 100 %" in text
    sized = fb.load("sized.toml")
    mine = fb.size(arm, fb.DutyCycle.read(arm, "cycle.toml"), fb.catalogue("invented"), life=5000.0)
    motor, gear = mine.choices[0].drives[arm.joint_names[0]]
    assert motor.name in text
    held = fb.size(arm, mine.cycles, fb.catalogue("invented"), life=5000.0, hold=True).heaviest()
    assert f"{held!r}"[1:-1] in text
    assert fb.parameters(sized)[f"{arm.joint_names[0]}.rotor.gear"].value == gear.factor
    q = [[0.1, 0.2]]
    expected = fb.mass_matrix(mine.drive_loads().model, q)
    assert fb.mass_matrix(sized, q) == pytest.approx(expected, rel=1e-12)


def test_what_does_not_suffice_exits_with_1():
    Path("parts.toml").write_text(
        "[[motor]]\nname='M'\ninertia=1e-6\ncontinuous_torque=0.001\npeak_torque=0.002\n"
        "max_speed='100 rpm'\nmass=0.1\n[[gear]]\nname='G'\nratio=10\nefficiency=0.9\n"
        "inertia=0\nmass=0.1\n"
    )
    status, said = told(["size", "2R", "--catalogue", "parts.toml", "--motion", "cycle.toml"])
    assert status == 1
    assert "suffices for joint" in said
    status, said = told(["size", "2R", "--catalogue", "nowhere.toml"])
    assert status == 2
    assert "there is no such file" in said
