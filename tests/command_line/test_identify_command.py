"""`freebody identify`: what it prints, its files and its exit status."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import error, run

pytestmark = pytest.mark.usefixtures("numpy_kernels")


def written_log(path: Path, arm: fb.Model, seed: int, gains: float | None = None) -> None:
    """A log of a planar arm as CSV, with noise on its torques; with gains of currents."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 15.0, 0.01)
    a, b, c = rng.uniform(0.5, 1.0, (3, 2))
    w = np.array([1.3, 2.1])
    q = a * np.sin(w * t[:, None]) + b * np.cos(0.7 * w * t[:, None]) + c * np.sin(2.0 * t[:, None])
    qd, qdd = np.gradient(q, t, axis=0), np.gradient(np.gradient(q, t, axis=0), t, axis=0)
    tau = fb.inverse_dynamics(arm, q, qd, qdd)
    tau = tau + 0.01 * rng.normal(size=tau.shape)
    names = arm.velocity_names
    head = ["t", *(f"{x}.position" for x in names), *(f"{x}.velocity" for x in names)]
    head += [f"{x}.{'torque' if gains is None else 'current'}" for x in names]
    rows = np.column_stack([t, q, qd, tau / (gains or 1.0)])
    np.savetxt(path, rows, delimiter=",", header=",".join(head), comments="")


def test_a_robot_is_identified_from_files_and_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("2R").with_drive("joint1", viscous=0.4, coulomb=0.3, rotor=0.05)
    written_log(Path("run.csv"), arm, 0)
    written_log(Path("other.csv"), arm, 1)
    words = ["identify", "2R", "run.csv", "--validate", "other.csv", "--out", "found"]
    assert run([*words, "--friction", "viscous, coulomb"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.startswith("Predicts logs that it has not seen")
    robot = fb.load("found/model.toml")
    found = json.loads(Path("found/identification.json").read_text(encoding="utf-8"))
    values = {x["name"]: x for x in found["parameters"]}
    own = values["joint1.viscous"]
    assert own["value"] == pytest.approx(0.4, rel=0.03)
    assert own["lower"] < own["value"] < own["upper"]
    assert robot.bodies[0].joint.drive.viscous == pytest.approx(own["in_model"])
    assert "joint1.coulomb" in Path("found/report.txt").read_text(encoding="utf-8")
    assert [x["validation"] < 0.1 for x in found["joints"]] == [True, True]


def test_a_log_without_a_joint_is_read_where_that_joint_is_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("3R").with_locked({"joint3": np.pi / 6}).with_drive("joint1", viscous=0.4)
    written_log(Path("run.csv"), arm, 0)
    words = ["identify", "3R", "run.csv", "--friction", "viscous"]
    assert 'model.with_locked({"joint3": …}), --lock joint3=…' in error(capsys, *words)
    assert "write one number" in error(capsys, *words, "--lock", "joint3=1, 2")
    assert run([*words, "--lock", "joint3=30 deg", "--out", "found"]) == 1  # not validated
    found = json.loads(Path("found/identification.json").read_text(encoding="utf-8"))
    assert fb.load("found/model.toml").joint_names == ("joint1", "joint2")
    assert max(x["regression"] for x in found["joints"]) < 0.05


def test_a_payload_and_collisions_are_told_beside_a_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("2R").with_drive("joint1", viscous=0.4, coulomb=0.3, rotor=0.05)
    written_log(Path("run.csv"), arm, 0)
    written_log(Path("loaded.csv"), arm.with_payload(0.6, com=[0.02, 0.0]), 1)
    words = ["identify", "2R", "run.csv", "--validate", "run.csv", "--payload-of", "loaded.csv"]
    words += ["--collisions-in", "run.csv", "--friction", "viscous, coulomb", "--out", "found"]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "The load at tip weighs 0.6" in said or "The load at tip weighs 0.5" in said
    assert "No collision shows" in said
    found = json.loads(Path("found/identification.json").read_text(encoding="utf-8"))
    mass = found["payload"]["numbers"][0]
    assert mass["value"] == pytest.approx(0.6, rel=0.05)
    assert found["collisions"]["collisions"] == []
    assert "Payload" in Path("found/index.html").read_text(encoding="utf-8")
    carrying = fb.load("found/loaded.toml")
    assert fb.parameters(carrying)["payload.mass"].value == pytest.approx(mass["in_model"])


def test_a_weighed_load_tells_the_scale_of_currents_and_without_it_the_scale_is_in_doubt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("2R").with_drive("joint1", viscous=0.4, coulomb=0.3, rotor=0.05)
    written_log(Path("run.csv"), arm, 0, gains=2.5)
    written_log(Path("loaded.csv"), arm.with_payload(0.6, com=[0.02, 0.0]), 1, gains=2.5)
    words = ["identify", "2R", "run.csv", "--validate", "run.csv", "--friction", "viscous, coulomb"]
    searched = ["--collisions-in", "run.csv", "--out", "found"]
    assert run([*words, *searched, "--loaded", "loaded.csv", "--load", "0.6"]) == 0
    assert "the load of 0.6 kg tells" in capsys.readouterr().out
    found = json.loads(Path("found/identification.json").read_text(encoding="utf-8"))
    assert found["gains"] == pytest.approx([2.5, 2.5], rel=0.03)
    assert run([*words, *searched, "--masses", "1, 1"]) == 1
    said = capsys.readouterr().out
    assert said.count("right up to one factor, told to") == 1
    assert "error" not in said
    assert "have an unknown factor" in error(capsys, *words, "--payload-of", "loaded.csv")
    assert "--loaded and --load" in error(capsys, *words, "--loaded", "loaded.csv")


def test_the_nearest_physical_robot_and_a_wrong_length(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    arm = fb.load("2R").with_drive("joint1", viscous=0.4, coulomb=0.3, rotor=0.05)
    written_log(Path("run.csv"), arm, 0)
    longer = fb.planar("RR", l=[1.2, 1.0], lc=[0.5, 0.5], m=[2.0, 1.0], I=[0.2, 0.1])
    fb.save(longer, "longer.toml")
    words = ["run.csv", "--validate", "run.csv", "--friction", "viscous, coulomb"]
    assert run(["identify", "longer.toml", *words, "--out", "found"]) == 1
    assert "what it takes as known is wrong" in capsys.readouterr().out
    found = json.loads(Path("found/identification.json").read_text(encoding="utf-8"))
    assert not found["trusted"]
    assert found["structure"]["misplaced"]["displacement"]["joint"] == "joint2"
    assert all(x["lower"] is None for x in found["parameters"])
    assert 'class="ruling good"' not in Path("found/index.html").read_text(encoding="utf-8")
    pytest.importorskip("clarabel", reason="Clarabel is not installed (extra lmi)")
    assert run(["identify", "2R", *words, "--lmi"]) == 0
    assert "nothing that was held beforehand chose them" in capsys.readouterr().out


def test_what_was_not_validated_is_a_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    written_log(Path("run.csv"), fb.load("2R"), 0)
    words = ["identify", "2R", "run.csv", "--friction", "viscous", "--masses", "2, 1"]
    assert run(words) == 1
    assert capsys.readouterr().out.startswith("Not validated")


def test_bad_input_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    written_log(Path("run.csv"), fb.load("2R"), 0)
    assert "one above 0 kg for each of" in error(
        capsys, "identify", "2R", "run.csv", "--masses", "3"
    )
    assert "viscous" in error(capsys, "identify", "2R", "run.csv", "--friction", "viscos")
    assert "numbers need a value for" in error(capsys, "identify", "RR", "simulated")
