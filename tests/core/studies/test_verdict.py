"""The verdict of a study: never kinder than the truth. Limits, pace, work, and what bearings
carry."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Motion
from support.command import run

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="link"><inertial><origin xyz="0.5 0 0"/><mass value="2.13"/>
    <inertia ixx="0.011" iyy="0.17" izz="0.17" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lift" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="{velocity}" effort="{effort}"/></joint>
</robot>
"""


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)


def arm(velocity: float = 3.0, effort: float = 20.0) -> str:
    Path("arm.urdf").write_text(ARM.format(velocity=velocity, effort=effort))
    return "arm.urdf"


def swing(model: fb.Model, size: float = 0.5, seconds: float = 2.0) -> Motion:
    t = np.linspace(0.0, seconds, 201)
    wave = size * np.sin(np.pi * t / seconds)[:, None] ** 2
    return fb.Motion.of(model, t, wave * np.linspace(1.0, -0.6, model.nv))


def full(coulomb: float = 0.4, effort: float = np.inf, velocity: float = np.inf) -> fb.Model:
    """Two links with everything that acts in a joint."""
    drive = fb.Drive(viscous=0.7, coulomb=coulomb, rotor=2e-3, gear=10.0, stiffness=1.5, rest=0.1)
    limits = fb.Limits(-2.0, 2.0, velocity, effort)
    return fb.planar(
        "RR",
        l=[1, 1],
        lc=[0.5, 0.4],
        m=[2, 1],
        I=[0.1, 0.05],
        drives=[drive, drive],
        limits=[limits, limits],
    )


# ------------------------------------------------------------ the three outcomes, and what the
# command exits with
def test_a_feasible_motion_exits_0_and_says_so_first(capsys: pytest.CaptureFixture[str]):
    assert run(["study", arm()]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.startswith("Feasible: the motion stays within every limit; nearest: ")
    assert re.search(r"It could be run up to \S+ times as fast\.", " ".join(said.out.split()))


def test_a_motion_beyond_a_limit_exits_1_and_says_which(capsys: pytest.CaptureFixture[str]):
    file = arm(velocity=1.0)
    Path("fast.csv").write_text(
        "t,lift\n" + "\n".join(f"{k / 20},{0.5 * (k / 20) ** 2}" for k in range(25))
    )
    assert run(["study", file, "--motion", "fast.csv"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith(
        "Not feasible: the speed of lift is 1.2 rad/s at t = 1.2 s, 120 % of its limit of 1 rad/s. "
        "It would keep the limits of speed and torque at 0.833 times its speed (1.2 times the "
        "duration)."
    )
    assert "passed" not in out


def test_limits_of_zero_are_not_given_and_nothing_is_called_feasible(
    capsys: pytest.CaptureFixture[str],
):
    assert run(["study", arm(velocity=0, effort=0)]) == 0
    out = capsys.readouterr().out
    assert out.startswith(
        "Not judged: the description lacks an effort limit and a speed limit of lift."
    )
    study = fb.study(fb.load("arm.urdf"))
    assert not study.passed
    assert not study.finding


def test_gravity_beyond_the_limit_is_not_helped_by_slowing(capsys: pytest.CaptureFixture[str]):
    assert run(["study", arm(effort=5.0)]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("Not feasible: the torque of lift is 10.")
    assert "Slowing down does not help: gravity alone requires 2" in out


def test_a_motion_on_its_limit_is_within_it():
    model = fb.planar(
        "R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=[fb.Limits(0, 1, velocity=1.0, effort=50)]
    )
    t = np.linspace(0, 1, 41)
    study = fb.study(model, fb.Motion.of(model, t, t[:, None]))
    assert study.verdict.outcome == "feasible"
    assert study.verdict.factor == pytest.approx(1.0, abs=1e-6)
    assert "cannot be run any faster" in study.verdict.text


def test_a_position_outside_its_range_is_not_feasible_at_any_speed():
    model = fb.planar(
        "R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=[fb.Limits(-1, 0.4, velocity=9, effort=50)]
    )
    verdict = fb.study(model, swing(model)).verdict
    assert verdict.outcome == "not feasible"
    assert verdict.text.startswith(
        "Not feasible: joint1 goes to 0.5 rad at t = 1 s, beyond its upper limit 0.4 rad."
    )
    assert "Slowing down does not help." in verdict.text
    open_below = [fb.Limits(upper=0.4, velocity=9, effort=50)]
    model = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=open_below)
    assert fb.study(model, swing(model)).verdict.outcome == "not feasible"


def test_a_passive_joint_that_needs_a_torque_is_not_feasible():
    limits = [fb.Limits(-3, 3, 9, 99)] * 2
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], limits=limits)
    model = model.replace(actuated=["joint1"])
    verdict = fb.study(model, swing(model)).verdict
    assert verdict.outcome == "not feasible"
    assert "joint2 is passive, and the motion needs " in verdict.text


# ------------------------------------------------------------ pace
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("effort", "velocity"), [(60.0, 4.0), (60.0, 99.0), (30.0, 99.0), (60.0, 0.2)]
)
def test_at_the_stated_pace_the_first_limit_is_just_reached(effort, velocity):
    """The factor, against the torque of the same path run at that pace by inverse dynamics,
    friction included."""
    model = full(effort=effort, velocity=velocity)
    motion = swing(model, seconds=0.9)
    study = fb.study(model, motion)
    factor = study.verdict.factor

    def used(k: float) -> float:
        run = motion.faster(k)
        tau = fb.inverse_dynamics(model, run.q, run.qd, run.qdd)
        return max(np.abs(tau).max() / effort, np.abs(run.qd).max() / velocity)

    assert used(factor) == pytest.approx(1.0, abs=1e-7)
    if factor >= 1:
        assert max(used(k) for k in np.linspace(1.0, factor, 40)) <= 1 + 1e-7
        assert study.verdict.outcome == "feasible"
    else:
        assert min(used(k) for k in np.linspace(factor * (1 + 1e-6), 1.0, 40)) > 1
        assert study.verdict.outcome == "not feasible"


FRICTION = {
    "quadratic": 3.0, "asymmetric": -1.0, "cube_root": 2.0, "stribeck": 3.0, "stribeck_speed": 1.0,
    "saturating": 20.0, "saturating_speed": 0.3,
}  # fmt: skip
GEAR = {"efficiency": 0.9, "back_efficiency": 0.8}


@pytest.mark.sample(1)
@pytest.mark.parametrize(("effort", "more"), [(34.0, {}), (60.0, GEAR)])
def test_the_pace_sees_friction_grow_by_its_own_law(effort, more):
    model = full(effort=effort, velocity=99.0)
    for joint in model.joint_names:
        model = model.with_drive(joint, **FRICTION, **more)
    motion = swing(model, seconds=1.5)
    factor = fb.study(model, motion).verdict.factor

    def used(k: float) -> float:
        run = motion.faster(k)
        return np.abs(fb.inverse_dynamics(model, run.q, run.qd, run.qdd)).max() / effort

    assert used(factor) == pytest.approx(1.0, abs=1e-7)
    between = np.linspace(min(1.0, factor), factor, 20) if factor >= 1 else [factor]
    assert max(used(k) for k in between) <= 1 + 1e-7
    assert (factor >= 1) == (used(1.0) <= 1)


def test_a_limit_that_is_exceeded_at_a_few_paces_only_ends_the_pace():
    """A joint that brakes: its friction grows with the cube root of the pace k, its inertia takes
    the more away, a c(k) = c k^(1/3) - x k² that is largest at one pace and small at others."""
    rate, x = 1.0, 0.02
    top = (1.0 / (6.0 * x)) ** 0.6
    effort = (top ** (1 / 3) - x * top**2) * (1.0 - 1e-6)
    model = fb.planar(
        "P", l=[0], lc=[0], m=[1.0], I=[0], drives=[fb.Drive(cube_root=1.0)],
        limits=[fb.Limits(effort=effort)],
    ).replace(gravity=0.0)  # fmt: skip
    t = np.linspace(0.0, 1.0, 41)[:, None]
    q, qd = rate * t - 0.5 * x * t**2, rate - x * t
    motion = fb.Motion.of(model, t[:, 0], q, qd, np.full_like(t, -x))
    factor = fb.study(model, motion).verdict.factor

    def used(k: float) -> float:
        run = motion.faster(k)
        return np.abs(fb.inverse_dynamics(model, run.q, run.qd, run.qdd)).max() / effort

    assert used(top) > 1.0
    assert used(0.99 * top) < 1.0
    assert used(1.01 * top) < 1.0  # at steps of this size nothing would be seen
    assert used(2.0 * top) < 1.0
    assert 0.99 * top < factor < top
    assert used(factor) <= 1.0 + 1e-8


def test_no_pace_holds_what_gravity_springs_and_friction_ask():
    model = full(effort=10.0)
    study = fb.study(model, swing(model))
    assert study.verdict.factor == 0.0
    assert "gravity, springs and friction alone require" in study.verdict.text


def test_the_default_motion_is_slowed_until_it_keeps_the_limits():
    model = fb.planar(
        "R", l=[0.1], lc=[0.05], m=[1], I=[5.0], limits=[fb.Limits(-1, 1, velocity=9, effort=3)]
    )
    tau = fb.inverse_dynamics(
        model, *(getattr(fb.default_motion(model), x) for x in ("q", "qd", "qdd"))
    )
    assert np.abs(tau).max() > 3
    study = fb.study(model)
    assert study.passed
    assert study.motion.duration > 5
    assert ", slowed to " in study.motion.source
    assert float(study.summary["effort_fraction"][0]) < 1


def test_a_pace_is_not_promised_where_limits_are_not_given():
    limits = [fb.Limits(-1, 1, velocity=3.0)]
    model = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], limits=limits)
    study = fb.study(model, swing(model))
    text = study.verdict.text
    assert study.card.rows[2].label == "gives out first, of what can be judged"
    assert text.startswith(
        "Not judged: the description lacks an effort limit of joint1. The limits that are given "
        "are kept; "
    )
    assert " They would be kept up to 3.81 times that speed." in text


def test_a_flexible_joint_is_judged_with_its_shaft_twisted_by_what_it_carries():
    lever = fb.planar(
        "R", l=[1], lc=[0.5], m=[2], I=[0.2], limits=[fb.Limits(-2.0, 2.0, 3.0, 40.0)],
        drives=[fb.Drive(rotor=1e-3, gear=30.0, viscous=0.3)],
    )  # fmt: skip
    model = lever.with_flexible_joint("joint1", stiffness=800.0, damping=4.0)
    study = fb.study(model, speed=1.3)
    assert study.verdict.outcome == "feasible"
    assert "the shafts of its flexible joints would twist otherwise" in study.verdict.text
    tau = np.abs(study.data["tau"].values).max(axis=0)
    assert tau[1] < 1e-4 * tau[0]
    heaviest = {pose.coordinate: pose for pose in study.static}
    assert abs(heaviest["joint1"].torque) == pytest.approx(2.0 * 9.81 * 0.5, rel=1e-6)
    jumping = fb.study(model, fb.trapezoid(model, [[0.1, 0.0], [0.3, 0.0]], acceleration=2.0))
    assert jumping.verdict.outcome == "not feasible"
    assert (
        "joint1_twist is the shaft of a flexible joint, and the motion does not twist it by what "
        "it carries: it is off by "
    ) in jumping.verdict.text
    said = "(joint1_twist) stays as it is given: the motion's accelerations jump, first at t = 0."
    assert any(said in x for x in jumping.warnings)
    assert (jumping.motion.q[:, 1] == 0.0).all()


# ------------------------------------------------------------ work
def test_work_of_a_lift_and_of_a_cycle():
    model = fb.planar("R", l=[1], lc=[0.5], m=[2], I=[0.1])
    t = np.linspace(0, 4, 801)
    up = (
        -np.pi / 2 + np.pi / 2 * np.sin(np.pi * t / 8) ** 2
    )  # from hanging to level, rate 0 at both ends
    lift = fb.study(model, fb.Motion.of(model, t, up[:, None])).summary
    assert float(lift["net_work"][0]) == pytest.approx(2 * 9.81 * 0.5, rel=1e-5)
    cycle = -np.pi / 2 + np.pi / 2 * np.sin(np.pi * t / 4) ** 2
    both = fb.study(model, fb.Motion.of(model, t, cycle[:, None])).summary
    assert float(both["net_work"][0]) == pytest.approx(0.0, abs=1e-4)
    assert float(both["work_done"][0]) == pytest.approx(
        2 * 9.81 * 0.5, rel=1e-4
    )  # slow: nothing is flung
    assert float(both["regenerated_share"][0]) == pytest.approx(1.0, abs=1e-4)
    damped = full()
    kept = fb.study(damped, swing(damped)).summary
    assert float(kept["total_regenerated_share"]) < 1
    assert float(kept["shared_work_done"]) <= float(kept["total_work_done"])
    assert float(kept["shared_work_done"] - kept["shared_work_braked"]) == pytest.approx(
        float(kept["total_net_work"]), abs=1e-9
    )


# ------------------------------------------------------------ the page
def test_the_verdict_is_the_first_thing_on_the_page():
    for effort, tone, words in (
        (20.0, "good", "Feasible:"),
        (5.0, "poor", "Not feasible:"),
        (0, "open", "Not judged:"),
    ):
        study = fb.study(fb.load(arm(effort=effort)))
        text = study.to_html("page.html").read_text(encoding="utf-8")
        body = text[text.index("<main>") :]
        lead, first = re.findall(r"<p[^>]*>.*?</p>", body, re.DOTALL)[:2]
        assert 'class="lead"' in lead  # what it is a study of
        assert first.startswith(f"<p><strong>{words}</strong>")
        assert f'<div class="ruling {tone}" id="verdict"' in body
        assert "all 8 checks passed" not in text


def test_on_the_page_drive_and_bearing_stand_apart():
    text = fb.study(fb.load(arm())).to_html("page.html").read_text(encoding="utf-8")
    for variable in (
        "peak_axial_force",
        "peak_radial_force",
        "peak_tilting_moment",
        "peak_drive_load",
        "work_braked",
    ):
        assert f'data-var="{variable}"' in text
    assert 'data-var="peak_moment"' not in text


def test_failed_self_checks_are_a_finding_even_where_the_motion_is_feasible():
    study = fb.study(fb.load(arm()))
    assert study.passed
    bad = replace(study.checks[0], passed=False)
    worse = replace(study, checks=(bad, *study.checks[1:]))
    assert worse.finding
    assert not worse.passed


# ------------------------------------------------------------ what a range leaves open, what noise
# adds
@pytest.mark.parametrize(("lower", "outcome"), [(-1.0, "not judged"), (0.2, "feasible")])
def test_a_follower_that_can_never_keep_its_range_is_not_judged(
    tmp_path: Path, lower: float, outcome: str
):
    """A gripper whose second finger has the range of a mirrored axis, and follows without a minus:
    PR2's."""
    file = tmp_path / "gripper.toml"
    upper = max(0.0, 5 * lower)
    text = """dim = 2
[[link]]
name = "palm"
"""
    for name, limits, mimic in (
        ("left", "lower = 0.2, upper = 1", ""),
        ("right", f"lower = {lower}, upper = {upper}", 'mimic = { joint = "left" }\n'),
    ):
        text += f"""[[link]]
name = "{name}_finger"
mass = 0.1
com = [0.05, 0]
inertia = 1e-4
[[joint]]
name = "{name}"
kind = "revolute"
parent = "palm"
child = "{name}_finger"
limits = {{ {limits}, velocity = 2, effort = 5 }}
{mimic}"""
    file.write_text(text)
    verdict = fb.study(fb.load(file)).verdict
    assert verdict.outcome == outcome
    assert ("a range that suits right, which follows left" in verdict.text) == (
        outcome == "not judged"
    )


def test_the_verdict_on_a_noisy_motion_says_that_noise_counts(tmp_path: Path):
    model, t = full(coulomb=0.0), np.arange(0.0, 2.0, 0.01)
    q = 0.5 * np.sin(t) + 3e-4 * np.random.default_rng(0).normal(size=len(t))
    rows = np.column_stack([t, *[q] * model.nq])
    header = ",".join(["t", *model.position_names])
    np.savetxt(tmp_path / "m.csv", rows, delimiter=",", header=header, comments="")
    said = "The noise of the motion counts as torque here"
    assert said in fb.study(model, tmp_path / "m.csv").verdict.text
    assert said not in fb.study(model, tmp_path / "m.csv", smooth=True).verdict.text
    assert said not in fb.study(model, swing(model)).verdict.text
