"""Loads with a shape, in Python and on the command line, and how results name them."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia
from support.command import run
from support.helpers import refused

ARM = fb.load("2R").to_space()
Q = np.array([0.3, 0.8])


@pytest.mark.parametrize("shape", ["box", "cylinder"])
def test_the_inertia_of_a_shape_is_that_of_grains_that_fill_it(shape: str):
    """Of cells of a grid, whose own inertia is left out: it is a hundredth of the whole."""
    line = (np.arange(14) + 0.5) / 14 - 0.5
    cells = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    size, com = {"box": (0.3, 0.2, 0.5), "cylinder": (0.2, 0.4)}[shape], (0.05, -0.1, 0.2)
    if shape == "box":
        grains = cells * size
    else:
        grains = 0.4 * cells[np.hypot(cells[:, 0], cells[:, 1]) <= 0.5]
    tensor = np.sum(grains**2) * np.eye(3) - grains.T @ grains
    loaded = ARM.with_payload(3.0, com=com, **{shape: size})
    mass, centre, inertia = loaded.bodies[-1].inertias[-1].inertia.numbers()
    assert (mass, *centre) == (3.0, *com)
    assert inertia == pytest.approx(3.0 * tensor / len(grains), rel=0.02, abs=1e-12)


def test_the_ways_to_give_a_load_agree():
    tensor = (0.02, 0.001, -0.002, 0.03, 0.0005, 0.025)
    xx, xy, xz, yy, yz, zz = tensor
    given = ARM.with_payload(3.0, com=(0, 0, 0.1), inertia=tensor)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert given == ARM.with_payload(3.0, com=(0, 0, 0.1), inertia=matrix)
    assert given == ARM.with_payload(Inertia.of(3.0, (0, 0, 0.1), tensor))
    assert given == ARM.with_payload(inertia=Inertia.of(3.0, (0, 0, 0), tensor), com=(0, 0, 0.1))
    named = {"mass": 3.0, "com.z": 0.1, "inertia.xx": xx, "inertia.xy": xy, "inertia.xz": xz,
             "inertia.yy": yy, "inertia.yz": yz, "inertia.zz": zz}  # fmt: skip
    assert given == ARM.bind({f"payload.{name}": x for name, x in named.items()})
    flat = fb.load("2R")
    disc, slab = flat.with_payload(2.0, cylinder=(0.1, 0.5)), flat.with_payload(2.0, box=(0.3, 0.4))
    assert disc == flat.with_payload(2.0, inertia=2.0 * 0.1**2 / 2)
    assert slab == flat.with_payload(2.0, inertia=2.0 * (0.3**2 + 0.4**2) / 12)


def test_a_family_of_loads_of_one_shape():
    masses = np.array([1.0, 2.5])
    family = ARM.with_payload(masses, com=(0, 0, 0.1), box=(0.1, 0.2, 0.3))
    assert family.family == (2,)
    found = fb.mass_matrix(family, Q)
    for k, mass in enumerate(masses):
        one = ARM.with_payload(mass, com=(0, 0, 0.1), box=(0.1, 0.2, 0.3))
        assert family[k] == one
        assert np.array_equal(found[k], fb.mass_matrix(one, Q))


def test_refusals():
    for text, given in (
        ("with_payload: box= and cylinder= exclude each other; give one.",
         {"mass": 1, "box": (1, 1, 1), "cylinder": (1, 1)}),
        ("with_payload: box is (1, 1), expected its sides (a, b, c) in m.",
         {"mass": 1, "box": (1, 1)}),
        ("with_payload: cylinder is 1, expected its radius and height (r, h) in m.",
         {"mass": 1, "cylinder": 1}),
        ("with_payload: box is (1, -1, 1); no length is negative.",
         {"mass": 1, "box": (1, -1, 1)}),
        ("with_payload: an Inertia has a shape of its own; leave out box=.",
         {"mass": Inertia.sphere(1.0, 0.1), "box": (1, 1, 1)}),
        ("with_payload: 'payload': principal moments 1, 1, 5 kg m² break the triangle inequality "
         "(1 + 1 < 5).", {"mass": 1, "inertia": (1, 0, 0, 1, 0, 5)}),
    ):  # fmt: skip
        refused(text, lambda given=given: ARM.with_payload(**given))


def test_a_point_says_which_joint_does_not_feel_it():
    arm = fb.load("ur5e")

    def said(**load) -> list[str]:
        doubts = arm.with_payload(3.0, **load).doubts
        return [doubt.text for doubt in doubts if "point" in doubt.text]

    point = "load 'payload' (3 kg) is a point without inertia"
    assert said(com=(0.1, 0, 0)) == [f"{point}."]
    assert said(com=(0, 0, 0.1)) == [
        f"{point}; wrist_3_joint, on whose axis it is, does not feel it."
    ]
    assert said(com=(0, 0, 0.1), cylinder=(0.05, 0.1)) == []


# ---------------------------------------------------------------- the command
def words(capsys: pytest.CaptureFixture[str]) -> str:
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("3", {}),
        ("3@0.1,0,0.2", {"com": (0.1, 0, 0.2)}),
        (" 3 @ 0.1, 0, 0.2 , box = 0.1, 0.2, 0.3", {"com": (0.1, 0, 0.2), "box": (0.1, 0.2, 0.3)}),
        ("3,cylinder=5e-2,.4", {"cylinder": (0.05, 0.4)}),
        ("3,inertia=1,2,2.5,.1,-.2,.3", {"inertia": (1, 0.1, -0.2, 2, 0.3, 2.5)}),
    ],
)
def test_the_option_means_what_python_does(
    text: str, given: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    fb.save(ARM, "arm.toml")
    assert run(["convert", "arm.toml", "loaded.toml", "--payload", text]) == 0
    assert fb.load("loaded.toml", physical="ignore") == ARM.with_payload(3.0, **given)


def test_what_is_no_load_is_refused(capsys: pytest.CaptureFixture[str]):
    for text in ("", "x", "3@", "3@1,,2", "3,ball=1", "3,box=", "3,box=1,1,1,cylinder=1,1", "nan"):
        assert run(["plan", "ur5e", "0", "--payload", text]) == 2
        assert f"error: --payload {text!r}: write MASS (kg), then perhaps @x,y,z (m)" in (
            capsys.readouterr().err
        )
    assert run(["plan", "ur5e", "0", "--payload", "3,inertia=1,2"]) == 2
    assert "inertia has 2 entries, expected xx,yy,zz,xy,xz,yz, or in the plane one." in (
        capsys.readouterr().err
    )


def test_results_name_the_load_case_and_the_command_that_makes_them_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    asked = [
        "study", "2R", "--payload", "2@0.1,0,box=0.3,0.4", "--parameter", "gravity=3.7",
        "--out", "a $(b) 'c'",
    ]  # fmt: skip
    assert run(asked) == 0
    said = words(capsys)
    load = "payload, 2 kg at (0.1, 0) m in tip, inertia zz 0.04167 kg m²."
    mounting = "base fixed, gravity (0, -3.7) m/s² in world axes."
    changed = "given by --parameter in the place of the file's: gravity = 3.7."
    assert f"Load: {load} Mounting: {mounting} Changed: {changed}" in said
    about = json.loads((tmp_path / asked[-1] / "manifest.json").read_text("utf-8"))["about"]
    assert (about["load"], about["mounting"], about["changed"]) == (load, mounting, changed)
    assert about["tip"] == "The tip is 'tip', as the robot's description says."
    assert shlex.split(about["command"]) == ["freebody", *asked]
    assert said.endswith(f"again: {about['command']}")
    page = (tmp_path / asked[-1] / "report.html").read_text("utf-8")
    for row in (
        f"<dt>Load</dt><dd>{load}</dd>".replace("-", "−"),
        f"<dt>Mounting</dt><dd>{mounting}</dd>".replace("-", "−"),
        "<dt>Again</dt><dd><code>freebody study 2R --payload 2@0.1,0,box=0.3,0.4",
    ):
        assert row in page


def test_plan_and_simulate_carry_the_load(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    motions = {}
    for load in ("none.", "payload, 2 kg at (0, 0) m in tip, a point without inertia."):
        more = [] if load == "none." else ["--payload", "2"]
        asked = ["simulate", "2R", "--q", "0.3, 0.2", "--time", "0.5", *more]
        assert run(asked) == 0
        said = words(capsys)
        assert f"Load: {load} Mounting: base fixed" in said
        assert said.endswith(f"again: {shlex.join(['freebody', *asked])}")
        motions[load] = fb.read_motion(fb.load("2R"), tmp_path / "motion.csv").q
        planned = ["plan", "2R", "0, 0; 1, 1", "--acceleration", "2", *more]
        assert run(planned) == 0
        assert f"Load: {load}" in words(capsys)
    free, loaded = motions.values()
    model = fb.load("2R").with_payload(2.0)
    t = np.linspace(0.0, 0.5, 401)
    exact = fb.simulate(model, [0.3, 0.2], np.zeros(2), t)["q"].values
    assert loaded == pytest.approx(exact, abs=1e-6)
    assert np.abs(free - loaded).max() > 1e-3
