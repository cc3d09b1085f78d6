"""URDF: what is read, what is said of the rest, what is refused; and every example robot beside
Pinocchio."""

import math
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from support.extras import extra
from support.real_files import FILES, REFUSED, ROBOTS


def read(tmp_path: Path, body: str, *, robot: str = '<robot name="arm">', **options) -> Model:
    """The model of a URDF with this inside; `base` and `hand` are there, joined by `body` or not at
    all."""
    path = tmp_path / "arm.urdf"
    path.write_text(f'{robot}\n<link name="base"/>\n<link name="hand"/>\n{body}\n</robot>\n')
    return fb.load(path, **options)


def joint(inside: str = "", kind: str = "revolute", name: str = "elbow", ends: str = "") -> str:
    """A joint on line 4 and the following."""
    ends = ends or '<parent link="base"/><child link="hand"/>'
    return f'<joint name="{name}" type="{kind}">{ends}\n{inside}</joint>'


def message(tmp_path: Path, body: str, **options) -> str:
    """The refusal, from the file's name on."""
    with pytest.raises(fb.FreebodyError) as refusal:
        read(tmp_path, body, **options)
    text = str(refusal.value)
    assert "\n" not in text
    return text.replace(f"{tmp_path}/", "")


def said(model: Model, kind: str) -> list[str]:
    """Texts of the notices of a kind, each behind its line."""
    return [f"{n.line}: {n.text}" if n.line else n.text for n in model.notices if n.kind == kind]


# ---------------------------------------------------------------- every real file, beside Pinocchio
@pytest.mark.sample(8)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("name", FILES)
def test_real_file_as_pinocchio_reads_it(name: str, base: str):
    pin = extra("pinocchio", "Pinocchio")
    path = str(ROBOTS / name)
    if name in REFUSED and "mimic" not in REFUSED[name]:
        with pytest.raises(fb.FreebodyError, match=REFUSED[name]):
            fb.load(path, base=base)
        return
    model = fb.load(path, base=base, mimic="free", snap_angles=0.0, physical="ignore")
    root = [pin.JointModelFreeFlyer()] if base == "free" else []
    theirs = pin.buildModelFromUrdf(path, *root, mimic=False)
    assert (model.nq, model.nv) == (
        theirs.nq - sum(j.nq - j.nv for j in theirs.joints if j.nv == 1),
        theirs.nv,
    )
    number = {
        "root_joint" if joint == "base" else joint: i for i, joint in enumerate(model.joint_names)
    }
    assert set(number) == set(theirs.names) - {"universe"}
    for i in range(1, theirs.njoints):
        same_body(
            model,
            model.tree.body_of[number[theirs.names[i]]],
            theirs.jointPlacements[i],
            theirs.inertias[i],
        )
    on_base = sum(part.inertia.mass for part in model.base_inertias)
    assert model.mass - on_base == pytest.approx(pin.computeTotalMass(theirs), rel=1e-12, abs=1e-15)


def same_body(model: Model, index: int, placement, inertia) -> None:
    """A body of ours has the placement and the inertia of theirs."""
    body = model.tree.bodies[index]
    np.testing.assert_allclose(np.array(body.R, dtype=float), placement.rotation, atol=1e-14)
    np.testing.assert_allclose(np.array(body.p, dtype=float), placement.translation, atol=1e-14)
    parts = [fb.Inertia.of(m.m, m.c, np.array(m.inertia, dtype=float)) for m in body.masses]
    whole = sum(parts[1:], parts[0]) if parts else fb.Inertia.nothing()
    mass, com, tensor = whole.numbers()
    assert mass == pytest.approx(inertia.mass, rel=1e-12, abs=1e-15)
    if mass > 0:
        np.testing.assert_allclose(com, inertia.lever, atol=1e-12)
    np.testing.assert_allclose(
        tensor, inertia.inertia, atol=1e-12 * max(1e-3, abs(inertia.inertia).max())
    )


@pytest.mark.sample(16)
@pytest.mark.parametrize("name", FILES)
def test_real_file_with_mimics_followed(name: str):
    pin = extra("pinocchio", "Pinocchio")
    path = str(ROBOTS / name)
    if name in REFUSED:
        with pytest.raises(fb.FreebodyError, match=REFUSED[name]):
            fb.load(path, physical="ignore")
        return
    model = fb.load(path, physical="ignore")
    followers = sum(body.joint.mimic is not None for body in model.bodies)
    assert model.nv == pin.buildModelFromUrdf(path, mimic=False).nv - followers
    assert model.nv < len(model.bodies) or not followers


@pytest.mark.skipif(not FILES, reason="needs example-robot-data")
def test_docs_name_the_refused_files():
    page = (Path(__file__).parents[3] / "docs/formats.md").read_text(encoding="utf-8")
    assert all(Path(name).name in page for name in REFUSED)


# ---------------------------------------------------------------- what is read
def test_inertia_in_turned_axes(tmp_path):
    link = """<link name="arm"><inertial><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
      <mass value="2"/><inertia ixx="3" ixy="0" ixz="0" iyy="2" iyz="0" izz="4"/></inertial></link>
      <joint name="a" type="revolute"><parent link="base"/><child link="arm"/>
      <axis xyz="0 0 1"/></joint>"""
    model = read(
        tmp_path, link + joint(kind="fixed", ends='<parent link="arm"/><child link="hand"/>')
    )
    (mass,) = model.tree.bodies[0].masses
    assert (mass.m, mass.c) == (2.0, (0.0, 0.0, 1.0))
    np.testing.assert_allclose(
        np.array(mass.inertia, dtype=float), np.diag([2.0, 3.0, 4.0]), atol=1e-15
    )


def test_defaults_of_a_joint(tmp_path):
    model = read(tmp_path, joint())
    (only,) = model.bodies
    assert only.joint.axis == (1.0, 0.0, 0.0)
    assert only.joint.limits == fb.Limits()
    assert only.joint.drive == fb.Drive()
    assert said(model, "limits") == [
        "4: joint 'elbow': a revolute joint without <limit>; its range is taken as infinite."
    ]


def test_friction_and_limits(tmp_path):
    inside = (
        '<limit lower="-1" upper="2" velocity="3" effort="4"/>'
        '<dynamics damping="0.5" friction="0.25"/>'
    )
    (body,) = read(tmp_path, joint(inside)).bodies
    assert body.joint.limits == fb.Limits(-1.0, 2.0, 3.0, 4.0)
    assert body.joint.drive == fb.Drive(viscous=0.5, coulomb=0.25)


def test_continuous_joint_keeps_speed_and_effort(tmp_path):
    (body,) = read(
        tmp_path, joint('<limit lower="-1" upper="1" velocity="3" effort="4"/>', "continuous")
    ).bodies
    assert body.joint.limits == fb.Limits(-math.inf, math.inf, 3.0, 4.0)


def test_limits_of_zero_are_unknown(tmp_path):
    model = read(tmp_path, joint('<limit lower="-1" upper="1" velocity="0" effort="0"/>'))
    assert model.bodies[0].joint.limits == fb.Limits(-1.0, 1.0)
    assert said(model, "limits") == [
        "5: velocity limits of 0 are read as no limit (once).",
        "5: effort limits of 0 are read as no limit (once).",
    ]


def test_right_angles_snap_and_say_so(tmp_path):
    near = joint('<origin rpy="1.570796325 0 -3.14159265359"/>', "fixed")
    model = read(tmp_path, near)
    _, R, _ = model.tree.frames["hand"]
    assert R == ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    assert said(model, "snapped") == [
        "2 angles within 3e-09 rad of a multiple of a right angle are read as that multiple; "
        "largest change 1.8e-09 rad. snap_angles=0 reads them as written."
    ]
    written = read(tmp_path, near, snap_angles=0)
    _, R, _ = written.tree.frames["hand"]
    assert R[1][1] == math.cos(1.570796325) * math.cos(-3.14159265359)
    assert said(written, "snapped") == []


def test_axis_is_normalised_and_said(tmp_path):
    model = read(tmp_path, joint('<axis xyz="3 0 4"/>', "continuous"))
    assert model.bodies[0].joint.axis == (0.6, 0.0, 0.8)
    assert said(model, "axis") == [
        "5: joint 'elbow': the axis has length 5; it is made a unit vector."
    ]


def test_an_axis_beside_a_coordinate_axis_is_taken_as_it_is(tmp_path):
    """Rodrigues' formula for the axis (1, e, 0), to first order in e; Pinocchio makes it (1, 0,
    0)."""
    e, angle = 1e-12, 0.7
    model = read(tmp_path, joint(f'<axis xyz="1 {e} 0"/>', "continuous"))
    R = fb.forward_kinematics(model, [angle], "hand")[:3, :3]
    turn = (1.0 - math.cos(angle)) * e
    expected = [turn, e * math.sin(angle), turn, -e * math.sin(angle)]
    assert [R[0, 1], R[0, 2], R[1, 0], R[2, 0]] == pytest.approx(expected, rel=1e-12)


def test_floating_joint_is_free(tmp_path):
    model = read(tmp_path, joint(kind="floating"))
    assert (model.nq, model.nv, model.bodies[0].joint.kind) == (7, 6, "free")


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 0, -1), (0.6, 0, -0.8)])
def test_planar_joint_moves_normal_to_its_axis(tmp_path, axis):
    xyz = " ".join(map(str, axis))
    model = read(tmp_path, joint(f'<origin xyz="1 2 3"/><axis xyz="{xyz}"/>', "planar"))
    tree = model.tree
    x, _, turn = tree.bodies
    R = np.array(x.R, dtype=float)
    np.testing.assert_allclose(R[:, 2], axis, atol=1e-15)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(R) == pytest.approx(1)
    _, back, p = tree.frames["hand"]
    np.testing.assert_allclose(R @ np.array(back, dtype=float), np.eye(3), atol=1e-15)
    assert (model.nv, turn.parent, p) == (3, 1, (0.0, 0.0, 0.0))
    assert bool(said(model, "planar")) == (axis != (0, 0, 1))


def test_mimic_follows_or_not(tmp_path):
    finger = '<link name="finger"/>' + joint(
        '<axis xyz="0 0 1"/>', "continuous", ends='<parent link="base"/><child link="finger"/>'
    )
    follow = finger + joint(
        '<mimic joint="elbow" multiplier="-2" offset="0.5"/>', "continuous", "wrist"
    )
    assert read(tmp_path, follow).coordinates[1].ratio == -2.0
    assert read(tmp_path, follow).coordinates[1].offset == 0.5
    assert read(tmp_path, follow, mimic="free").nv == 2


def test_free_base(tmp_path):
    model = read(tmp_path, joint(kind="fixed"), base="free")
    assert (model.nq, model.joint_names, model.bodies[0].name) == (7, ("base",), "base")


def test_comments_namespaces_and_byte_order_mark(tmp_path):
    path = tmp_path / "arm.urdf"
    inside = '<link name="a"/><xacro:if value="1"/>'
    text = (
        f'<?xml version="1.0"?><!-- x --><robot name="arm" xmlns:xacro="http://x">{inside}</robot>'
    )
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    model = fb.load(path)
    assert (model.name, said(model, "ignored")) == (
        "arm",
        ["1: <xacro:if> in <robot> is ignored (once)."],
    )


def test_everything_else_is_counted(tmp_path):
    rest = """<gazebo/><gazebo/><transmission name="t"><actuator name="m">
      <mechanicalReduction>100</mechanicalReduction>
      </actuator></transmission><material name="red"/>"""
    limit = (
        '<limit lower="0" upper="1" velocity="1" effort="1" jerk="2"/>'
        '<safety_controller k_velocity="1"/>'
    )
    model = read(tmp_path, joint(limit) + rest, robot="<robot>")
    assert model.name == "arm"
    assert said(model, "name") == ["1: <robot> has no name; the file's is used, 'arm'."]
    assert said(model, "skipped") == [
        "shapes play no part in the dynamics: 1 <material> serve drawings, or nothing."
    ]
    assert said(model, "ignored") == [
        "5: <gazebo> in <robot> is ignored (2 times, first here).",
        "5: <safety_controller> in a revolute joint is ignored (once).",
        "5: attribute jerk of <limit> of a revolute joint is ignored (once).",
        "5: <transmission> in <robot> is ignored (once).",
    ]


def transmission(inside, joints='<joint name="{}"/>'):
    joints = joints.format("j")
    return f'<transmission name="t">{joints}<actuator name="m">{inside}</actuator></transmission>'


ROTOR = '<drake:rotor_inertia value="0.002"/><drake:gear_ratio value="-50"/>'


@pytest.mark.parametrize(
    ("inside", "rotor", "gear"),
    [
        ("<mechanicalReduction>100</mechanicalReduction>", 0.0, 100.0),
        (ROTOR, 0.002, -50.0),
        (f"<mechanicalReduction>7</mechanicalReduction>{ROTOR}", 0.002, -50.0),
        ('<drake:rotor_inertia value="0.002"/>', 0.002, 1.0),
    ],
)
def test_motors_of_transmissions(tmp_path, inside, rotor, gear):
    model = read(tmp_path, joint(name="j") + transmission(inside))
    drive = model.bodies[0].joint.drive
    assert (drive.rotor, drive.gear) == (rotor, gear)
    assert len(said(model, "drive")) == (rotor == 0.0)


@pytest.mark.parametrize(
    ("inside", "joints"),
    [
        ("<mechanicalReduction>fast</mechanicalReduction>", '<joint name="j"/>'),
        (ROTOR, '<joint name="j"/><joint name="k"/>'),
        (ROTOR, '<joint name="nobody"/>'),
    ],
)
def test_transmissions_that_are_not_understood_are_named(tmp_path, inside, joints):
    model = read(tmp_path, joint(name="j") + transmission(inside, joints))
    assert (model.bodies[0].joint.drive.rotor, model.bodies[0].joint.drive.gear) == (0.0, 1.0)
    assert any("<transmission> in <robot> is ignored (once)" in x for x in said(model, "ignored"))


def test_loops_of_urdf_plus(tmp_path):
    """Joints without a transmission are passive where others have one."""
    rest = (
        joint(name="j")
        + '<link name="wrist"/>'
        + joint(name="k", ends='<parent link="base"/><child link="wrist"/>')
        + transmission("")
        + '<loop name="l" type="revolute"><predecessor link="hand"><origin xyz="1 0 0"/>'
        '</predecessor><successor link="wrist"/><axis xyz="0 0 1"/></loop>'
    )
    model = read(tmp_path, rest)
    (loop,) = model.loops
    assert (loop.name, loop.kind, loop.frames, loop.axis) == (
        "l", "revolute", ("l_a", "wrist"), (0.0, 0.0, 1.0),
    )  # fmt: skip
    assert [body.joint.passive for body in model.bodies] == [False, True]


@pytest.mark.parametrize(
    ("loop", "said"),
    [
        ('<loop name="l" type="screw"/>', "no type 'screw' in loop 'l'"),
        ('<loop name="l" type="fixed"/>', "it has no <predecessor>"),
        ("<coupling/>", "<coupling> of URDF+ is not read; write <mimic>"),
        (
            '<loop name="l" type="revolute"><predecessor link="base"/><successor link="arm"/>'
            '<axis xyz="0 0 0"/></loop>',
            "the axis is zero",
        ),
    ],
)
def test_loops_that_are_refused(tmp_path, loop, said):
    assert said in message(tmp_path, joint(name="j") + loop)


BROKEN = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.5"/></inertial>'
)


def test_inertia_that_no_body_has(tmp_path):
    arm = (
        f'<link name="wrist">\n{BROKEN}</link>'
        + joint(kind="fixed")
        + joint(kind="floating", name="f", ends=WRIST)
    )
    fault = "principal moments 0.1, 0.2, 0.5 kg m² break the triangle inequality (0.1 + 0.2 < 0.5)."
    with pytest.warns(fb.PhysicalWarning) as warned:
        model = read(tmp_path, arm)
    assert [str(w.message).replace(f"{tmp_path}/", "") for w in warned] == [
        f"arm.urdf:5: warning: link 'wrist': {fault}"
    ]
    assert said(model, "physical") == [f"5: warning: link 'wrist': {fault}"]
    assert message(tmp_path, arm, physical="refuse") == (
        f"arm.urdf:5: link 'wrist': {fault[:-1]}. Correct it, or accept it with physical='warn'."
    )
    assert said(read(tmp_path, arm, physical="ignore"), "physical") == []


WRIST = '<parent link="base"/><child link="wrist"/>'
HAND = '<link name="tool"/>' + joint(kind="fixed")
MASSLESS = (
    '<link name="b"><inertial>{}</inertial></link>'
    + joint(kind="fixed")
    + joint(kind="fixed", name="j", ends='<parent link="base"/><child link="b"/>')
)


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("body", "text"),
    [
        ("", "arm.urdf:3: links 'base', 'hand' have no parent joint; only one link can be the "
        "base: connect the "
             "others to it by joints."),
        (joint(kind="revolut"),
         "arm.urdf:4: no type 'revolut' in joint 'elbow'. Did you mean 'revolute'? Types: "
         "revolute, "
             "continuous, prismatic, fixed, floating, spherical, planar."),
        (joint(kind=""), "arm.urdf:4: joint 'elbow': <joint> has no type; add type=\"...\"."),
        (joint(ends='<child link="hand"/>'),
         "arm.urdf:4: joint 'elbow': it has no <parent>; add <parent "
         "link=\"...\"/>."),
        (joint(ends='<parent/><child link="hand"/>'),
         "arm.urdf:4: joint 'elbow': <parent> has no link; add "
         "link=\"...\"."),
        (joint(ends='<parent link="base"/><child link="hnd"/>'),
         "arm.urdf:4: joint 'elbow': no child link 'hnd' in "
         "the "
             "file. Did you mean 'hand'? Child links: base, hand."),
        (joint() + joint(name="two"),
         "arm.urdf:5: link 'hand' hangs on two joints, 'elbow' and 'two'; a tree "
         "allows one: "
             "write the other as a loop between two frames, or remove it."),
        (joint() + joint(name="two", ends='<parent link="hand"/><child link="base"/>'),
         "arm.urdf:5: the links form a "
             "cycle, base -> hand -> base (child -> parent); a tree has none: "
             "write one joint as a loop between two frames, or remove it."),
        (joint(ends='<parent link="hand"/><child link="hand"/>'),
         "arm.urdf:4: joint 'elbow': link 'hand' cannot be "
         "its own "
             "parent; name another parent."),
        (joint() + joint(ends='<parent link="hand"/><child link="base"/>'),
         "arm.urdf:5: two joints are called "
         "'elbow'; "
             "rename one."),
        (joint() + '<link name="hand"/>', "arm.urdf:5: two links are called 'hand'; rename one."),
        (joint() + "<link/>", "arm.urdf:5: a link has no name; give it one."),
        (joint('<axis xyz="0 0 0"/>'),
         "arm.urdf:5: joint 'elbow': the axis is zero; give a direction such as "
         "xyz=\"0 0 1\"."),
        (joint('<axis xyz="0 1"/>'),
         "arm.urdf:5: joint 'elbow': xyz='0 1' has 2 entries, expected 3 numbers."),
        (joint('<axis xyz="0 nan 1"/>'),
         "arm.urdf:5: joint 'elbow': xyz of <axis> is 'nan', expected a finite "
         "number."),
        (joint('<origin xyz="0 0 inf"/>'),
         "arm.urdf:5: joint 'elbow': xyz of <origin> is 'inf', expected a finite "
         "number."),
        (joint('<origin rpy="0 0 1_0"/>'),
         "arm.urdf:5: joint 'elbow': rpy of <origin> is '1_0', expected a finite "
         "number."),
        (joint('<origin xyz="${a} 0 0"/>'),
         "arm.urdf:5: joint 'elbow': xyz of <origin> is '${a}', expected a "
         "finite number; "
         "it is a xacro expression, which this suffix does not say: call the file "
         ".urdf.xacro, and it is expanded."),
        (joint('<origin rpy="$(optenv RPY 0 -1.57 0)"/>'),
         "arm.urdf:5: joint 'elbow': rpy='$(optenv RPY 0 -1.57 0)' has 5 entries, expected 3 "
         "numbers; it is a xacro expression, which this suffix does not say: call the file "
         ".urdf.xacro, and it is expanded."),
        (joint('<limit lower="1" upper="-1"/>'),
         "arm.urdf:4: joint 'elbow': lower limit 1 is above upper -1; swap "
         "them, or leave both out where there are none."),
        (joint('<limit lower="nan"/>'),
         "arm.urdf:5: joint 'elbow': lower of <limit> is 'nan', expected a number."),
        (joint('<dynamics damping="much"/>'),
         "arm.urdf:5: joint 'elbow': damping of <dynamics> is 'much', expected "
         "a finite number."),
        (joint('<mimic joint="elbw"/>'),
         "arm.urdf:4: no joint 'elbw' in the mimic of 'elbow'. Did you mean 'elbow'? "
             "Joints: elbow. Correct it, or load with mimic='free'."),
        (joint('<mimic joint="elbow"/>'),
         "arm.urdf:4: joint 'elbow': its mimic relations form a cycle; remove one."),
        (joint("<mimic/>"), "arm.urdf:5: joint 'elbow': <mimic> has no joint; add joint=\"...\"."),
        (MASSLESS.format('<mass value="1"/>'),
         "arm.urdf:4: link 'b': <inertial> has no <inertia>; add it, or remove "
             "<inertial> from a link without mass."),
        (MASSLESS.format('<mass/><inertia ixx="1"/>'),
         "arm.urdf:4: link 'b': <inertia> has no ixy; add ixy=\"...\"."),
    ],
)  # fmt: skip
def test_refused(tmp_path, body: str, text: str):
    assert message(tmp_path, body) == text


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<robot name='a'>\n<link name='b'>\n",
         "arm.urdf:3: the file ends inside <link>, opened on line 2; it seems to be truncated."),
        ("<robot name='a'>\n<link name='b'\n",
         "arm.urdf:2: the file ends inside <robot>, opened on line 1; it seems to be truncated."),
        ("<robot>\n<link></robot>",
         "arm.urdf:2: this is not well-formed XML: mismatched tag at column 9."),
        ("hello", "arm.urdf:1: this is not well-formed XML: syntax error at column 1."),
        ("<robot>&lol;</robot>",
         "arm.urdf:1: this is not well-formed XML: undefined entity at column 8."),
        ("<?xml version='1.0' encoding='klingon'?><robot/>",
         "arm.urdf: the XML cannot be decoded: unknown "
         "encoding: klingon."),
        ("<sdf/>", "arm.urdf:1: the root element is <sdf>, expected <robot> (this is SDF)."),
        ("<robot name='a'/>", "arm.urdf:1: there are no links; a robot needs at least one."),
        ("<robot xmlns:xacro='x'><xacro:arm/></robot>",
         "arm.urdf:1: there are no links; a robot needs at least "
         "one; it is xacro, which this suffix does not say: call the file .urdf.xacro, and it is "
         "expanded."),
    ],
)  # fmt: skip
def test_not_a_robot(tmp_path, text: str, problem: str):
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.raises(fb.FreebodyError) as refusal:
        fb.load(path)
    assert str(refusal.value).replace(f"{tmp_path}/", "") == problem


def test_entities_are_refused(tmp_path):
    laughs = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "ha"}">' for i in range(30))
    path = tmp_path / "arm.urdf"
    path.write_text(f'<?xml version="1.0"?>\n<!DOCTYPE robot [{laughs}]>\n<robot name="&l29;"/>')
    with pytest.raises(
        fb.FreebodyError, match=r"arm.urdf:2: the file has a <!DOCTYPE>.* refused; remove it\."
    ):
        fb.load(path)
    path.write_text('<!DOCTYPE robot SYSTEM "file:///etc/passwd"><robot/>')
    with pytest.raises(fb.FreebodyError, match="DOCTYPE"):
        fb.load(path)


def test_faults_that_simulators_pass_over(tmp_path):
    """NUL bytes at the end, blank lines before the declaration, elements given twice: read, and
    told."""
    path = tmp_path / "arm.urdf"
    axes = joint('<axis xyz="1 0 0"/><axis xyz="0 1 0"/>')
    links = '<link name="base"/><link name="hand"/>'
    twice = f"<?xml version='1.0'?>\n<robot name='arm'>\n{links}\n{axes}</robot>"
    path.write_bytes(b"\n \n" + twice.encode() + b"\0\0")
    model = fb.load(path)
    told = [str(notice).replace(f"{tmp_path}/", "") for notice in model.notices]
    assert told[:2] == [
        "arm.urdf: 2 NUL bytes at the end of the file are passed over.",
        "arm.urdf: what is blank before the XML declaration is passed over.",
    ]
    (doubled,) = (text for text in told if "<axis>" in text)
    assert doubled.endswith(
        "joint 'elbow': there are 2 <axis>; warning: they differ, and the first is used."
    )
    lines = path.read_text().split("\n")
    assert "<axis" in lines[int(doubled.split(":")[1]) - 1]
    path.write_bytes(twice.replace("0 1 0", "1 0 0").encode())
    assert any("they are equal" in str(notice) for notice in fb.load(path).notices)
    path.write_bytes(twice.encode() + b"\0x")
    with pytest.raises(fb.FreebodyError, match="binary, not text"):
        fb.load(path)
