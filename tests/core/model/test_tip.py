"""The tip: one rule chooses it when a robot is read, and everything asks the model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Limits, Model
from support.command import run
from support.robots import Joint, Link, Mimic, Mount, Robot, loaded, shift

TURN = Limits(-2.0, 2.0, 3.1, 57.0)


def robot(*rows: str, mimics: dict[str, str] | None = None, **how: Any) -> Model:
    """A robot by rows "child parent" of links joined by revolute joints (of a row with "=", fixed)
    with the child's name; mimics: the leader of each follower."""
    joints, names = [], ["base"]
    masses = how.pop("masses", {})
    ranges, kinds = how.pop("ranges", {}), how.pop("kinds", {})
    for row in rows:
        child, parent = row.replace("=", " ").split()
        names.append(child)
        kind = "fixed" if "=" in row else kinds.get(child, "revolute")
        leader = (mimics or {}).get(child)
        joints.append(
            Joint(
                child, kind, parent, child, shift(0.3, 0.0, 0.1),
                () if kind == "fixed" else (0.0, 0.0, 1.0) if len(names) % 2 else (0.0, 1.0, 0.0),
                Limits() if kind == "fixed" else ranges.get(child, TURN),
                mimic=None if leader is None else Mimic(leader),
            )
        )  # fmt: skip
    links = tuple(
        Link(name, Inertia.sphere(masses.get(name, 1.0), 0.1).moved_to((0.3, 0.0, 0.0)))
        for name in names
    )
    build = {name: how.pop(name) for name in ("tip", "mimic", "base") if name in how}
    described = Robot("robot", 3, links, tuple(joints), (9.81, (0.0, 0.0, -1.0)), **how)
    return loaded(described, **build)


ARM = ("a base", "b a", "c b")


# ---------------------------------------------------------------- which frame
def test_asked_for_and_described():
    model = robot(*ARM, tip="b")
    assert (model.tip, model.tip_reason) == ("b", "The tip is 'b', as asked.")
    mounts = (Mount("pen", "c", shift(0.1, 0.0, 0.0)), Mount("tool0", "b"))
    for given in (robot(*ARM, mounts=mounts, tip="pen"), fb.planar("RR")):
        assert given.tip_reason == (
            "The tip is 'pen', as asked."
            if given.tip == "pen"
            else "The tip is 'tip', as the robot's description says."
        )
    assert fb.load("ur5e", tip="forearm_link").tip_reason == "The tip is 'forearm_link', as asked."


@pytest.mark.parametrize(
    ("frames", "expected", "called"),
    [
        (("tool0", "arm_tcp"), "arm_tcp", "tcp"),
        (("Left-TCP-Link", "flange"), "Left-TCP-Link", "tcp"),
        (("one_tcp", "two_tcp", "tool0"), "tool0", "tool0"),
        (("flange", "ee_link"), "flange", "flange"),
        (("rightEndEffector", "grasp"), "rightEndEffector", "ee…"),
        (("lbr_link_ee_kuka",), "lbr_link_ee_kuka", "ee…"),
        (("ee_arm_link", "ee_gripper_link", "hand_grasping_frame"), "hand_grasping_frame",
         "grasp… or gripper_frame"),
    ],
)  # fmt: skip
def test_the_first_convention_that_names_one_frame(
    frames: tuple[str, ...], expected: str, called: str
):
    model = robot(*ARM, mounts=tuple(Mount(name, "c") for name in frames))
    assert model.tip == expected
    assert model.tip_reason == f"The tip is {expected!r}, the only frame called {called}."


def test_names_that_only_look_alike_and_those_of_the_ground():
    names = ("knee", "wheel_left", "flange_camera", "tcpip", "tool1")
    model = robot(*ARM, mounts=(*(Mount(x, "c") for x in names), Mount("tool0", "base")))
    assert model.tip == "c"
    assert robot(*ARM, mounts=(Mount("tool0", "a"),)).tip == "tool0"


GRIPPERS = {
    "two fingers, one follows": ({}, ("l hand", "r hand"), {"r": "l"}),
    "two equal fingers": ({"ranges": {"l": Limits(0, 0.5), "r": Limits(-0.5, 0)}},
                          ("l hand", "r hand"), {}),
    "masses as files round them": ({"masses": {"l": 1.0, "r": 1.001}}, ("l hand", "r hand"), {}),
    "links that follow": ({}, ("l hand", "l2 l", "r hand", "r2 r", "bar hand"),
                          {"l2": "l", "r": "l", "r2": "l", "bar": "l"}),
    "a gear beside": ({"ranges": {"gear": Limits()}}, ("gear hand", "l hand", "r hand"),
                      {"r": "l"}),
    "three equal fingers": ({}, ("l hand", "m hand", "r hand"), {}),
}  # fmt: skip


@pytest.mark.parametrize("name", GRIPPERS)
def test_grippers_do_not_count(name: str):
    how, fingers, mimics = GRIPPERS[name]
    model = robot(*ARM, "hand=c", "camera=c", *fingers, mimics=mimics, **how)
    assert model.tip == "hand"
    assert model.tip_reason.startswith(
        "The tip is 'hand', the end of the longest chain of joints (3); the gripper behind it ("
    )
    free = robot(*ARM, "hand=c", "camera=c", *fingers, mimics=mimics, mimic="free", **how)
    assert free.tip == "hand"  # what followed is still a gripper


def test_wheels_and_an_arm():
    wheels = ("w1 base", "w2 base", "w3 base", "w4 base")
    assert robot(*wheels, *ARM, ranges={x[:2]: Limits() for x in wheels}).tip == "c"
    coupled = {"w2": "w1", "w3": "w1", "w4": "w1"}
    assert robot(*wheels, *ARM, mimics=coupled).tip == "c"  # which is longer than they


def test_joints_along_an_arm_that_follow_are_no_gripper():
    telescope = robot(*ARM, mimics={"c": "b"})
    parallelogram = robot(*ARM, "bar a", mimics={"bar": "b", "c": "b"})
    assert (telescope.tip, parallelogram.tip) == ("c", "c")


def test_what_is_fixed_at_the_end_leads_as_far_as_it_does_not_fork():
    assert robot(*ARM, "d=c", "e=d").tip == "e"
    assert robot(*ARM, "d=c", "e=d", "f=d").tip == "d"


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (("l1 base", "l2 l1", "r1 base", "r2 r1"), "2 chains have 2 movable joints each, the most. "
         "Candidates: l2 and r2."),
        (("l base", "r base"), "nothing moves but equal branches of one joint. Candidates: l and "
         "r."),
        (tuple(f"{k}{i} {k + str(i - 1) if i else 'base'}" for k in "abcdefghij" for i in (0, 1)),
         "10 chains have 2 movable joints each, the most. Candidates: a1, b1, c1, d1, e1, f1, g1 "
         "and 3 more."),
        (("d=base",), "nothing moves."),
    ],
)  # fmt: skip
def test_none_with_candidates(rows: tuple[str, ...], why: str):
    model = robot(*rows)
    assert model.tip is None
    assert model.tip_reason == f"No tip is chosen: {why}"


def test_limbs_of_unequal_joints_are_no_fingers():
    for how in (
        {"masses": {"l": 2.0}},
        {"ranges": {"l": Limits(-1.0, 2.5)}},
        {"kinds": {"l": "prismatic"}},
    ):
        assert robot("a base", "l a", "r a", **how).tip is None
    assert robot("a base", "l a", "pad=l", "r a").tip is None


def test_limbs_of_which_only_the_first_joints_follow_are_no_fingers():
    assert robot("a base", "b a", "c b", "d a", "e d", mimics={"d": "b"}).tip is None


def test_the_notice_says_it_once_and_follows_what_is_chosen():
    model = robot(*ARM)

    def told(model: Model) -> list[str]:
        return [notice.text for notice in model.notices if notice.kind == "tip"]

    assert told(model) == [model.tip_reason]
    assert told(model.replace(tip="b")) == ["The tip is 'b', as asked."]
    tooled = model.with_tool("pen", (0.1, 0.0, 0.0))
    assert (tooled.tip, told(tooled)) == ("pen", ["The tip is 'pen', as asked."])
    for kept in (
        model.replace(tip="b").with_frame("tcp"),
        model.replace(tip="b").with_payload(mass=1.0),
        model.replace(tip="b").bind({"a.mass": 2.0}).replace(gravity=0).without("friction"),
    ):
        assert (kept.tip, told(kept)) == ("b", ["The tip is 'b', as asked."])
    assert robot(*ARM, base="free").tip == "c"


# ---------------------------------------------------------------- who asks
TWINS = ("l1 base", "l2 l1", "r1 base", "r2 r1")


def test_everything_asks_the_model():
    """The same frame for inverse kinematics and a load; of a robot that had none before."""
    model = robot(*ARM, "hand=c", "l hand", "r hand", mimics={"r": "l"})
    q = np.array([0.2, 0.3, 0.4, 0.0])
    target = fb.forward_kinematics(model, q)
    assert np.array_equal(target, fb.forward_kinematics(model, q, "hand"))
    reached = fb.inverse_kinematics(model, target[:3, 3], q0=q).q[0]
    assert fb.forward_kinematics(model, reached, "hand")[:3, 3] == pytest.approx(target[:3, 3])
    loaded = model.bind({"payload.mass": 3.0})
    assert loaded == model.with_payload(mass=3.0, frame="hand")


def test_who_needs_a_tip_says_which_there_may_be():
    model = robot(*TWINS)
    reason = (
        "No tip is chosen: 2 chains have 2 movable joints each, the most. Candidates: l2 and r2."
    )
    z = np.zeros(4)
    for call in (
        lambda: fb.forward_kinematics(model, z),
        lambda: fb.inverse_kinematics(model, np.zeros(3)),
        lambda: model.with_payload(mass=1.0),
        lambda: fb.kernel(model, "jacobian"),
    ):
        with pytest.raises(fb.FreebodyError) as refused:
            call()
        assert str(refused.value) == (
            f"'robot' has no single tip. {reason} Name a frame, or choose the tip with tip= "
            f"(--tip)."
        )
    for call in (
        lambda: model.bind({"payload.mass": 1.0}),
        lambda: fb.kernel(model, "inverse_dynamics", inputs=["payload.mass"]),
    ):
        with pytest.raises(fb.FreebodyError) as refused:
            call()
        assert str(refused.value) == (
            f"'robot' has no 'payload.mass', which would be of a load at the tip. {reason} Choose "
            f"the tip with tip= (--tip)."
        )


def test_a_study_without_a_tip_leaves_out_what_is_of_a_tip(tmp_path: Path):
    model = robot(*TWINS)
    study = fb.study(model)
    assert (study.tip, study.singularity, study.model.tip_reason) == (None, None, model.tip_reason)
    assert not [name for name in study.data.data_vars if "tip" in name or "singular" in name]
    study.save(tmp_path, report=True)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert page.count("Candidates: l2 and r2.") == 2  # above, and where the tip's path would be
    assert "Orange: the path" not in page
    assert "Largest payload at rest" not in page
    chosen = fb.study(model, tip="r2")
    assert (chosen.tip, chosen.model.tip) == ("r2", "r2")
    assert chosen.model.tip_reason == "The tip is 'r2', as asked."
    assert chosen.model.tip_reason not in chosen.notices
    whole = chosen.to_html(tmp_path / "whole.html").read_text("utf-8")
    assert "Orange: the path of r2" in whole
    assert "Largest payload at rest" in whole


# ---------------------------------------------------------------- the command
def test_commands_take_the_tip(tmp_path: Path, monkeypatch: Any, capsys: Any):
    monkeypatch.chdir(tmp_path)
    fb.save(robot(*TWINS), "twins.toml")
    loaded = ("--parameter", "payload.mass=3")
    for words in (
        ("study", "twins.toml"),
        ("plan", "twins.toml", "0,0,0,0; 1,1,1,1", "--acceleration", "1"),
        ("simulate", "twins.toml", "--time", "0.1"),
        ("sweep", "twins.toml", "gravity_torque", "--states", "2"),
        ("show", "twins.toml"),
    ):
        assert run([*words, *loaded]) == 2
        assert "Candidates: l2 and r2. Choose the tip" in " ".join(capsys.readouterr().err.split())
        assert run([*words, *loaded, "--tip", "l2"]) == 0
    capsys.readouterr()
    assert run(["show", "twins.toml"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "no single tip" in said
    assert "note: No tip is chosen: 2 chains" in said
    jacobian = ("sweep", "twins.toml", "jacobian", "--states", "2", "--over", "gravity=1:2:2")
    assert run([*jacobian]) == 2
    capsys.readouterr()
    assert run([*jacobian, "--frame", "l1"]) == 0
    framed = capsys.readouterr().out
    assert run([*jacobian, "--tip", "l1"]) == 0
    assert capsys.readouterr().out == framed
    assert run(["export", "twins.toml", "jacobian", "--tip", "l2"]) == 0


def test_derive_and_check_take_the_tip(tmp_path: Path, monkeypatch: Any, capsys: Any):
    monkeypatch.chdir(tmp_path)
    Path("arm.toml").write_text('name = "arm"\n[planar]\nword = "RR"\n', "utf-8")
    right = "x = l1*cos(theta1)"
    assert run(["check", "arm.toml", right]) == 1
    assert run(["check", "arm.toml", right, "--tip", "link2"]) == 0
    assert run(["derive", "arm.toml", "--tip", "link2", "--load"]) == 0
    assert "f_x" in capsys.readouterr().out
