"""`fb.same_robot`: one robot in five formats, with frames, zeros and names of its own, is
recognised; planted differences are found at their place with their size."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.real_files import FILES, ROBOTS
from support.written_robots import FORMATS, Written, bodies_of, disguised, rotation, toml, urdf

ROBOTS_OF_TESTS = {"ur5e": None, "panda": 7, "puma560": None}
"""Names, and how many bodies are written: the Panda's without its fingers."""
NOT_IN = {"urdf": {"armature"}, "split.urdf": {"armature"}, "sdf": {"armature"}}
"""What formats lack."""


@cache
def written(name: str) -> tuple[Written, ...]:
    """The bodies of a bundled robot, with inertias that rigid bodies have."""
    found = []
    for body in bodies_of(fb.load(name, physical="ignore"), ROBOTS_OF_TESTS[name]):
        mass = body.mass or 3.0
        second = 0.5 * np.trace(body.tensor) * np.eye(3) - body.tensor
        values, axes = np.linalg.eigh(second)
        second = axes @ np.diag(np.maximum(values, 1e-4)) @ axes.T
        found.append(replace(body, mass=mass, tensor=np.trace(second) * np.eye(3) - second))
    return tuple(found)


@pytest.mark.sample(1)
@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("name", ROBOTS_OF_TESTS)
def test_one_robot_is_recognised_in_other_words_and_formats(name, suffix, tmp_path):
    if suffix == "xml":
        pytest.importorskip("mujoco")
    first, path = tmp_path / "first.toml", tmp_path / f"second.{suffix}"
    first.write_text(toml(written(name)), encoding="utf-8")
    for seed in range(1 if suffix == "xml" else 2):
        other = disguised(written(name), np.random.default_rng([seed, len(name)]))
        path.write_text(FORMATS[suffix](other), encoding="utf-8")
        found = fb.same_robot(first, path)
        assert found, str(found)
        assert found.joints == {a.joint: b.joint for a, b in zip(written(name), other, strict=True)}
        said = "\n".join(found.regardless)
        assert "the base of" in said
        assert "joints have another zero: " in said
        assert "joints are renamed: " in said
        assert ("split differently" in said) == (suffix == "split.urdf")
        assert ("no speed limits: not compared" in said) == (suffix == "xml" and name != "puma560")


def test_a_tree_is_recognised_by_what_hangs_where():
    model = fb.load("panda")
    branched = [replace(x, parent=x.parent if k < 7 else 6) for k, x in enumerate(bodies_of(model))]
    first = fb.load(text=urdf(branched), format="urdf")
    for seed in range(3):
        order = [0, 1, 2, 3, 4, 5, 6, 8, 7]
        other = disguised(branched, np.random.default_rng(seed))
        second = fb.load(text=urdf([other[k] for k in order]), format="urdf")
        found = fb.same_robot(first, second)
        assert found, str(found)
        assert found.joints["panda_finger_joint2"] == "axis_9"


@pytest.mark.parametrize("name", ["panda", "2R", "five_bar"])
def test_a_base_that_floats_is_one_difference(name, tmp_path):
    """And what the bases carry is compared: joints are not taken for others because of it."""
    model, file = fb.load(name, physical="ignore"), tmp_path / "robot.toml"
    model = model.bind(dict.fromkeys(model.missing, 0.7))
    fb.save(model, file)
    other = fb.load(file, base="free", physical="ignore")
    for one, two in ((model, other), (other, model)):
        found = fb.same_robot(one, two)
        assert [x.aspect for x in found.differences] == ["joints"], str(found)
        assert "and the base of" in found.differences[0].text
        assert found.joints == {x: x for x in model.joint_names}
    assert fb.same_robot(other, fb.load(file, base="free", physical="ignore"))
    loaded = fb.same_robot(model, other.with_payload(0.5))
    assert [x.aspect for x in loaded.differences][:2] == ["joints", "masses"]


TABLES = {
    "ur5e": ("standard", [
        (0, np.pi / 2, 0.1625), (-0.425, 0, 0), (-0.3922, 0, 0), (0, np.pi / 2, 0.1333),
        (0, -np.pi / 2, 0.0997), (0, 0, 0.0996)]),
    "panda": ("modified", [
        (0, 0, 0.333), (0, -np.pi / 2, 0), (0, np.pi / 2, 0.316), (0.0825, np.pi / 2, 0),
        (-0.0825, -np.pi / 2, 0.384), (0, np.pi / 2, 0), (0.088, np.pi / 2, 0)]),
    "puma560": ("standard", [
        (0, np.pi / 2, 0), (0.4318, 0, 0), (0.0203, -np.pi / 2, 0.15005),
        (0, np.pi / 2, 0.4318), (0, -np.pi / 2, 0), (0, 0, 0)]),
}  # fmt: skip
"""Published DH tables: a, alpha and d of each joint."""


@pytest.mark.parametrize("name", TABLES)
def test_a_dh_table_is_recognised(name, tmp_path):
    convention, rows = TABLES[name]
    path = tmp_path / "table.csv"
    lines = [f"# convention: {convention}", "a,alpha,d,theta"]
    rng = np.random.default_rng(1)
    lines += [",".join(map(repr, map(float, (*row, rng.uniform(-1, 1))))) for row in rows]
    path.write_text("\n".join(lines), encoding="utf-8")
    other = disguised(written(name), np.random.default_rng(2))
    found = fb.same_robot(path, fb.load(text=urdf(other), format="urdf"))
    assert found, str(found)
    said = "\n".join(found.regardless)
    assert "'table' gives no masses: not compared" in said
    assert "lower limits" in said.partition("'table' gives no masses: not compared")[2]
    assert len(found.joints) == len(rows)


def test_a_dh_table_with_masses_is_recognised(tmp_path):
    """The Puma's table in freebody's TOML is a DH table, in whose frames its masses are."""
    other = disguised(bodies_of(fb.load("puma560", physical="ignore")), np.random.default_rng(4))
    found = fb.same_robot("puma560", fb.load(text=toml(other), format="toml", physical="ignore"))
    assert found, str(found)


@pytest.mark.sample(16)
@pytest.mark.parametrize("name", sorted(fb.models()))
def test_each_bundled_robot_is_itself(name):
    if fb.load(name, physical="ignore").missing:
        pytest.skip("it has parameters without value")
    found = fb.same_robot(name, name)
    assert found
    assert found.regardless == ()


# ------------------------------------------------------------ differences
@dataclass(frozen=True)
class Planted:
    """A change of one body, the aspect in which it is found, its size where that is plain, and the
    joint or body, counted from the one that is changed, that is named."""

    aspect: str
    change: Callable[[Written], Written]
    size: float | None = None
    says: str = ""
    after: int = 0


def moved(*by: float) -> Callable[[Written], Written]:
    """The joint's frame elsewhere, in its own axes."""
    return lambda x: replace(x, pose=(x.pose[0], x.pose[1] + x.pose[0] @ np.array(by)))


def tilted(axis: int, angle: float) -> Callable[[Written], Written]:
    """The joint's frame turned about its own x or y."""
    turn = rotation(np.eye(3)[axis], angle)
    return lambda x: replace(x, pose=(x.pose[0] @ turn, x.pose[1]))


def limit(key: str, by: float) -> Callable[[Written], Written]:
    return lambda x: replace(x, limits={**x.limits, key: x.limits[key] + by})


def tensor(i: int, j: int, by: float) -> Callable[[Written], Written]:
    """An entry of the inertia, with its mirror image."""
    change = np.zeros((3, 3))
    change[i, j] = change[j, i] = by
    return lambda x: replace(x, tensor=x.tensor + change)


def scaled(name: str, factor: float) -> Callable[[Written], Written]:
    return lambda x: replace(x, **{name: getattr(x, name) * factor})


PLANTED = (
    Planted("geometry", moved(0.003, 0.0, 0.0), 0.003, "3 mm"),
    Planted("geometry", moved(-0.0004, 0.0, 0.0), 0.0004, "0.4 mm"),
    Planted("geometry", tilted(0, 0.01), 0.01, "0.01 rad (0.573°)"),
    Planted("geometry", tilted(0, -0.0004), 0.0004),
    Planted("masses", scaled("mass", 1.01), None, "its mass is "),
    Planted("masses", scaled("mass", 0.5), None, "its mass is "),
    Planted("masses", lambda x: replace(x, com=x.com + [0.002, 0.0, 0.001]), 5**0.5 / 1e3),
    Planted("masses", lambda x: replace(x, com=x.com * [1.0, 1.0, -1.0]), None, "centre of mass"),
    Planted("masses", tensor(0, 0, 1e-3), 1e-3, "its inertia differs"),
    Planted("masses", tensor(1, 1, 2e-4), 2e-4),
    Planted("masses", tensor(0, 2, 3e-4), 3e-4 * 2**0.5),
    Planted("masses", scaled("tensor", 1.1), None, "its inertia differs"),
    Planted("limits", limit("lower", 0.1), 0.1, "limit is "),
    Planted("limits", limit("upper", -0.3), 0.3, "limit is "),
    Planted("limits", limit("velocity", 0.5), 0.5, "its speed limit is "),
    Planted("limits", limit("effort", -3.0), 3.0, "its effort limit is "),
    Planted("friction", lambda x: replace(x, damping=x.damping + 0.2), 0.2),
    Planted("friction", lambda x: replace(x, friction=x.friction + 0.1), 0.1),
    Planted("joints", lambda x: replace(x, kind="prismatic"), None, "revolute and prismatic"),
)
PLACES = 3
"""Joints that each difference is planted in: one of each robot."""


def test_many_differences_are_planted():
    assert len(PLANTED) * PLACES >= 40


@pytest.mark.sample(1)
@pytest.mark.parametrize("number", range(len(PLANTED)))
def test_planted_differences_are_found_at_their_place(number):
    planted = PLANTED[number]
    for which, name in enumerate(ROBOTS_OF_TESTS):
        bodies = [
            replace(x, damping=x.damping + 0.1, friction=x.friction + 0.1,
                    limits={"effort": 50.0, "velocity": 3.0} | x.limits)
            for x in written(name)
        ]  # fmt: skip
        k = 2 + (number + which) % 3
        changed = list(bodies)
        changed[k] = planted.change(bodies[k])
        other = disguised(changed, np.random.default_rng([number, which]))
        models = [fb.load(text=urdf(x), format="urdf", physical="ignore") for x in (bodies, other)]
        found = fb.same_robot(*models)
        first = found.first
        assert first is not None, (name, k)
        assert first.aspect == planted.aspect, str(found)
        of_bodies = planted.aspect == "masses"
        names = [(x.name if of_bodies else x.joint) for x in (bodies[k], other[k])]
        assert list(first.place) == names, str(found)
        assert planted.says in first.text
        if planted.size is not None:
            assert first.size == pytest.approx(planted.size, rel=1e-3)
        if planted.aspect != "joints":
            assert len(found.differences) == 1, str(found)


def test_a_joint_more_is_named():
    bodies = written("panda")
    models = [fb.load(text=urdf(x), format="urdf") for x in (bodies, bodies[:-1])]
    (only,) = fb.same_robot(*models).differences
    assert only.place == ("panda_joint7", "")
    assert "has no counterpart of" in only.text
    (only,) = fb.same_robot(*reversed(models)).differences
    assert only.place == ("", "panda_joint7")


def test_a_flexible_joint_is_a_joint_with_a_shaft(tmp_path):
    """The joints before and behind it are those of the rigid robot; a copy whose links lie
    otherwise is the same."""
    rigid = fb.load(text=toml(written("puma560")), format="toml")
    stiff, soft = (rigid.with_flexible_joint("joint2", stiffness=k, damping=3) for k in (2e4, 1e4))
    (only,) = fb.same_robot(rigid, stiff).differences
    assert (
        only.text
        == f"has a shaft that twists, 'joint2_twist', in {stiff.name + ' (second)'!r} alone"
    )
    assert only.place == ("joint2", "joint2")
    (only,) = fb.same_robot(stiff, soft).differences
    assert only.place == ("joint2_twist", "joint2_twist")
    assert only.size == pytest.approx(1e4)
    elsewhere = rigid.with_flexible_joint("joint3", stiffness=1e4)
    assert [x.place[0] for x in fb.same_robot(soft, elsewhere).differences] == ["joint2", "joint3"]
    fb.save(soft, tmp_path / "copy.csv", lossy=True)
    found = fb.same_robot(soft, tmp_path / "copy.csv")
    assert found.joints["joint2_twist"] == "joint2_twist"
    assert {x.place[0] for x in found.differences} == {"joint2_twist"}  # it has no motor


def test_a_flexible_joint_in_the_plane():
    rotor = fb.Drive(rotor=1e-3, gear=20.0)
    rigid = fb.planar(
        "RPR", m=[1, 2, 1], lc=[0.2] * 3, l=[0.5] * 3, I=[0.1] * 3, drives=[rotor] * 3
    )
    for joint in rigid.joint_names:
        stiff, soft = (rigid.with_flexible_joint(joint, stiffness=k) for k in (2e4, 1e4))
        assert fb.same_robot(stiff, stiff.to_space())
        (only,) = fb.same_robot(stiff, soft).differences
        assert only.place == (f"{joint}_twist", f"{joint}_twist")
        (only,) = fb.same_robot(rigid, stiff).differences
        assert only.place == (joint, joint)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "3RRR"])
def test_closed_chains_are_recognised_in_mjcf(name, tmp_path):
    """Two connects are a pin there, and a planar joint is three."""
    pytest.importorskip("mujoco")
    fb.save(fb.load(name), tmp_path / "robot.xml", lossy=True)
    found = fb.same_robot(name, tmp_path / "robot.xml")
    assert found, str(found)
    assert not [x for x in found.regardless if "renamed" not in x]


def test_rotors_are_what_the_joint_feels():
    bodies = written("puma560")
    model = fb.load(text=toml(bodies), format="toml")
    geared = model.with_drive("joint2", rotor=bodies[1].armature / 100.0, gear=-10.0)
    assert fb.same_robot(model, geared)
    other = model.with_drive("joint2", rotor=1.1 * bodies[1].armature)
    first = fb.same_robot(model, other).first
    assert first is not None
    assert first.aspect == "friction"
    assert "its rotor's inertia is" in first.text


COGGED = """
name = "cogged"
[[link]]
name = "ground"
[[link]]
name = "bob"
mass = 2.0
com = [0.5, 0.1, 0.2]
inertia = [0.1, 0, 0, 0.1, 0, 0.1]
[[joint]]
name = "pin"
kind = "revolute"
axis = "{axis}"
parent = "ground"
child = "bob"
rpy = [0, {pitch}, 0]
cogging = {{ amplitude = {amplitude}, count = 5, phase = {phase} }}
"""


@pytest.mark.parametrize(
    ("amplitude", "turned", "same"),
    [(0.3, 0.0, True), (-0.3, math.pi, True), (0.3, 4 * math.pi, True), (0.3, 0.1, False)],
)
def test_cogs_are_the_same_from_another_zero_in_the_other_direction(amplitude, turned, same):
    phase, pitch = 0.4, 0.3
    one = {"axis": "y", "pitch": 0.0, "amplitude": 0.3, "phase": phase}
    other = {
        "axis": "-y", "pitch": pitch, "amplitude": amplitude, "phase": 5 * pitch - phase + turned
    }  # fmt: skip
    models = [fb.load(text=COGGED.format(**x), format="toml") for x in (one, other)]
    forward = fb.inverse_dynamics(models[0], [0.1], [0.0], [1.0])
    back = fb.inverse_dynamics(models[1], [pitch - 0.1], [0.0], [-1.0])
    assert (forward == pytest.approx(-back)) is same
    assert bool(fb.same_robot(*models)) is same


def test_mimics_are_compared_through_zeros_and_directions():
    text = """<robot name="hand"><link name="a"/>{links}
<joint name="lead" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 {s} 0"/>
<origin xyz="0 {at} 0"/><limit lower="-9" upper="9"/></joint>
<joint name="follow" type="prismatic"><parent link="a"/><child link="c"/><axis xyz="0 0 1"/>
<limit lower="-9" upper="9"/><mimic joint="lead" multiplier="{m}" offset="{o}"/></joint></robot>"""
    links = "".join(
        f'<link name="{x}"><inertial><origin xyz="0 {y} 0"/><mass value="1"/><inertia ixx="1" '
        f'ixy="0" ixz="0" iyy="1.1" iyz="0" izz="1.2"/></inertial></link>'
        for x, y in (("b", "{c}"), ("c", "0"))
    )

    def hand(s: int, at: float, m: float, o: float, c: float) -> fb.Model:
        return fb.load(
            text=text.format(links=links.format(c=c), s=s, at=at, m=m, o=o), format="urdf",
            physical="ignore",
        )  # fmt: skip

    model = hand(1, 0.0, 2.0, 0.1, 0.0)
    # y = q = 0.3 - q': the follower is at 2 q + 0.1 = 0.7 - 2 q'
    same = fb.same_robot(model, hand(-1, 0.3, -2.0, 0.7, 0.0))
    assert [x for x in same.differences if x.aspect != "limits"] == []
    other = fb.same_robot(model, hand(-1, 0.3, -2.0, 0.8, 0.0))
    assert "an offset of 0.1 and 0.2" in str(other.first)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["cart_pole", "five_bar", "acrobot"])
def test_a_robot_in_the_plane_is_the_same_as_its_twin_in_space(name, tmp_path):
    flat = fb.load(name)
    flat = flat.bind(**{key: 0.7 for key, value in flat.parameters.items() if value is None})
    twin = flat.to_space()
    assert fb.same_robot(flat, twin)
    assert fb.same_robot(twin, flat)
    # MuJoCo has moments of inertia about all axes, and traces where there are none
    fb.save(flat, tmp_path / "robot.xml", lossy=True)
    found = fb.same_robot(tmp_path / "robot.xml", flat)
    assert {x.aspect for x in found.differences} <= {"joints"}
    # within the plane all counts
    heavier = flat.with_inertial_parameters(
        {key: 1.01 * value for key, value in fb.inertial_parameters(flat).items()}
    )
    assert {x.aspect for x in fb.same_robot(heavier, twin).differences} >= {"masses"}


def test_a_loop_in_the_plane_turns_about_its_normal():
    flat = fb.load("five_bar")
    twin = flat.to_space()
    tilted = replace(twin, loops=tuple(replace(x, axis=(1.0, 0.0, 0.0)) for x in twin.loops))
    for pair in ((flat, tilted), (tilted, flat)):
        assert {x.aspect for x in fb.same_robot(*pair).differences} == {"joints"}


def test_sentences_tell_robots_of_one_name_apart():
    arm = fb.load("cart_pole")
    arm = arm.bind(**{key: 0.7 for key, value in arm.parameters.items() if value is None})
    (only,) = fb.same_robot(arm, arm.replace(actuated=arm.joint_names)).differences
    assert only.text == "is passive in 'cart_pole (first)' alone"


def test_struts_are_compared():
    arm = fb.load("ur5e")
    gas = {"stiffness": 300.0, "rest": 0.4, "damping": 12.0, "preload": -60.0}
    ends = ("base", "forearm_link")
    one = arm.with_strut("gas", ends, **gas)
    (only,) = fb.same_robot(one, arm).differences
    assert only.place == ("gas", "")
    assert "no counterpart" in only.text
    (only,) = fb.same_robot(arm, one).differences
    assert only.place == ("", "gas")
    (only,) = fb.same_robot(one, arm.with_strut("gas", ends, **{**gas, "damping": 13})).differences
    assert only.text == "its damping is 12 and 13 N s/m"
    other = fb.same_robot(one, arm.with_strut("gas", ("base", "wrist_1_link"), **gas))
    assert len(other.differences) == 2
    # the same force, told from the other end with another rest length
    again = arm.with_strut("spring", ends[::-1], stiffness=300.0, rest=0.6, damping=12.0)
    assert fb.same_robot(one, again)
    # two between the same points, in another order
    firm = {**gas, "stiffness": 900.0}
    both = one.with_strut("firm", ends, **firm)
    swapped = arm.with_strut("firm", ends, **firm).with_strut("gas", ends, **gas)
    assert fb.same_robot(both, swapped)


def test_loops_are_compared():
    model = fb.load("stewart")
    loop = model.loops[0]
    frames = loop.frames[::-1]
    less = replace(model, loops=model.loops[1:])
    (only,) = fb.same_robot(model, less).differences
    assert only.place == (loop.name, "")
    (only,) = fb.same_robot(less, model).differences
    assert only.place == ("", loop.name)
    turned = replace(model, loops=(replace(loop, frames=frames), *model.loops[1:]))
    assert fb.same_robot(model, turned)


def test_many_joints_on_one_body_are_told_apart_by_their_axes():
    """Seven joints on the base, six of one kind: more ways to match them than are tried."""
    model = fb.load("stewart")
    bodies = tuple(
        replace(body, joint=replace(body.joint, name=f"x{k}"))
        for k, body in enumerate(model.bodies)
    )
    found = fb.same_robot(model, replace(model, bodies=bodies, home=()))
    assert found, str(found)
    assert found.joints == {x.joint.name: f"x{k}" for k, x in enumerate(model.bodies)}


WRONG_LINK4 = """<inertial><origin xyz="-0.05113 0.05825 0.01698"/><mass value="2.2037"/>
<inertia ixx="0.00784585566" ixy="-0.00339591957" ixz="0.00158704074" iyy="0.00649543136"
iyz="-0.00181477884" izz="0.01003079917"/></inertial>"""
"""Link 4 of Franka's own description package for the FER, which is the Panda
(https://github.com/frankarobotics/franka_description/issues/23)."""


def test_wrong_inertias_in_public_files_of_franka_are_found(tmp_path):
    bodies = bodies_of(fb.load("panda"), 7)
    text = urdf(bodies)
    begin = text.index("<inertial>", text.index('<link name="panda_link4">'))
    end = text.index("</inertial>", begin) + len("</inertial>")
    path = tmp_path / "fer.urdf"
    path.write_text(text[:begin] + WRONG_LINK4 + text[end:], encoding="utf-8")
    found = fb.same_robot("panda", path)
    of_mass = [x for x in found.differences if x.aspect == "masses"]
    assert of_mass[0].place == ("panda_link4", "panda_link4")
    assert of_mass[0].text == "its mass is 3.5879 and 2.2037 kg"
    # no rigid body has it, which Gazebo found too
    kinds = [(x.kind, x.severity) for x in fb.doctor(path).findings]
    assert ("inexact inertia", "notice") in kinds
    # a sign that was lost in link 5 (https://github.com/JeanElsner/panda_mujoco/issues/6)
    lost = [
        replace(x, com=x.com * [-1.0, 1.0, 1.0]) if x.name == "panda_link5" else x for x in bodies
    ]
    models = [fb.load(text=urdf(x), format="urdf") for x in (bodies, lost)]
    (only,) = fb.same_robot(*models).differences
    assert only.place[0] == "panda_link5"
    assert only.size == pytest.approx(2 * 0.011953)


# ------------------------------------------------------------ the command
def test_the_command_and_what_is_refused(tmp_path, capsys):
    path = tmp_path / "arm.toml"
    fb.save(fb.load("ur5e").with_payload(1.0), path)
    assert run(["diff", "ur5e", "ur5e"]) == 0
    assert capsys.readouterr().out == "ur5e (first) and ur5e (second) are the same robot.\n"
    assert run(["diff", "ur5e", str(path)]) == 1
    out = capsys.readouterr().out
    assert "ur5e (first) and ur5e (second) differ in " in out
    assert "masses: 'wrist_3_link': its mass is 0.365 and 1.365 kg" in out
    assert run(["diff", "ur5e", str(path), "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["differences"][0]["place"] == ["wrist_3_link", "wrist_3_link"]
    assert run(["diff", "ur5e", "nowhere"]) == 2
    capsys.readouterr()
    with pytest.raises(fb.FreebodyError, match="tolerance is 2"):
        fb.same_robot("ur5e", "ur5e", tolerance=2)
    with pytest.raises(fb.KindError):
        fb.same_robot("ur5e", 7)  # pyright: ignore[reportArgumentType]


@pytest.mark.long
@pytest.mark.parametrize("name", FILES)
def test_robots_of_a_data_wheel_are_themselves(name):
    try:
        model = fb.load(ROBOTS / name, physical="ignore", mimic="free")
    except fb.FileError:
        return  # refused
    assert fb.same_robot(model, model)


# ------------------------------------------------------------ struts and losses
UPPER, WRIST = ("z", 1, (0.05, 0.0, 0.4)), ("w", 4, (0.6, -0.2, 0.1))
"""Ends of a strut: a name, a body, and where it is in the world with all joints at zero."""


def strutted(model: fb.Model, ends=(UPPER, WRIST), name="gas", **numbers: float) -> fb.Model:
    """With a strut between points of two bodies, whatever their frames are."""
    for end, k, point in ends:
        link = model.bodies[k].name
        T = fb.forward_kinematics(model, np.zeros(model.nq), frame=link)
        model = model.with_frame(end, T[:3, :3].T @ (np.array(point) - T[:3, 3]), frame=link)
    return model.with_strut(name, (ends[0][0], ends[1][0]), **numbers)


GAS = {"stiffness": 500.0, "rest": 0.3, "damping": 20.0, "preload": -50.0}


@pytest.fixture
def table(tmp_path) -> fb.Model:
    """The UR5e with other frames, those of a DH table."""
    fb.save(fb.load("ur5e"), tmp_path / "arm.csv", lossy=True)
    return fb.load(tmp_path / "arm.csv")


def test_struts_are_recognised_by_their_points(table):
    model = strutted(fb.load("ur5e"), **GAS)
    for other in (
        strutted(table, **GAS),
        strutted(table, ends=(WRIST, UPPER), name="spring", **GAS),
        strutted(table, **(GAS | {"rest": 0.4, "preload": 0.0})),
    ):
        found = fb.same_robot(model, other)
        assert found, str(found)
        assert "struts" not in "\n".join(found.regardless)
    for one, two in ((model, table), (table, model)):
        assert "a strut that" in str(fb.same_robot(one, two))


@pytest.mark.parametrize(
    ("change", "text", "size"),
    [
        ({"stiffness": 505.0}, "its stiffness is 500 and 505 N/m", 5.0),
        ({"damping": 0.0}, "its damping is 20 and 0 N s/m", 20.0),
        ({"rest": 0.31}, "its length without force is 0.4 and 0.41 m", 0.01),
        ({"preload": -45.0}, "its length without force is 0.4 and 0.39 m", 0.01),
        ({"stiffness": 0.0, "preload": -40.0}, "its preload is -50 and -40 N", 10.0),
    ],
)
def test_differences_of_struts(change, text, size, table):
    found = fb.same_robot(strutted(fb.load("ur5e"), **GAS), strutted(table, **(GAS | change)))
    told = {x.text: x for x in found.differences}
    assert told[text].aspect == "struts"
    assert told[text].place == ("gas", "gas")
    assert told[text].size == pytest.approx(size)
    # by its stiffness a preload is another length
    assert len(told) == (2 if "stiffness" in change else 1)


def test_a_strut_between_other_points_has_no_counterpart(table):
    moved = (*WRIST[:2], (0.6, -0.2, 0.103))
    model, other = strutted(fb.load("ur5e"), **GAS), strutted(table, (UPPER, moved), "air", **GAS)
    found = fb.same_robot(model, other)
    assert [x.place for x in found.differences] == [("gas", ""), ("", "air")]
    assert found.first
    assert found.first.text == "a strut that 'ur5e (second)' has no counterpart of"


def test_struts_side_by_side_are_told_apart(table):
    numbers = [GAS, GAS | {"damping": 1.0}]
    one, two = fb.load("ur5e"), table
    for k, j in ((0, 1), (1, 0)):
        ends = [(f"{end}{k}", body, point) for end, body, point in (UPPER, WRIST)]
        one = strutted(one, ends, f"strut{k}", **numbers[k])
        two = strutted(two, ends, f"strut{k}", **numbers[j])
    assert fb.same_robot(one, two)


def test_losses_of_gears():
    plain = fb.load("ur5e")
    joint = plain.joint_names[1]

    def geared(forward: float, back: float) -> fb.Model:
        model = plain.with_drive(plain.joint_names[0], efficiency=0.9, back_efficiency=0.8)
        return model.with_drive(joint, efficiency=forward, back_efficiency=back)

    assert fb.same_robot(geared(0.8, 0.7), geared(0.8, 0.7))
    assert fb.same_robot(geared(1.0, 1.0), geared(0.0, 0.0))
    found = fb.same_robot(geared(0.8, 0.7), geared(0.0, 0.0))
    assert [(x.place, x.size) for x in found.differences] == [
        ((joint, joint), pytest.approx(0.25)),
        ((joint, joint), pytest.approx(0.3)),
    ]
    assert "takes 0.25 and 0 of the torque that it transmits while the motor drives" in str(found)
    one, two = (plain.with_drive(joint, load_friction=x) for x in (0.1, 0.2))
    assert fb.same_robot(one, two).differences[0].size == pytest.approx(0.1)
    told = "\n".join(fb.same_robot(one, plain).regardless)
    assert "gives no load-dependent friction: not compared" in told
