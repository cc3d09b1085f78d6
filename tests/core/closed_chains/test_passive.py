"""Passive joints: nothing drives them, in open chains as in closed ones."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import FileError, FreebodyError, ModelError, PassiveJointError

WORD = {"l": [0.0, 0.5], "lc": [0.0, 0.5], "m": [2.0, 0.3], "I": [0.0, 0.0]}


def cart_pole() -> fb.Model:
    """A cart of 2 kg with a point mass of 0.3 kg on a rod of 0.5 m; θ from the x-axis."""
    return fb.planar("PR", **WORD, passive=["joint2"])


def test_the_passive_entry_of_a_cart_pole_is_the_torque_that_is_missing():
    model = cart_pole()
    q, qd, qdd = np.array([0.2, 0.4]), np.array([1.0, -2.0]), np.array([0.7, 1.5])
    m, l, g, s, c = 0.3, 0.5, 9.81, np.sin(0.4), np.cos(0.4)
    force = 2.3 * 0.7 - m * l * (s * 1.5 + c * 4.0)
    missing = m * l**2 * 1.5 - m * l * s * 0.7 + m * g * l * c
    np.testing.assert_allclose(fb.inverse_dynamics(model, q, qd, qdd), [force, missing], rtol=1e-13)
    assert (model.passive, model.passive_names, model.driven_names) == (
        (1,),
        ("joint2",),
        ("joint1",),
    )


def test_a_motion_of_the_drives_alone_misses_nothing_at_the_passive_joint():
    model = cart_pole()
    t = np.linspace(0, 1, 11)
    found = fb.simulate(model, [0, 1.4], [0, 0], t, lambda now, q, qd: [3 * np.sin(5 * now), 0.0])
    tau = fb.inverse_dynamics(model, *(found[name].values for name in ("q", "qd", "qdd")))
    np.testing.assert_allclose(tau, np.stack([3 * np.sin(5 * t), 0 * t], axis=-1), atol=1e-12)


@pytest.mark.parametrize(
    "call",
    [
        lambda m, tau: fb.forward_dynamics(m, [0, 0.3], [0, 0], tau),
        lambda m, tau: fb.forward_dynamics(
            m, [0, 0.3], [0, 0], dict(zip(m.velocity_names, tau, strict=True))
        ),
        lambda m, tau: fb.forward_dynamics_derivatives(m, [0, 0.3], [0, 0], tau),
        lambda m, tau: fb.forward_dynamics_parameter_derivatives(m, [0, 0.3], [0, 0], tau),
        lambda m, tau: fb.tip_wrench(m, [0, 0.3], tau),
        lambda m, tau: fb.reactions(m, [0, 0.3], [0, 0], tau=tau),
        lambda m, tau: fb.simulate(m, [0, 0.3], [0, 0], [0, 0.1], tau),
        lambda m, tau: fb.simulate(m, [0, 0.3], [0, 0], [0, 0.1], [tau, tau]),
        lambda m, tau: fb.simulate(m, [0, 0.3], [0, 0], [0, 0.1], lambda t, q, qd: tau),
    ],
)
def test_a_torque_at_a_passive_joint_is_refused_by_name(call):
    model = cart_pole()
    call(model, [1.0, 0.0])
    with pytest.raises(
        PassiveJointError, match=r"the torque of 'joint2' is 0\.5.*passive.*actuated="
    ):
        call(model, [1.0, 0.5])
    call(model.replace(actuated=["joint1", "joint2"]), [1.0, 0.5])


def test_a_law_that_gives_no_numbers_stops_like_that_of_any_robot():
    for model in (cart_pole(), fb.planar("PR", **WORD)):
        with pytest.raises(FreebodyError, match="check torques"):
            fb.simulate(model, [0, 0.3], [0, 0], [0, 0.1], lambda t, q, qd: [0.0, np.nan])


def test_a_torque_at_a_passive_joint_of_a_closed_chain_is_refused():
    model = fb.load("four_bar")
    q = fb.assemble(model)
    tau = np.zeros(model.nv)
    fb.forward_dynamics(model, q, np.zeros(model.nv), tau)
    tau[model.passive[0]] = 1.0
    with pytest.raises(PassiveJointError, match=model.passive_names[0]):
        fb.forward_dynamics(model, q, np.zeros(model.nv), tau)


@pytest.mark.parametrize(
    "text",
    [
        '[planar]\nword = "PR"\nm = [2, 1]\nl = [0, 1]\nlc = [0, 1]\nI = [0, 1]\n'
        'passive = ["joint2"]\n',
        '[dh]\nconvention = "standard"\nrows = [{ a = 1, m = 1 }, { a = 1, m = 1, '
        "passive = true }]\n",
    ],
)
def test_passive_joints_of_a_file_come_back_when_saved(tmp_path: Path, text: str):
    (tmp_path / "a.toml").write_text(text)
    model = fb.load(tmp_path / "a.toml")
    assert model.passive_names == ("joint2",)
    fb.save(model, tmp_path / "b.toml")
    assert fb.load(tmp_path / "b.toml").passive_names == ("joint2",)
    rows = [{"a": 1.0, "m": 1.0}, {"a": 1.0, "m": 1.0, "passive": True}]
    assert fb.dh(rows, convention="standard").passive_names == ("joint2",)


def test_what_cannot_be_passive_is_refused(tmp_path: Path):
    with pytest.raises(
        ModelError, match=r"no joint 'pin' in planar: passive\. .*Joints: joint1, joint2"
    ):
        fb.planar("PR", passive=["pin"])
    with pytest.raises(ModelError, match="dh row 1: passive is 'yes', expected True or False"):
        fb.dh([{"passive": "yes"}], convention="standard")
    links = "".join(f'[[link]]\nname = "{name}"\nmass = 1\n' for name in "abc")
    joint = '[[joint]]\nname = "%s"\nkind = "revolute"\naxis = "z"\nparent = "%s"\nchild = "%s"\n'
    follows = (
        links + joint % ("u", "a", "b") + joint % ("v", "b", "c") + 'mimic = { joint = "u" }\n'
    )
    file = tmp_path / "a.toml"
    file.write_text(follows + "passive = true\n")
    with pytest.raises(FileError, match="joint 'v': passive: the joint follows another"):
        fb.load(file)
    file.write_text(follows)
    idle = fb.load(file).replace(actuated=[])
    fb.save(idle, file)
    assert fb.load(file).passive_names == ("u",)


def test_a_motion_of_the_drives_alone_stays_feasible_in_a_file_of_six_digits(tmp_path: Path):
    model = cart_pole()
    t = np.linspace(0, 2, 101)
    found = fb.simulate(model, [0, -1.4], [0, 0], t, lambda now, q, qd: [3 * np.sin(5 * now), 0.0])
    q = found["q"].values
    for bend, undriven in ((0.0, False), (0.05, True)):
        rows = np.column_stack([t, q[:, 0], q[:, 1] + bend * np.sin(3 * t)])
        np.savetxt(
            tmp_path / "m.csv",
            rows,
            delimiter=",",
            header="t,joint1,joint2",
            comments="",
            fmt="%.6f",
        )
        motion = fb.read_motion(model, tmp_path / "m.csv")
        text = fb.study(model, motion).verdict.text
        assert ("joint2 is passive, and the motion needs" in text) == undriven


# ------------------------------------------------------------ studies
def crane(pendulum: str) -> str:
    return f"""name = "crane"
[[link]]
name = "shaft"
[[link]]
name = "car"
mass = 500
[[link]]
name = "bob"
mass = 1
com = [0, 0, -0.5]
[[joint]]
name = "lift"
kind = "prismatic"
parent = "shaft"
child = "car"
axis = "z"
limits = {{ lower = -3, upper = 3, velocity = 3, effort = 9000 }}
[[joint]]
name = "pin"
kind = "continuous"
parent = "car"
child = "bob"
axis = "y"
{pendulum}
"""


def test_a_small_passive_joint_beside_a_large_drive_is_not_overlooked(tmp_path: Path):
    """1 kg held 0.5 m out needs 4.9 N m sin 0.5; the drive that lifts 500 kg has 4900 N."""
    (tmp_path / "crane.toml").write_text(crane("passive = true"))
    model = fb.load(tmp_path / "crane.toml")
    t = np.linspace(0, 2, 101)
    for angle, outcome in ((0.5, "not feasible"), (0.0, "feasible")):
        np.savetxt(
            tmp_path / "m.csv",
            np.column_stack([t, 0.3 * np.sin(t), np.full(101, angle)]),
            delimiter=",",
            header="t,lift,pin",
            comments="",
            fmt="%.6f",
        )
        found = fb.study(model, tmp_path / "m.csv")
        assert found.verdict.outcome == outcome, found.verdict
        lifted = found.data["tau"].values[:, 0] * found.data["qd"].values[:, 0]
        np.testing.assert_allclose(found.data["motor_power"], lifted, atol=1e-9)


def test_drives_alone_do_work_and_a_swing_keeps_its_pace():
    limits = [fb.Limits(-2, 2, 3, 20), fb.Limits(velocity=20)]
    model = fb.planar("PR", **WORD, limits=limits, passive=["joint2"])
    t = np.linspace(0, 2, 201)
    free = fb.simulate(model, [0, -1.4], [0, 0], t, lambda now, q, qd: [3 * np.sin(5 * now), 0.0])
    found = fb.study(
        model,
        fb.Motion.of(model, t, *(free[x].values for x in ("q", "qd", "qdd"))),
    )
    assert found.verdict.outcome == "feasible"
    assert (
        "It cannot be run at another speed: joint2 has no motor and would not follow."
        in found.verdict.text
    )
    assert "times as fast" not in found.verdict.text
    assert np.isnan(found.verdict.factor)
    default = fb.study(model)
    assert default.verdict.outcome == "not feasible"
    assert "swings within its limits, also joint2, as if driven, from rest" in default.motion.source
    power = default.data["tau"].values[:, 0] * default.data["qd"].values[:, 0]
    done = np.trapezoid(np.maximum(power, 0), default.data["time"])
    assert float(default.summary["total_work_done"]) == pytest.approx(done, rel=1e-3)
    assert float(default.summary["work_done"][1]) == 0.0
    flat = fb.planar("PR", **WORD, limits=limits, passive=["joint2"], g=0)
    free = fb.simulate(flat, [0, -1.4], [0, 0], t, lambda now, q, qd: [3 * np.sin(5 * now), 0.0])
    found = fb.study(flat, fb.Motion.of(flat, t, *(free[x].values for x in ("q", "qd", "qdd"))))
    assert "times as fast" in found.verdict.text  # nothing but inertia, which scales


def test_a_page_numbers_drives_as_its_drawings_number_joints_and_claims_no_source(tmp_path: Path):
    (tmp_path / "crane.toml").write_text(
        crane("").replace('name = "lift"', 'name = "lift"\npassive = true')
    )
    study = fb.study(fb.load(tmp_path / "crane.toml"))
    text = study.to_html(tmp_path / "page.html").read_text(encoding="utf-8")
    for caption in (
        "Required torque, speed and power of each drive",
        "Work of each drive over the motion",
    ):
        table = text.partition(f"<caption>{caption}</caption>")[2].partition("</table>")[0]
        rows = re.findall(r'<tr><td class="count">(.*?)</td><th scope="row">(.*?)</th>', table)
        assert rows == [("2", "pin")], caption
    assert "<dd>no source given</dd>" in text
    assert "built in code" not in text
