"""`fb.doctor`: faults planted in good files are found at their place, good files have no error,
what is mended passes, and all robots of a data wheel are looked at."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path

import pytest

import freebody as fb
from support.command import run
from support.extras import extra
from support.fuzz import cases
from support.real_files import FILES, ROBOTS

pytestmark = pytest.mark.skipif(not FILES, reason="example-robot-data is not installed")

GOOD = (
    "panda_description/urdf/panda.urdf",
    "kinova_description/robots/kinova.urdf",
    "z1_description/urdf/z1.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "ur_description/urdf/ur10_robot.urdf",
    "go2_description/urdf/go2.urdf",
    "laikago_description/urdf/laikago.urdf",
    "human_description/robots/human.urdf",
    "tiago_description/robots/tiago_no_hand.urdf",
    "anymal_b_simple_description/robots/anymal-kinova.urdf",
)


@dataclass(frozen=True)
class Fault:
    """A fault: the kind by which it is found, the part of the file that it is planted in, and how;
    mended: whether --fix removes it."""

    kind: str
    part: str
    plant: Callable[[str], str]
    mended: bool = False


def put(pattern: str, text: str) -> Callable[[str], str]:
    """A change of the first place of a pattern."""
    return lambda block: re.sub(pattern, text, block, count=1, flags=re.DOTALL)


def attribute(tag: str, name: str, value: str) -> Callable[[str], str]:
    """Another value for an attribute; the element and the attribute are put there if they lack."""

    def plant(block: str) -> str:
        found = re.search(rf"<{tag}\b[^>]*>", block)
        if found is None:
            return re.sub(r">", f'><{tag} {name}="{value}"/>', block, count=1)
        text, count = re.subn(rf'(\s{name}\s*=\s*)"[^"]*"', rf'\g<1>"{value}"', found[0], count=1)
        if not count:
            text = text.replace(f"<{tag}", f'<{tag} {name}="{value}"', 1)
        return block.replace(found[0], text, 1)

    return plant


def each(*plants: Callable[[str], str]) -> Callable[[str], str]:
    """Several changes."""

    def plant(block: str) -> str:
        for one in plants:
            block = one(block)
        return block

    return plant


def without(tag: str, name: str = "") -> Callable[[str], str]:
    """An attribute less, or a whole element."""
    if name:
        return put(rf'(<{tag}\b[^>]*?)\s{name}\s*=\s*"[^"]*"', r"\1")
    return put(rf"<{tag}\b[^>]*/>|<{tag}\b[^>]*>.*?</{tag}>", "")


LOWER, UPPER = (lambda x, end=end: attribute("limit", end, x) for end in ("lower", "upper"))
TENSOR = each(*(attribute("inertia", key, "0") for key in ("ixy", "ixz", "iyz")))


def moments(*three: float) -> Callable[[str], str]:
    """Principal moments in the place of a tensor."""
    keys = zip(("ixx", "iyy", "izz"), three, strict=True)
    return each(TENSOR, *(attribute("inertia", key, f"{x:g}") for key, x in keys))


FAULTS = (
    Fault("swapped limits", "joint", each(LOWER("1.5"), UPPER("-1.5")), True),
    Fault("negative limit", "joint", attribute("limit", "effort", "-50"), True),
    Fault("negative limit", "joint", attribute("limit", "velocity", "-2"), True),
    Fault("missing limits", "joint", without("limit")),
    Fault("missing limits", "joint", without("limit", "upper")),
    Fault("limits not given", "joint", without("limit", "effort")),
    Fault("zero limit", "joint", attribute("limit", "effort", "0")),
    Fault("zero limit", "joint", attribute("limit", "velocity", "0.0")),
    Fault("no range", "joint", each(LOWER("0"), UPPER("0"))),
    Fault("limits in degrees", "joint", each(LOWER("-170"), UPPER("170")), True),
    Fault("placeholder limits", "joint", attribute("limit", "effort", "123456")),
    Fault("placeholder limits", "joint", attribute("limit", "velocity", "54321")),
    Fault("zero axis", "joint", attribute("axis", "xyz", "0 0 0")),
    Fault("axis not unit", "joint", attribute("axis", "xyz", "0 0 2"), True),
    Fault("axis not unit", "joint", attribute("axis", "xyz", "0 1 1"), True),
    Fault("slightly turned axis", "joint", attribute("axis", "xyz", "0 0.001 0.9999995")),
    Fault("no axis", "joint", without("axis")),
    Fault("rounded right angle", "joint", attribute("origin", "rpy", "0 1.57 0"), True),
    Fault("rounded right angle", "joint", attribute("origin", "rpy", "-3.142 0 0"), True),
    Fault("right angle in few digits", "joint", attribute("origin", "rpy", "0 0 1.570796"), True),
    Fault("angles in degrees", "joint", attribute("origin", "rpy", "0 90 0"), True),
    Fault("negative friction", "joint", attribute("dynamics", "damping", "-0.5")),
    Fault("negative friction", "joint", attribute("dynamics", "friction", "-0.1")),
    Fault("friction holds", "joint", attribute("dynamics", "friction", "98765")),
    Fault("unknown type", "joint", put(r'type\s*=\s*"\w+"', 'type="revolut"'), True),
    Fault("unknown name", "joint", attribute("parent", "link", "no_such_link")),
    Fault("unknown name", "joint", attribute("mimic", "joint", "no_such_joint")),
    Fault("no number", "joint", LOWER("-1,5"), True),
    Fault("no number", "joint", UPPER("nan")),
    Fault("no number", "joint", attribute("origin", "xyz", "0 1")),
    Fault("no number", "joint", attribute("axis", "xyz", "z")),
    Fault("misspelt", "joint", put(r"<limit\b", "<limits")),
    Fault("misspelt", "joint", put(r"\supper\s*=", " uper=")),
    Fault("odd name", "joint", put(r'name\s*=\s*"', 'name="joint no. '), True),
    Fault("no name", "joint", put(r'name\s*=\s*"[^"]*"', 'name=""')),
    Fault("impossible inertia", "link", attribute("mass", "value", "-1.5")),
    Fault("impossible inertia", "link", moments(0.001, 0.001, 0.05), True),
    Fault("impossible inertia", "link", attribute("inertia", "ixx", "-0.01"), True),
    Fault("mass of 0", "link", attribute("mass", "value", "0")),
    Fault("point mass", "link", moments(0, 0, 0)),
    Fault("placeholder inertia", "link", each(attribute("mass", "value", "1"), moments(1, 1, 1))),
    Fault("absent number", "link", without("mass")),
    Fault("absent number", "link", without("inertia", "ixy")),
    Fault("no number", "link", attribute("inertia", "izz", "0.01 kg")),
    Fault("misspelt", "link", put(r"<inertial\b(.*?)</inertial>", r"<intertial\1</intertial>")),
)
TIMES = 2
"""Files that each fault is planted in."""


def blocks(text: str, part: str) -> list[re.Match[str]]:
    """The joints that turn and have limits of all kinds, or the links with an inertia."""
    found = re.finditer(
        rf'<{part}\s+[^>]*?name="(?P<name>[^"]*)"[^>]*?>.*?</{part}>', text, re.DOTALL
    )
    needed = (
        ('"revolute"', "<limit", "lower=", "upper=", "effort=", "velocity=", "<axis", "<origin")
        if part == "joint"
        else ("<inertial", "<mass", "ixx", "izz")
    )
    blank = re.compile(r'<mimic|<mass value="0"/>|ixx="0(\.0)?"')
    return [x for x in found if all(word in x[0] for word in needed) and not blank.search(x[0])]


def planted(text: str, fault: Fault, which: int) -> tuple[str, range]:
    """The text with a fault, and the lines of the part that it is in: of a middle one."""
    every = blocks(text, fault.part)
    block = every[(len(every) // 2 + which) % len(every)]
    wrong = fault.plant(block[0])
    assert wrong != block[0], fault
    first = text.count("\n", 0, block.start()) + 1
    return (
        text[: block.start()] + wrong + text[block.end() :],
        range(first, first + wrong.count("\n") + 1),
    )


@cache
def texts() -> list[str]:
    """The good files."""
    return [(ROBOTS / name).read_text(encoding="utf-8") for name in GOOD]


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", GOOD)
def test_good_files_have_no_error(name):
    assert [x for x in fb.doctor(ROBOTS / name).findings if x.severity == "error"] == []


@pytest.mark.sample(1)
@pytest.mark.parametrize("number", range(len(FAULTS)), ids=lambda k: f"{k} {FAULTS[k].kind}")
def test_planted_faults_are_found_where_they_are_and_mended(number, tmp_path):
    fault, good, path = FAULTS[number], texts(), tmp_path / "arm.urdf"
    for which in range(TIMES):
        text, lines = planted(good[(number + 3 * which) % len(good)], fault, which)
        path.write_text(text, encoding="utf-8")
        found = fb.doctor(path)
        here = [x for x in found.findings if x.kind == fault.kind and x.line in lines]
        assert here, (GOOD[(number + 3 * which) % len(good)], str(found))
        assert bool(here[0].fix) == fault.mended
        if fault.mended:
            assert found.mended is not None
            path.write_bytes(found.mended)
            left = [x for x in fb.doctor(path).findings if x.line in lines]
            assert fault.kind not in [x.kind for x in left]
            assert not [x for x in left if x.severity == "error"]


# ------------------------------------------------------------ faults of whole robots
def link(name: str, mass: float, moments: str, shape: str = "", com: str = "0 0 0.15") -> str:
    """A link with principal moments and a shape."""
    x, y, z = moments.split()
    return f"""<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>
<inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial>{shape}</link>
"""


def joint(name: str, parent: str, child: str, z: float = 0.3, upper: float = 2.0) -> str:
    """A joint that turns about y, at a height."""
    return f"""<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0 0 {z}"/><axis xyz="0 1 0"/>
<limit lower="-2.1" upper="{upper}" effort="43" velocity="3.1"/></joint>
"""


def box(size: str, xyz: str = "0 0 0.15") -> str:
    """A box as what collides."""
    return f"""<collision><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry></collision>
"""


ROD = box("0.06 0.08 0.3")
MOMENTS = ("0.0321 0.0312 0.0033", "0.0225 0.0219 0.0023", "0.0112 0.0109 0.0011")
MASSES = (4.2, 2.9, 1.4)


def arm(*links: str, more: str = "") -> str:
    """An arm of three links on a base, some of them others than its own."""
    own = [
        link(f"link{k}", mass, moments, ROD)
        for k, (mass, moments) in enumerate(zip(MASSES, MOMENTS, strict=True), 1)
    ]
    own[: len(links)] = [new or was for new, was in zip(links, own, strict=False)]
    joints = [joint(f"joint{k}", f"link{k - 1}", f"link{k}") for k in (1, 2, 3)]
    return f'<robot name="arm"><link name="link0"/>{"".join((*own, *joints))}{more}</robot>'


def scaled(moments: str, factor: float) -> str:
    return " ".join(f"{factor * float(x):g}" for x in moments.split())


ABOUT_ORIGIN = [
    link(f"link{k}", m, f"{0.0975 * m / 3.25:g} {0.0975 * m / 3.25:g} {0.0008 * m:g}", ROD)
    for k, m in enumerate(MASSES, 1)
]
SKEW = [
    f"""<link name="link{k}"><inertial><origin xyz="0.05 0 0.1"/><mass value="{m}"/>
<inertia ixx="{0.008 * m}" iyy="{0.0099 * m}" izz="{0.0025 * m}"
ixy="0" ixz="{sign * 0.0035 * m}" iyz="0"/>
</inertial><collision><origin xyz="0.05 0 0.1" rpy="0 0.4636 0"/><geometry>
<box size="0.06 0.08 0.32"/></geometry></collision></link>"""
    for sign in (1, -1)
    for k, m in enumerate(MASSES, 1)
]
SIDES = "".join(
    link(f"{side}_paw", mass, moments) + joint(f"{side}_wrist", "link3", f"{side}_paw", upper=up)
    for side, mass, moments, up in (
        ("left", 0.4, "0.001 0.0011 0.0006", 2.0),
        ("right", 0.5, "0.001 0.0011 0.0006", 1.2),
    )
)
WHOLE = {
    "wrong units": arm(*(link(f"link{k}", m, scaled(I, 1e6), ROD) for k, (m, I) in
                         enumerate(zip(MASSES, MOMENTS, strict=True), 1))),
    "inertia about the origin": arm(*ABOUT_ORIGIN),
    "inertia in wrong axes": arm("", link("link2", 2.9, "0.0023 0.0225 0.0219", ROD)),
    "left and right differ": arm(more=SIDES),
    "left and right limits differ": arm(more=SIDES),
    "implausible inertias": arm(*(link(f"link{k}", 1.1, "0.012 0.012 0.012", ROD)
                                  for k in (1, 2, 3))),
    "no masses": '<robot name="x"><link name="link0"/><link name="link1"/>'
    + joint("joint1", "link0", "link1") + "</robot>",
    "density": arm(link("link1", 4.2, MOMENTS[0], box("0.008 0.009 0.3"))),
    "centre outside": arm(link("link1", 4.2, MOMENTS[0], ROD, com="0.3 0 0.15")),
    "inertia unlike shape": arm(link("link1", 4.2, scaled(MOMENTS[0], 1e-3), ROD)),
    "signs of products": arm(*SKEW[:3]),
    "missing mesh": arm(more='<link name="tool"><visual><geometry><mesh filename="no.stl"/>'
                        '</geometry></visual></link><joint name="weld" type="fixed">'
                        '<parent link="link3"/><child link="tool"/></joint>'),
    "unknown package": arm(more='<link name="tool"><visual><geometry><mesh filename='
                           '"package://none/no.stl"/></geometry></visual></link><joint name="weld" '
                           'type="fixed"><parent link="link3"/><child link="tool"/></joint>'),
    "duplicate name": arm(more=link("link2", 1.0, "0.01 0.01 0.01")),
    "two joints": arm(more=joint("joint4", "link1", "link3")),
    "not connected": arm(more='<link name="loose"/>'),
    "no tip": arm(more=SIDES),
    "given twice": arm().replace('<axis xyz="0 1 0"/>', 2 * '<axis xyz="0 1 0"/>', 1),
}  # fmt: skip


@pytest.mark.sample(11)
@pytest.mark.parametrize("kind", WHOLE)
def test_faults_of_whole_robots(kind, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(arm(), encoding="utf-8")
    assert fb.doctor(path).findings == ()
    path.write_text(WHOLE[kind], encoding="utf-8")
    found = fb.doctor(path)
    assert kind in [x.kind for x in found.findings], str(found)


def test_right_signs_of_products_are_no_finding(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(arm(*SKEW[3:]), encoding="utf-8")
    assert "signs of products" not in [x.kind for x in fb.doctor(path).findings]


# ------------------------------------------------------------ the command
def test_the_command_tells_mends_and_ends_with_a_status(tmp_path, capsys):
    path, mended = tmp_path / "arm.urdf", tmp_path / "arm.mended.urdf"
    text = arm().replace('lower="-2.1" upper="2.0"', 'lower="2.0" upper="-2.1"', 1)
    path.write_text(text, encoding="utf-8")
    assert run(["doctor", str(path)]) == 1
    assert not mended.exists()
    out = capsys.readouterr().out
    reason = "error: joint 'joint1': its lower limit 2 is above its upper one, -2.1; swap them."
    assert f"{path}:{text.count(chr(10), 0, text.index('lower=')) + 1}: {reason}" in out
    assert run(["doctor", "--fix", str(path)]) == 0
    assert '<limit> lower="2.0" becomes "-2.1"' in capsys.readouterr().out
    assert mended.read_text(encoding="utf-8") == arm()  # not a byte besides
    assert run(["doctor", "--fix", "ur5e"]) == 0
    assert "nothing is changed" in capsys.readouterr().out
    assert run(["doctor", "--json", str(path), "ur5e"]) == 1
    first, second = json.loads(capsys.readouterr().out)
    assert (first["sound"], second["sound"]) == (False, True)
    assert first["findings"][0]["kind"] == "swapped limits"
    assert run(["doctor", str(tmp_path / "none.urdf"), "ur5e"]) == 2
    said = capsys.readouterr()
    assert "there is no such file" in said.err
    assert "ur5e: no findings" in said.out


def test_other_formats_are_looked_at(tmp_path):
    assert fb.doctor("panda").sound
    sdf = tmp_path / "arm.sdf"
    sdf.write_text(
        """<sdf version="1.7"><model name="arm"><link name="a"/><link name="b"><inertial>
<mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.9</izz></inertia></inertial></link>
<joint name="weld" type="fixed"><parent>world</parent><child>a</child></joint>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz>
<limit><effort>0</effort></limit></axis></joint></model></sdf>""",
        encoding="utf-8",
    )
    found = fb.doctor(sdf)
    assert {x.kind for x in found.findings} >= {"impossible inertia", "zero limit"}
    (assumed,) = (x for x in found.findings if x.kind == "read otherwise")
    assert assumed.severity == "warning"
    assert assumed.reason == "link 'a': no mass or inertia, for which SDF assumes 1 kg and 1 kg m²"


def test_what_mujoco_refuses_or_passes_over_is_found(tmp_path):
    extra("mujoco", name="mjcf")
    path = tmp_path / "arm.xml"

    def found(joint: str, mass: object) -> list[tuple[str, int | None, str]]:
        path.write_text(
            f'<mujoco><worldbody><body name="a">\n<joint name="j" {joint}/>\n<inertial pos="0 0 1" '
            f'mass="{mass}" diaginertia="0.2 0.3 0.4"/></body></worldbody></mujoco>',
            encoding="utf-8",
        )
        return [(x.kind, x.line, x.reason) for x in fb.doctor(path).findings]

    for mass in (-1, "nan"):
        ((kind, line, reason),) = found("", mass)
        assert (kind, line) == ("refused", 1)
        assert "mass and inertia of moving bodies must be larger" in reason
    ((kind, _, reason),) = found("", "inf")
    assert (kind, reason) == ("refused", "body 'a': its mass is inf, not a finite number")
    ((kind, _, reason),) = found('range="6.28 -6.28"', 2)
    assert kind == "read otherwise"
    assert reason.startswith("joint 'j': the lower end of its range, 6.28, is above the upper one")


def test_point_masses_are_told_where_they_turn():
    """The delta's platform only slides, and its elbows are lumped onto cranks."""
    assert not fb.doctor("template:delta").findings


def test_points_that_a_person_wrote_are_meant(tmp_path):
    """Zeros in freebody's own form say that the mass is a point; moments left out, or zeros that a
    tool has exported, may have been forgotten."""
    for name in ("template:palletiser", "cylindrical_arm", "gantry_crane"):
        assert not fb.doctor(name).findings, name
    head = "[[link]]\nname = 'base'\n"
    tail = "[[joint]]\nname='j'\nkind='revolute'\nparent='base'\nchild='bob'\naxis='x'\n"
    own, urdf = tmp_path / "bob.toml", tmp_path / "bob.urdf"
    said = ("", "inertia = [0, 0, 0, 0, 0, 0]\n", "shape = { point = {} }\n")
    for text, kinds in zip(said, (["point mass"], [], []), strict=True):
        own.write_text(f"{head}[[link]]\nname = 'bob'\nmass = 2\n{text}{tail}", encoding="utf-8")
        assert [x.kind for x in fb.doctor(own).findings] == kinds
    fb.save(fb.load(own), urdf, lossy=True)
    assert "point mass" in [x.kind for x in fb.doctor(urdf).findings]
    row = "[dh]\nconvention = 'standard'\nrows = [{ a = 1, m = 2 ITS }]\n"
    for text, kinds in ((", I = [0, 0, 0, 0, 0, 0]", []), ("", ["point mass"])):
        own.write_text(row.replace("ITS", text), encoding="utf-8")
        assert [x.kind for x in fb.doctor(own).findings] == kinds


def test_numbers_of_slides_are_no_degrees(tmp_path):
    """A hand that floats on three slides and three hinges has ±20 for all of them: no limits."""
    path = tmp_path / "hand.urdf"
    slide, hinge = (
        f'<joint name="{kind}" type="{kind}"><parent link="{a}"/><child link="{b}"/>'
        '<axis xyz="0 0 1"/><limit lower="-20" upper="20" effort="100" velocity="0.5"/></joint>'
        for kind, a, b in (("prismatic", "base", "a"), ("revolute", "a", "b"))
    )
    bodies = '<link name="base"/>' + link("a", 1.0, "1 1 1") + link("b", 1.0, "1 1 1")
    path.write_text(f'<robot name="hand">{bodies}{slide}{hinge}</robot>', encoding="utf-8")
    assert "limits in degrees" not in [x.kind for x in fb.doctor(path).findings]
    text = path.read_text(encoding="utf-8").replace(
        'lower="-20" upper="20"', "lower='0' upper='1'", 1
    )
    path.write_text(text, encoding="utf-8")
    assert "limits in degrees" in [x.kind for x in fb.doctor(path).findings]


def test_inertias_of_the_reader_have_the_axes_of_its_shapes(tmp_path):
    """MuJoCo fills the shapes of a file that gives no inertia; one that is given is looked at."""
    extra("mujoco")
    path = tmp_path / "across.xml"
    shape = '<geom type="box" size="0.01 0.3 0.01"/>'
    text = (
        '<mujoco><worldbody><body name="arm"><joint name="j" axis="0 1 0"/>OWN'
        f'{shape}<body name="hand" pos="0.5 0 0"><joint name="k" axis="0 1 0"/>'
        '<geom type="sphere" size="0.05"/></body></body></worldbody></mujoco>'
    )
    own = '<inertial pos="0 0 0" mass="0.24" diaginertia="0.0072 0.000016 0.0072"/>'
    for given, found in (("", False), (own, True)):
        path.write_text(text.replace("OWN", given), encoding="utf-8")
        kinds = [x.kind for x in fb.doctor(path).findings]
        assert ("inertia in wrong axes" in kinds) is found, kinds


def test_faults_of_a_macro_are_told_where_it_is_written(tmp_path):
    head = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    part, path = tmp_path / "part.xacro", tmp_path / "arm.xacro"
    swapped = joint("${b}_joint", "${a}", "${b}").replace("-2.1", "2.5")
    part.write_text(
        f'{head}\n<xacro:macro name="segment" params="a b">\n{link("${b}", -1.0, "1 1 1")}{swapped}'
        "</xacro:macro></robot>",
        encoding="utf-8",
    )
    path.write_text(
        f'{head}<xacro:include filename="part.xacro"/><link name="base"/>'
        '<xacro:segment a="base" b="one"/></robot>',
        encoding="utf-8",
    )
    found = [(x.kind, Path(x.file).name, x.line) for x in fb.doctor(path).of("error")]
    assert found == [
        ("impossible inertia", "part.xacro", 3),
        ("swapped limits", "part.xacro", 7),
    ]


def test_a_xacro_that_cannot_be_expanded_is_a_finding(tmp_path):
    path = tmp_path / "arm.xacro"
    path.write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">\n<xacro:segment/></robot>',
        encoding="utf-8",
    )
    (only,) = fb.doctor(path).findings
    assert (only.kind, only.line) == ("refused", 2)
    assert "no macro 'segment'" in only.reason


def test_what_only_xacro_reads_is_told_so(tmp_path):
    path = tmp_path / "arm.urdf"
    half = arm().replace('xyz="0 0 0.15"', 'xyz="$(optenv ARM_XYZ 0 0 0.15)"', 1)
    path.write_text(half, encoding="utf-8")
    (found,) = fb.doctor(path).of("error")
    assert found.reason == (
        "xyz of <origin> is '$(optenv ARM_XYZ 0 0 0.15)', which only xacro reads"
    )
    assert found.remedy == "call the file .urdf.xacro, and it is expanded"


def test_mirror_images_change_all_words_for_sides(tmp_path):
    """Legs of two motors each: the outer ones are alike, and so are the inner ones."""
    legs = {f"{side}{x}": 0.4 + 0.1 * (side[0].upper() == x) for side in ("left", "right")
            for x in "LR"}  # fmt: skip
    parts = "".join(
        link(name, mass, "0.001 0.0011 0.0006") + joint(f"{name}_hip", "link3", name)
        for name, mass in legs.items()
    )
    path = tmp_path / "arm.urdf"
    path.write_text(arm(more=parts), encoding="utf-8")
    assert "left and right differ" not in {x.kind for x in fb.doctor(path).findings}
    path.write_text(arm(more=parts.replace("0.5", "0.6", 1)), encoding="utf-8")
    (found,) = (x for x in fb.doctor(path).findings if x.kind == "left and right differ")
    assert found.reason.startswith("links 'leftL' and 'rightR' are left and right")


def test_a_file_that_is_only_refused_says_why(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text('<robot name="arm"/>', encoding="utf-8")
    (only,) = fb.doctor(path).findings
    assert (only.kind, only.severity) == ("refused", "error")
    assert "there are no links" in str(only)
    path.write_text("<robot>", encoding="utf-8")
    with pytest.raises(fb.FileError, match="truncated"):
        fb.doctor(path)


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("kind", "suffix"),
    [("urdf", ".urdf"), ("xacro", ".xacro"), ("sdf", ".sdf"), ("toml", ".toml"), ("dh", ".csv")],
)
def test_broken_files_are_looked_at_or_refused(kind, suffix, tmp_path):
    path, looked_at = tmp_path / f"arm{suffix}", 0
    for data in islice(cases(kind, 31), 60):
        path.write_bytes(data)
        try:
            looked_at += bool(fb.doctor(path).title)
        except fb.FreebodyError:
            continue
    assert looked_at


@pytest.mark.long
@pytest.mark.parametrize("name", FILES)
def test_robots_of_a_data_wheel_are_looked_at(name):
    found = fb.doctor(ROBOTS / name)
    kinds = {x.kind for x in found.findings if x.severity == "error"}
    assert kinds <= {"impossible inertia", "refused", "unknown name"}
