"""The study: everything agrees on every bundled robot, planted faults are found, and files hold
what was computed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from freebody import FreebodyError, MissingValueError, UnknownNameError

pytestmark = pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")

PARTS = ("inertial", "coriolis", "gravity", "friction", "springs", "rotors")


@pytest.fixture(scope="module")
def arm() -> fb.Study:
    return fb.study(fb.load("ur5e"))


LONG = {"puma560", "stewart"}
"""Bundled models whose replay and whose kernels take as long as those of all others."""


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name",
    [pytest.param(x, marks=pytest.mark.long if x in LONG else ()) for x in fb.models()],
)
def test_all_checks_pass_on_every_bundled_model(name: str):
    study = fb.study(fb.load(name))
    assert study.checked, [c for c in study.checks if not c.passed]
    data = study.data
    np.testing.assert_allclose(
        sum(data[f"tau_{p}"] for p in PARTS), data["tau"], atol=1e-9 * abs(data["tau"]).max()
    )
    for variable in (*data.data_vars.values(), *study.summary.data_vars.values()):
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]
        assert variable.dtype == np.float64
    assert study.tip in study.model.tip_reason
    if study.model.loops:
        assert {"loops", "simulation", "forces on each body", "forward dynamics"} <= {
            c.name for c in study.checks
        }
        assert study.replay is None
        assert (
            data["tau"].sel(
                coordinate=list(set(study.model.velocity_names) - set(study.model.driven_names))
            )
            == 0
        ).all()
        return
    assert study.replay is not None
    assert study.replay.misses.max() < 1e-6
    assert (study.replay.factors <= 1e4).all()
    assert study.replay.edges[0] == 0.0
    assert study.replay.edges[-1] == 5.0


def test_friction_rotors_and_springs_are_parts_of_the_torque():
    drive = fb.Drive(viscous=0.3, coulomb=0.8, rotor=1e-3, gear=20.0, stiffness=5.0, rest=0.2)
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[2, 1], I=[0.1, 0.05], drives=[drive, drive])
    study = fb.study(model)
    assert study.checked, [c for c in study.checks if not c.passed]
    data = study.data
    np.testing.assert_allclose(
        data["tau_friction"], 0.3 * data["qd"].values + 0.8 * np.sign(data["qd"].values)
    )
    np.testing.assert_allclose(data["tau_rotors"], 0.4 * data["qdd"].values, rtol=1e-12)
    np.testing.assert_allclose(data["tau_springs"], 5.0 * (data["q"].values - 0.2), atol=1e-12)
    assert study.replay is not None
    assert study.replay.method == "BDF"
    assert study.replay.friction_width == 1e-3


def test_a_replay_of_one_piece_is_told_as_one():
    model = fb.load("pendulum")
    study = fb.study(model, fb.quintic(model, [[0.0], [0.2]], [0.0, 0.5]))
    (what,) = [c.text for c in study.checks if c.name == "replay"]
    assert "in 1 piece: " in what
    assert study.replay is not None
    assert (
        "for 0.5 s, in one piece, the model misses the end of the motion by " in study.replay.text
    )


@pytest.mark.parametrize("start", [0.0, 1_732_380_000.125])
def test_a_log_with_a_computers_clock_is_studied_from_its_first_instant(start: float):
    model = fb.load("2R")
    planned = fb.quintic(model, [[0.1, -0.4], [0.9, 0.7], [0.3, 0.2]], [0.0, 0.5, 1.0], step=1 / 64)
    study = fb.study(model, replace(planned, t=start + planned.t, pieces=None))
    assert study.checked, [c for c in study.checks if not c.passed]
    np.testing.assert_array_equal(study.motion.t[[0, -1]], [0.0, 1.0])
    said = "Times are counted from the first, 1732380000.125 s, at which numbers of 64 bits are "
    assert any(x.startswith(said) for x in study.notices) == (start > 0.0)


def test_the_worst_pose_of_a_planar_arm_is_stretched_out():
    model = fb.load("2R")
    p = {name: value for name, value in model.parameters.items() if value is not None}
    first, second = fb.study(model).static
    stretched = p["g"] * (p["m1"] * p["lc1"] + p["m2"] * (p["l1"] + p["lc2"]))
    assert abs(first.torque) == pytest.approx(stretched, rel=1e-6)
    assert abs(np.cos(first.q)) == pytest.approx([1, 1], abs=1e-3)
    assert abs(second.torque) == pytest.approx(p["g"] * p["m2"] * p["lc2"], rel=1e-6)
    assert second.unit == "N m"


def test_a_singular_pose_on_the_way_is_found():
    model = fb.load("2R")
    t = np.linspace(0, 2, 201)
    study = fb.study(model, fb.Motion.of(model, t, np.stack([0 * t, t - 0.5], axis=-1)))
    assert study.singularity.time == pytest.approx(0.5, abs=1e-9)
    assert study.singularity.rows == "position"
    assert study.singularity.text == (
        "At t = 0.5 s the tip cannot move in some direction: the arm is at or very near a "
        "singularity."
    )


def test_the_worst_instant_is_relative_to_the_limits():
    limits = [fb.Limits(effort=1000.0), fb.Limits(effort=10.0)]
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[2, 1], I=[0.1, 0.05], limits=limits)
    study = fb.study(model)
    worst = study.worst
    tau = study.data["tau"].values
    k = int(np.argmax(np.abs(tau[:, 1])))
    assert (worst.coordinate, worst.index, worst.value) == ("joint2", k, tau[k, 1])
    assert worst.fraction == pytest.approx(abs(tau[k, 1]) / 10)
    assert f"{100 * worst.fraction:.0f} % of its effort limit" in worst.text
    assert float(study.summary["effort_fraction"][1]) == pytest.approx(worst.fraction)


def test_a_motion_beyond_the_limits_is_studied_and_said():
    limits = [fb.Limits(-1, 1, velocity=0.5, effort=3.0)]
    model = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=limits)
    t = np.linspace(0, 2, 41)
    study = fb.study(model, fb.Motion.of(model, t, t[:, None]))
    assert study.checked
    assert study.warnings == (
        "the speed of joint1 is 1 rad/s at t = 2 s, 200 % of its limit of 0.5 rad/s.",
        "joint1 leaves its range: the motion spans 0 to 2 rad, the limits are -1 and 1.",
        "the torque of joint1 is 4.905 N m at t = 0 s, 164 % of its limit of 3 N m.",
    )
    assert float(study.summary["position_fraction"][0]) == pytest.approx(2.0)


def test_which_tip_is_studied():
    panda = fb.load("panda")
    with pytest.raises(
        UnknownNameError, match=r"no frame 'panda_link9' in 'panda'\. Did you mean 'panda_link"
    ):
        fb.study(panda, tip="panda_link9")


def test_a_joint_without_inertia_stops_only_the_replay():
    model = fb.planar("RR", l=[1, 1], lc=[1, 0], m=[1, 0], I=[0.1, 0])
    study = fb.study(model)
    assert study.checked
    assert study.replay is None
    assert study.replay_skipped.startswith("There is no replay. ")
    assert "joint 'joint2' moves no inertia" in study.replay_skipped
    assert not {"replay", "forward dynamics"} & {c.name for c in study.checks}


def test_what_cannot_be_studied_says_why():
    with pytest.raises(
        MissingValueError, match=r"the study of 'RR': numbers need a value for I1, I2, "
    ):
        fb.study(fb.planar("RR"))
    with pytest.raises(
        FreebodyError, match=r"study: the motion has 2 positions and 2 rates, '3R' has nq = 3"
    ):
        fb.study(fb.load("3R"), fb.default_motion(fb.load("2R")))


def test_progress_is_told():
    told: list[tuple[str, float]] = []
    fb.study(fb.load("2R"), progress=lambda text, done: told.append((text, done)))
    assert told[0] == ("motion", 0.0)
    assert told[-1] == ("done", 1.0)
    assert [done for _, done in told] == sorted(done for _, done in told)


def test_the_card_tells_what_is_at_its_limit(arm: fb.Study):
    """The payload, and the pace, at which the named joint has used up its limit, and no other."""
    card, model, motion = arm.card, arm.model, arm.motion
    loaded = model.with_payload(card.payload)
    tau = np.abs(fb.inverse_dynamics(loaded, motion.q, motion.qd, motion.qdd))
    share = tau / model.limits.effort
    k, j = np.unravel_index(np.argmax(share), share.shape)
    assert share[k, j] == pytest.approx(1.0, abs=1e-4)
    assert model.velocity_names[j] == card.payload_joint
    assert motion.t[k] == pytest.approx(card.payload_time, abs=0.02)
    fast = motion.faster(card.faster)
    speed = np.abs(fast.qd).max(axis=0) / model.limits.velocity
    torque = np.abs(fb.inverse_dynamics(model, fast.q, fast.qd, fast.qdd)) / model.limits.effort
    used = {"speed": speed, "torque": torque.max(axis=0)}
    assert max(x.max() for x in used.values()) == pytest.approx(1.0, abs=1e-4)
    first = model.velocity_names[int(np.argmax(used[card.faster_quantity]))]
    assert first == card.faster_joint
    assert used[card.faster_quantity].max() == pytest.approx(1.0, abs=1e-4)
    most = max((use for use in arm.verdict.uses if use.quantity != "position"),
               key=lambda use: use.fraction)  # fmt: skip
    assert card.first == most
    labels = [row.label for row in card.rows]
    assert labels == ["carries by its effort limits", "can be run", "gives out first"]


def test_the_card_names_what_it_does_not_know(tmp_path: Path):
    """Never a number where a doubt bars it, and in JSON neither."""
    study = fb.study(fb.load("2R"), speed=2.0, wrenches=[0.0, -5.0, 0.0])
    told = {row.label: row for row in study.card.rows}
    assert told["carries"] == ("carries", "–", "", "not known: no drive has an effort limit")
    assert told["can be run"][1] == told["gives out first"][1] == "–"
    case = study.load_case
    assert (case.speed, case.payload, case.command) == (2.0, 0.0, "")
    np.testing.assert_array_equal(case.wrenches["tip"], [0.0, -5.0, 0.0])
    study.save(tmp_path)
    kept = json.loads((tmp_path / "card.json").read_text("utf-8"))
    assert kept["card"]["payload"] is kept["card"]["faster"] is None
    assert kept["load_case"]["gravity"] == [0.0, -9.81]
    assert kept["load_case"]["wrenches"] == {"tip": [0.0, -5.0, 0.0]}
    assert kept["rows"] == [list(row) for row in (*study.card.rows, *case.rows)]


def test_files_hold_what_was_computed(arm: fb.Study, tmp_path: Path):
    written = arm.save(tmp_path / "new" / "folder")
    assert [path.name for path in written] == [
        "study.nc",
        "motion.csv",
        "torques.csv",
        "reactions.csv",
        "summary.csv",
        "reactions_summary.csv",
        "checks.csv",
        "card.json",
        "manifest.json",
    ]
    with xr.open_dataset(written[0]) as data:
        for source in (arm.data, arm.summary):
            for name in source.data_vars:
                np.testing.assert_array_equal(data[name].values, source[name].values)
                assert data[name].attrs == source[name].attrs
        assert data.attrs["robot"] == "ur5e"
        np.testing.assert_array_equal(data["replay_miss"].values, arm.replay.misses)
    again = fb.study(arm.model, written[1])
    np.testing.assert_array_equal(again.data["tau"].values, arm.data["tau"].values)
    table = np.genfromtxt(written[2], delimiter=",", names=True, deletechars="")
    np.testing.assert_array_equal(table["elbow_joint_tau_(N_m)"], arm.data["tau"].values[:, 2])
    summary = written[4].read_text().splitlines()
    assert summary[0].startswith(
        "coordinate,unit,effort_unit,peak_torque (N m|N),peak_torque_time (s)"
    )
    assert summary[1].startswith("shoulder_pan_joint,rad,N m,")
    with pytest.raises(
        FreebodyError, match=r"study\.nc: there is a file of that name; name a folder instead\."
    ):
        arm.save(written[0])


def test_a_floating_robot_says_what_drives_its_base():
    study = fb.study(fb.load("quadrotor"))
    assert study.checked
    assert not study.passed
    assert study.verdict.text.startswith("Not judged: the description lacks what moves flight")
    assert study.warnings[0].startswith("Joint 'flight' has no motor of its own")
