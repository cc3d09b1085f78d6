"""What readers of files share, asked by itself: lines of keys, numbers in text, sizes, packages,
and how xacro is expanded.

A robot shows of these only what its format makes of them.
"""

from __future__ import annotations

import os
import sys
import tomllib
import types
from pathlib import Path
from xml.etree import ElementTree

import pytest

import freebody as fb
from freebody.formats import read_file
from freebody.formats.packages import packages_around
from freebody.formats.read_file import number
from freebody.formats.toml_table import line_of, lines
from freebody.formats.xacro.expand import expanded
from support.extras import extra
from support.xacro_package import package, written


def test_every_key_has_its_line():
    text = """# a comment with [brackets] and key = 3
"quoted key" = 'it''s' # [no.table]
a.b = { c = [1, [2, 3]], "d" = { e = "}" } }
text = \"\"\"
x = 1
[not.a.table] \\\"\"\" still
\"\"\"
raw = '''
y = 2'''
[one . two]
when = 1979-05-27T07:32:00Z
[[many]]
n = 1
[[many]]
n = [
    1, # one
    2,
]
[many.inner]
x = 1
[[many.deep]]
y = 1
""".replace("'it''s'", '"it\'s"')
    tomllib.loads(text)
    found = lines(text)
    expected = {("quoted key",): 2, ("a", "b", "c", 1, 0): 3, ("a", "b", "d", "e"): 3, ("text",): 4,
                ("raw",): 8,
                ("one", "two", "when"): 11, ("many", 0, "n"): 13, ("many", 1): 14,
                ("many", 1, "n", 1): 17,
                ("many", 1, "inner", "x"): 20, ("many", 1, "deep", 0, "y"): 22}  # fmt: skip
    assert {path: found.get(path) for path in expected} == expected
    assert line_of(found, ("many", 1, "n", 0, "unknown")) == 16
    assert ("x",) not in found


def test_a_file_that_says_nothing_of_its_size_is_read_to_the_limit_alone(tmp_path):
    if not Path("/proc/self/mem").exists():
        pytest.skip("no /proc")
    assert read_file.read("/proc/self/status").startswith(b"Name:")
    with pytest.raises(fb.FreebodyError, match="too much for a robot description"):
        read_file.read("/proc/self/status", 20)


# ---------------------------------------------------------------- numbers
NOT_NUMBERS = [
    "1_0",
    "１２",
    "٣",
    "0x10",
    "1e",
    "",
    " 1",
    "1 ",
    "1,5",
    "--1",
    "1e5_0",
    "²",
    "infinite",
    "1d5",
]


@pytest.mark.parametrize("text", NOT_NUMBERS)
def test_what_python_alone_calls_a_number_is_none(text: str):
    assert number(text) is None


@pytest.mark.parametrize("text", ["1", "-1.5", "+.5", "1.", "1e5", "1E-5", "0012"])
def test_numbers(text: str):
    assert number(text) == float(text)


def test_where_meshes_are_looked_for(tmp_path: Path):
    for name in ("pkg/urdf/arm.urdf", "pkg/meshes/a.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("x")
    found = tmp_path / "pkg/meshes/a.stl"
    packages = packages_around(str(tmp_path / "pkg/urdf/arm.urdf"))
    for name in (
        "package://pkg/meshes/a.stl",
        "package://renamed/meshes/a.stl",
        "../meshes/a.stl",
        f"file://{found}",
    ):
        where = packages.located(name)
        assert where is not None
        assert where.resolve() == found
    for name in ("package://pkg/meshes/b.stl", "http://pkg/meshes/a.stl", "b.stl"):
        assert packages.located(name) is None


FEATURES = {
    "numbers": '<xacro:property name="l" value="0.5"/><link name="a${2*l}${round(pi, 2)}"/>',
    "lazy": '<xacro:property name="a" value="${b+1}"/><xacro:property name="b" value="2"/>'
    '<link name="x${a}"/>',
    "eager": '<xacro:property name="b" value="1"/><xacro:property name="a" value="${b+1}" '
    'lazy_eval="false"/><xacro:property name="b" value="7"/><link name="x${a}"/>',
    "default": '<xacro:property name="a" value="1"/><xacro:property name="a" default="9"/>'
    '<xacro:property name="c" default="8"/><link name="x${a}${c}"/>',
    "remove": '<xacro:property name="a" value="1"/><xacro:property name="a" remove="true"/>'
    '<xacro:property name="a" default="2"/><link name="x${a}"/>',
    "text": "<xacro:property name='a' value=\"'007'\"/><xacro:property name='b' value='1_0'/>"
    "<link name='x${a}${b}'/>",
    "escaped": '<link name="$${a} $$(b) $ c$"/>',
    "macro": '<xacro:macro name="m" params="name size:=${1+1} suffix:=\'\'"><link name="${name}'
    '${size}${suffix}"/></xacro:macro><xacro:m name="a"/><xacro:m name="b" size="3" suffix="_e"/>',
    "forward": '<xacro:property name="p" value="out"/><xacro:macro name="m" params="p:=^ q:=^|x">'
    '<link name="${p}${q}"/></xacro:macro><xacro:m/><xacro:m p="in"/>',
    "blocks": '<xacro:macro name="m" params="*one **two"><link name="l"><xacro:insert_block '
    'name="one"/><xacro:insert_block name="two"/></link></xacro:macro>'
    '<xacro:m><a x="${1+1}"/><b><c/><d/></b></xacro:m>',
    "block property": '<xacro:property name="p"><a x="${k}"/><b/></xacro:property><xacro:property '
    'name="k" value="3"/><link name="l"><xacro:insert_block name="p"/></link>',
    "macro in macro": '<xacro:macro name="in" params="x"><link name="${x}"/></xacro:macro>'
    '<xacro:macro name="out" params="x"><xacro:in x="${x}1"/><xacro:in x="${x}2"/></xacro:macro>'
    '<xacro:out x="a"/>',
    "recursion": '<xacro:macro name="m" params="n"><xacro:if value="${n > 0}"><link name="l${n}"/>'
    '<xacro:m n="${n-1}"/></xacro:if></xacro:macro><xacro:m n="4"/>',
    "scopes": '<xacro:macro name="m" params=""><xacro:property name="g" value="1" scope="global"/>'
    '<xacro:property name="p" value="2" scope="parent"/><xacro:property name="o" value="3"/>'
    '</xacro:macro><xacro:property name="o" value="0"/><xacro:m/><link name="l${g}${p}${o}"/>',
    "conditions": '<xacro:if value="true"><a/></xacro:if><xacro:if value="0"><b/></xacro:if>'
    "<xacro:unless value=\"${1 == 2}\"><c/></xacro:unless><xacro:if value=\"${'a' in 'cat'}\"><d/>"
    "</xacro:if>",
    "arguments": '<xacro:arg name="n" default="3"/><xacro:arg name="w" default="x y"/>'
    '<link name="l$(arg n)$(arg w)"/><link name="m${xacro.arg(\'n\')}"/><link name="$(eval n+1)"/>',
    "element": '<xacro:property name="t" value="link"/><xacro:element xacro:name="${t}" name="a">'
    '<xacro:attribute name="b" value="x${1+1}"/></xacro:element>',
    "call": '<xacro:macro name="m1" params="a"><link name="${a}"/></xacro:macro>'
    '<xacro:call macro="m${1}" a="z"/>',
    "lists": '<xacro:property name="v" value="${[1.5, 2, 3]}"/><link name="${v[0]}${len(v)}'
    "${[2*x for x in v if x > 1.5]}${dict(a=1)['a']}\"/>",
    "functions": "<link name=\"${radians(90)} ${min(3, 2)} ${math.hypot(3, 4)} ${'a b'.split()[1]} "
    "${xacro.tokenize('1,2;3')} ${'yes' if 1 &lt; 2 else 'no'} ${str(1e-5)} ${int(2.7)}\"/>",
    "include": '<xacro:include filename="parts/part.xacro"/><xacro:part n="1"/>',
    "namespace": '<xacro:include filename="parts/part.xacro" ns="p"/><xacro:p.part n="2"/>'
    '<link name="${p.length}"/>',
    "several": '<xacro:include filename="parts/more_*.xacro"/>',
    "optional": '<xacro:include filename="parts/none.xacro" optional="true"/><link name="a"/>',
    "yaml": '<xacro:property name="y" value="${xacro.load_yaml(\'parts/n.yaml\')}"/>'
    "<link name=\"${y['a'][0]} ${y.b.c} ${round(y.turn, 6)} ${y.length}\"/>",
    "find": '<xacro:include filename="$(find arm_description)/urdf/parts/part.xacro"/>'
    '<xacro:part n="5"/>',
}


def tree(element):
    """Tag, attributes and elements inside; namespaces apart."""
    attributes = {k: v for k, v in element.items() if not k.startswith("{")}
    return element.tag, attributes, [tree(child) for child in element]


@pytest.mark.parametrize("feature", FEATURES)
def test_expands_as_ros_does(feature, tmp_path, monkeypatch):
    """Each feature of the language against the tool that defines it."""
    xacro = extra("xacro", "the xacro wheel")
    folder = package(tmp_path)
    path = written(folder, FEATURES[feature])
    # ROS's own finder of packages; the wheel has none without ROS
    index = types.ModuleType("ament_index_python.packages")
    index.get_package_share_directory = lambda name: os.fspath(folder.parent)
    monkeypatch.setitem(sys.modules, "ament_index_python", types.ModuleType("x"))
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", index)
    theirs = ElementTree.fromstring(xacro.process_file(str(path)).toxml())
    ours = expanded(str(path), path.read_bytes(), packages_around(str(path)), {}).root

    def as_tree(element):
        return element.tag, element.attributes, [as_tree(child) for child in element.children]

    assert [as_tree(child) for child in ours.children] == [tree(child) for child in theirs]
