"""Xacro files: expanded as ROS's own tool does, told with their own lines, and never run."""

import os
import time
from contextlib import suppress

import numpy as np
import pytest

import freebody as fb
from support.xacro_package import HEAD, package, written

LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
    'iyz="0"/></inertial></link>'
)


@pytest.fixture
def folder(tmp_path):
    return package(tmp_path)


def test_a_robot_of_macros(folder):
    """The main job: an arm of two equal links, with lengths as arguments."""
    arm = (
        '<xacro:arg name="length" default="0.5"/><xacro:property name="l" value="$(arg length)"/>'
        + LINK.format("base")
        + '<xacro:macro name="segment" params="name parent at"><link name="${name}"><inertial>'
        '<origin xyz="${l/2} 0 0"/><mass value="${3*l}"/><inertia ixx="0" iyy="${l**3/4}" '
        'izz="${l**3/4}" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="${name}_joint" '
        'type="continuous"><parent link="${parent}"/><child link="${name}"/><origin xyz="${at} 0 '
        '0"/><axis xyz="0 0 1"/></joint></xacro:macro><xacro:segment name="upper" parent="base" '
        'at="0"/><xacro:segment name="lower" parent="upper" at="${l}"/>'
    )
    path = written(folder, arm)
    for length in (0.5, 0.8):
        model = fb.load(path, xacro={"length": length})
        mass, l = 3 * length, length
        # the closed form of two equal rods, lc = l/2, I = m l²/12, at q = 0
        inertia = mass * l * l / 12
        outer = inertia + mass * (l / 2) ** 2
        coupled = outer + mass * l * l / 2
        whole = outer + inertia + mass * (l / 2) ** 2 + mass * l * l + mass * l * l
        assert fb.mass_matrix(model, [0.0, 0.0]) == pytest.approx(
            np.array([[whole, coupled], [coupled, outer]]), rel=1e-12
        )
    assert fb.load(path).name == "arm"
    text = path.read_text()
    assert fb.load(text=text, format="xacro", xacro={"length": 0.8}).nv == 2


def refusal(source, **how):
    with pytest.raises(fb.FreebodyError) as caught:
        fb.load(source, **how)
    return str(caught.value)


@pytest.mark.parametrize(
    ("inside", "told"),
    [
        ("<link/>\n<xacro:m/>", ":3: no macro 'm' in the file. It has no macros."),
        ('<xacro:macro name="m" params="a"/>\n<xacro:m/>', ":3: macro 'm' needs parameter 'a'."),
        (
            '<xacro:macro name="m" params="a"/>\n<xacro:m b="1"/>',
            ":3: no parameter 'b' in macro 'm'. Parameters: a.",
        ),
        (
            '\n<link name="${lenght}"/><xacro:property name="length" value="1"/>',
            ":3: 'lenght' is not",
        ),
        (
            '<xacro:property name="a" value="${a}"/><link name="${a}"/>',
            ":2: property 'a' is defined by",
        ),
        (
            '<xacro:if value="perhaps"/>',
            ":2: value of <xacro:if> is 'perhaps', expected true or false.",
        ),
        ('<xacro:arg name="n"/>', ":2: argument 'n' has no default; give it with xacro={'n': …}"),
        ('<xacro:include filename="none.xacro"/>', ":2: <xacro:include> of "),
        (
            '<xacro:include filename="$(find gripper)/g.xacro"/>',
            ":2: package 'gripper' was not found",
        ),
        (
            '<xacro:macro name="a" params="x"/>',
            ": the file has no links of its own, it defines macros: a(x).",
        ),
        (
            '<property name="d" value="1"/><link name="${d}"/>',
            "<property> on line 2 lacks its prefix",
        ),
        ('<link name="$(env HOME)"/>', ":2: the environment variable 'HOME' is not read; allow it"),
        ('<link name="$(arg n)"/>', ":2: no argument 'n' in the file."),
        ('<link name="$(arg n 3)"/>', ":2: $(arg) takes other words than 'n 3'."),
        ('<link name="$(find)"/>', ":2: $(find) takes other words than ''."),
        ('<link name="${1/0}"/>', ":2: '1/0': division by zero."),
        ('<link name="${1"/>', ":2: '${1' has no end."),
        ("<xacro:insert_block name='b'/>", ":2: there is no block 'b'."),
    ],
)
def test_faults_are_told_with_their_line(inside, told, folder):
    assert told in refusal(written(folder, inside))


def test_faults_in_an_included_file_are_told_with_its_name(folder):
    bad = folder / "parts" / "bad.xacro"
    bad.write_text(f'{HEAD}\n<link name="a"><inertial/></link></robot>')
    path = written(folder, '<xacro:include filename="parts/bad.xacro"/>')
    assert "parts/bad.xacro:2: link 'a': <inertial> has no <mass>" in refusal(path)
    bad.write_text(f'{HEAD}\n<link name="${{x}}"/></robot>')
    assert "parts/bad.xacro:2: 'x' is not defined" in refusal(path)
    # what is found only when the parts are put together, and notices
    twice = LINK.format("a").replace('value="1"', 'value="1" unit="kg"')
    bad.write_text(f"{HEAD}\n{twice}\n{twice}</robot>")
    assert "parts/bad.xacro:3: two links are called 'a'" in refusal(path)
    bad.write_text(f"{HEAD}\n{twice}\n</robot>")
    told = [str(notice) for notice in fb.load(path).notices]
    assert any("parts/bad.xacro:2: attribute unit of <mass> is ignored" in text for text in told)


def test_calls_in_eval(folder):
    """Brackets in $(eval …), which ROS's tool ends at the first ), are read to their own end."""
    path = written(
        folder, '<xacro:arg name="n" default="3"/><link name="l$(eval max(arg(\'n\'), 2))"/>'
    )
    assert fb.load(path, tip="l3").nv == 0


def test_arguments_are_used_or_refused(folder):
    path = written(folder, '<xacro:arg name="n" default="1"/><link name="l$(arg n)"/>')
    assert fb.load(path, xacro={"n": "7"}, tip="l7").nv == 0
    assert refusal(path, xacro={"m": 1}).endswith(
        "no argument 'm' in its <xacro:arg>. Arguments: n."
    )
    assert "xacro= is for xacro files" in refusal("2R", xacro={"n": 1})
    assert "package_path= is for URDF, xacro and SDF files" in refusal("2R", package_path="x")


def test_packages_are_found_where_the_user_says(folder, tmp_path, monkeypatch):
    other = tmp_path / "elsewhere" / "gripper_description"
    (other / "urdf").mkdir(parents=True)
    (other / "urdf" / "g.xacro").write_text(f"{HEAD}{LINK.format('finger')}</robot>")
    inside = '<xacro:include filename="$(find gripper_description)/urdf/g.xacro"/>'
    path = written(folder, inside)
    assert "package 'gripper_description' was not found" in refusal(path)
    for where in (other, other.parent, [other.parent]):
        assert fb.load(path, package_path=where).bodies is not None
    monkeypatch.setenv("FREEBODY_PACKAGE_PATH", str(other.parent))
    assert fb.load(path).name == "arm"
    # a copy's folder is often called otherwise: package.xml has the name
    monkeypatch.delenv("FREEBODY_PACKAGE_PATH")
    other.rename(folder.parent.parent / "copy")
    assert "was not found" in refusal(path)
    (folder.parent.parent / "copy" / "package.xml").write_text(
        "<package><name>gripper_description</name></package>"
    )
    assert fb.load(path).name == "arm"


def test_only_files_of_packages_are_read(folder, tmp_path):
    outside = tmp_path / "secret.xacro"
    outside.write_text(f'{HEAD}<link name="a"/></robot>')
    (tmp_path / "secret.yaml").write_text("a: 1")
    for name in (outside, "../../../secret.xacro", "parts/../../../../secret.xacro"):
        path = written(folder, f'<xacro:include filename="{name}"/>')
        assert "lies outside the file's package" in refusal(path)
    os.symlink(outside, folder / "parts" / "link.xacro")
    path = written(folder, '<xacro:include filename="parts/link.xacro"/>')
    assert "lies outside the file's package" in refusal(path)
    path = written(folder, f"<link name=\"${{xacro.load_yaml('{tmp_path}/secret.yaml')}}\"/>")
    assert "lies outside the file's package" in refusal(path)
    assert "lies outside" in refusal(written(folder, '<xacro:include filename="/etc/*"/>'))


def test_variables_are_read_where_allowed(folder, monkeypatch):
    monkeypatch.setenv("ARM", "left")
    path = written(folder, '<link name="$(env ARM)"/>')
    assert "is not read" in refusal(path)
    for names in ("ARM", ["ARM"]):
        assert fb.load(path, xacro_environment=names, tip="left").nv == 0
    assert "xacro= takes values by their names" in refusal(path, xacro="n:=1")
    assert "xacro_environment= takes one text" in refusal(path, xacro_environment=[1])
    path = written(folder, '<link name="$(optenv ARM right)"/>')
    assert fb.load(path, tip="right").nv == 0


# ways out of a restricted eval that were published, and expressions that only fill the memory
HOSTILE = [
    "().__class__.__base__.__subclasses__()",
    "(lambda: __import__('os').system('id'))()",
    "[c for c in ().__class__.__mro__[1].__subclasses__() if c.__name__ == 'catch_warnings']",
    "'{0.__class__.__init__.__globals__}'.format(1)",
    "(x for x in [1]).gi_frame.f_back.f_builtins",
    "math.__loader__.load_module('os')",
    "python.type(1)",
    "xacro.load_yaml.__globals__",
    "getattr(1, 'real')",
    "str.mro()",
    "dict.fromkeys('a')",
    "(yield 1)",
    "(x := 1)",
    "f'{1}'",
    "9**9**9**9",
    "'a' * 10**10",
    "[0] * 10**10",
    "[[0] * 1000] * 10**6",
    "range(10**12)",
    "[a for a in range(10**4) for b in range(10**4)]",
    "sum([[x] * 1000 for x in range(10**4)], [])",
    "'x' * 9999 + '%9999999999d' % 1",
    "round(1, -10**10)",
    "('a' * 9999).replace('a', 'b' * 9999)",
    "('b' * 9999).join(['a'] * 9999)",
    "(" * 300 + "1" + ")" * 300,
    "-" * 3000 + "1",
    "1" + "+1" * 1900,
    "int('9' * 90000)",
]


@pytest.mark.sample(1)
@pytest.mark.parametrize("expression", HOSTILE, ids=range(len(HOSTILE)))
def test_expressions_are_walked_not_run(expression, folder):
    text = expression.replace("<", "&lt;").replace('"', "&quot;")
    began = time.process_time()
    for wrapped in ("${%s}", "$(eval %s)"):
        if (wrapped[1] == "{" and "}" in text) or (wrapped[1] == "(" and text.count("(") > 6):
            continue
        told = refusal(written(folder, f'<link name="{wrapped % text}"/>'))
        assert ":2:" in told
        assert len(told) < 2000
    assert time.process_time() - began < 20


def test_growth_has_bounds(folder):
    doubling = "".join(
        f'<xacro:macro name="m{k}" params=""><xacro:m{k + 1}/><xacro:m{k + 1}/></xacro:macro>'
        for k in range(40)
    )
    bombs = {
        "macros": doubling + '<xacro:macro name="m40" params=""><a/></xacro:macro><xacro:m0/>',
        "itself": '<xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/>',
        "includes": '<xacro:include filename="arm.urdf.xacro"/>',
        "text": '<xacro:property name="p0" value="aaaaaaaaaa"/>'
        + "".join(
            f'<xacro:property name="p{k + 1}" value="${{p{k}}}${{p{k}}}"/>' for k in range(60)
        )
        + '<link name="${p60}"/>',
        "lists": '<xacro:property name="p0" value="${[1]}"/>'
        + "".join(f'<xacro:property name="p{k + 1}" value="${{[p{k}, p{k}]}}"/>' for k in range(60))
        + '<link name="${p60}"/>',
    }
    for name, inside in bombs.items():
        began = time.process_time()
        told = refusal(written(folder, inside))
        assert any(word in told for word in ("nested", "more than", "too")), (name, told)
        assert time.process_time() - began < 20, name
    (folder / "b.yaml").write_text(
        "a0: &a0 {k: 1}\n"
        + "".join(f"a{k + 1}: &a{k + 1} {{<<: [*a{k}, *a{k}, *a{k}, *a{k}]}}\n" for k in range(20))
    )
    path = written(folder, "<link name=\"${xacro.load_yaml('b.yaml').a20.k}\"/>")
    began = time.process_time()
    # newer versions of PyYAML merge each key once, older ones would four to the twentieth times
    with suppress(fb.FreebodyError):
        fb.load(path, tip="1")
    assert time.process_time() - began < 20


def test_files_that_only_look_like_urdf_are_told(folder):
    path = written(folder, '<xacro:macro name="a"/>', "arm.urdf")
    assert "call the file .urdf.xacro" in refusal(path)
    assert fb.load(text=LINK.format("a").join((HEAD, "</robot>")), format="urdf").name == "arm"
    with pytest.raises(fb.FreebodyError, match="no format 'vrml' in load"):
        fb.load(text="x", format="vrml")
    with pytest.raises(fb.FreebodyError, match="take the place of a path"):
        fb.load("2R", text="x", format="toml")
    with pytest.raises(fb.FreebodyError, match="give a path"):
        fb.load()
