"""Names as files have them, foreign, long or hostile, in formulas, sentences and drawings: legible
and well-formed."""

from __future__ import annotations

import ast
import re
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Parameter
from freebody.expressions.printed_names import sym
from freebody.expressions.typesetting import literal
from freebody.figures.marked_text import html, marked, plain, runs
from freebody.figures.plots import Plot, plot
from freebody_textbook.render.prose import markdown_prose, tex_prose, text_prose, web_prose
from support.robots import Joint, Link, Mount, Robot, loaded, shift

ROBOTS = sorted(Path(fb.__file__).parent.glob("robots/*.toml"))
SPECIAL = r"\_%#&${}~^<>|\"'`*[]" + "\u202e\x1b\n"
NAMES = (
    "θ1",
    "left/joint1",
    "n" * 40,
    "<b>",
    "关节",
    "a_1",
    "50%_of#1&co$",
    r"\input{x}",
    "x^2~y",
    "}",
    "`*_[]|",
    SPECIAL,
)


def four_bar(name: str) -> fb.Model:
    """Links, joints, frames, loop and robot of that name, and its source."""
    links = [Link(f"{name}{k}", Inertia.point(1.0, (0.1, 0.0))) for k in range(4)]
    place = [shift(0.0, 0.0), shift(0.3, 0.0), shift(0.6, 0.0)]
    parents = (0, 1, 0)
    joints = [
        Joint(f"{name}j{k}", "revolute", f"{name}{p}", f"{name}{k}", at, (1.0,), passive=k > 1)
        for k, (p, at) in enumerate(zip(parents, place, strict=True), 1)
    ]
    mounts = (
        Mount(f"{name} end", f"{name}2", shift(Parameter("l2", 0.5), 0.0)),
        Mount(f"{name} tip", f"{name}3", shift(0.4, 0.0)),
    )
    made = Robot(
        name,
        2,
        tuple(links),
        tuple(joints),
        (9.81, (0.0, -1.0)),
        mounts,
        tip=f"{name} end",
        source=f"by {name}.",
    )
    return loaded(made).with_loop(f"{name} pin", "revolute", (f"{name} tip", f"{name} end"))


# ---------------------------------------------------------------- the functions
@pytest.mark.parametrize("name", NAMES)
def test_escaped_names_are_letters_to_tex(name: str):
    """What is left after the known commands has no character that TeX reads as anything but
    itself."""
    for made in (
        literal.tex(name),
        tex_prose(f"link {literal.literal(name)} of x_1").split(" of $x")[0],
    ):
        rest = re.sub(r"\\text[a-z]+\{\}|\\[&%$#_{}]|\$\\[a-z]+\$", "", made)
        assert not re.search(r"[\\&%$#_{}~^<>|\"]", rest), made
    formula = literal.tex_math(name)
    assert formula == name or formula == f"\\text{{{literal.tex(name)}}}"


@pytest.mark.parametrize("name", NAMES)
def test_names_in_sentences_are_no_symbols(name: str):
    sentence = f"point {literal.literal(name)} of s_1"
    shown = "".join(c if c.isprintable() else "\ufffd" for c in " ".join(name.split()))
    assert text_prose(sentence) == f"point {shown} of s₁"
    page = ET.fromstring(f"<p>{web_prose(sentence)}</p>")
    assert "".join(page.itertext()) == f"point {shown} of s1"
    assert [e.tag for e in page] == ["b", "sub"]
    unescaped = re.sub(
        r"\\(.)", r"\1", markdown_prose(sentence).removesuffix(r" of $\mathbf{s}_{1}$")
    )
    assert unescaped == f"point {shown}"


def test_plain_names_have_no_marks():
    assert literal.literal("link2") == "link2"
    assert literal.MARK not in text_prose(f"link {literal.literal('a_b')}")


def test_foreign_letters_are_declared_to_tex():
    lines = literal.declared("关节 θ é – x")
    assert any("5173" in line for line in lines)
    assert not any("03B8" in line or "2013" in line for line in lines)
    assert literal.declared("plain é – θ") == []


def test_what_is_said_of_bundled_robots_is_set_by_any_tex():
    said = [tomllib.loads(file.read_text("utf-8")).get("about", "") for file in ROBOTS]
    assert any("₂" in about for about in said)
    assert literal.declared(literal.tex(" ".join(said))) == []
    assert literal.tex("θ̇₁² − x̂") == r"$\dot{\theta}$$_{1}$² $-$ x̂"


# ---------------------------------------------------------------- whole documents
@pytest.mark.parametrize("name", NAMES)
def test_documents_of_hostile_names_are_well_formed(name: str):
    derivation = fb.derive(four_bar(name), "statics")
    document = derivation.latex()
    assert ("{5173}" in document) == ("关" in name)
    assert balanced(document), "braces and environments close"
    assert document.count(r"\begin{") == document.count(r"\end{")
    assert not re.search(r"(?<!\\)[%#]", document)
    assert r"\input" not in document
    assert literal.MARK not in document + derivation.text() + derivation.markdown()
    page = derivation.html()
    empty = r"<!doctype html>|<(meta|link|input|br)[^>]*>|<script.*?</script>"
    ET.fromstring(re.sub(empty, "", page, flags=re.DOTALL).replace("&nbsp;", " "))
    assert "<b>1" not in page
    assert "\x1b" not in derivation.text()


def balanced(document: str) -> bool:
    """Whether every brace that groups is closed."""
    depth = 0
    for brace in re.findall(r"(?<!\\)(?:\\\\)*([{}])", re.sub(r"\\[{}]", "", document)):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    return depth == 0


@pytest.mark.parametrize(
    "name", ["θ1", "left_upper_arm_length_of_the_first_robot", "a__b", "é", "l_", "_"]
)
def test_names_of_parameters_are_legible_formulas(name: str):
    """What a parameter may be called, in LaTeX, MathML and a drawing."""
    formula = sym(name).latex()
    assert balanced(formula)
    assert not re.search(r"(?<!\\)_(?!\{|[A-Za-z0-9])", formula), formula
    ET.fromstring(sym(name).mathml())
    model = fb.planar("RR", l=[name, "l2"])
    for drawing in fb.kinematic_diagram(model).drawings:
        ET.fromstring(fb.kinematic_diagram(model).svg)
        assert drawing


@pytest.mark.parametrize("name", ["j_{}", "j_{1}", "a_b", "j_{", "_{<&>}"])
def test_curves_are_called_what_their_joints_are(name: str):
    """The legend shows a name letter by letter and leaves it room; braces after a bar made the page
    of a study fail."""
    t = np.linspace(0.0, 1.0, 5)
    body = plot(Plot("Torque", t, {name: t, "next": t}, "N m")).body
    drawn = [x for x in ET.fromstring(f"<g>{body}</g>") if x.get("class") == "num"]
    first, second = (x for x in drawn if x.text in (name, "next"))
    assert first.text == name
    assert float(second.get("x", 0)) - float(first.get("x", 0)) > 40 + 4 * len(name)


@pytest.mark.parametrize("text", ["j_{}", "m_{a<b}", "2 θ_12 & x_{1,2}"])
def test_text_with_subscripts_is_well_formed(text: str):
    letters = plain(text)
    for made in (marked(runs(text)), html(text)):
        assert "".join(ET.fromstring(f"<g>{made}</g>").itertext()) == letters


def test_every_name_in_a_sentence_is_literal():
    """Source of the derivations' sentences: no f-string holds a name of the model as it is, but in
    errors, which are plain text; names of joint kinds are the library's own."""
    for path in (Path(fb.__file__).parents[1] / "freebody_textbook" / "methods").glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        raised = {
            x for node in ast.walk(tree) if isinstance(node, ast.Raise) for x in ast.walk(node)
        }
        for node in set(ast.walk(tree)) - raised:
            if isinstance(node, ast.FormattedValue) and isinstance(node.value, ast.Attribute):
                owner = ast.unparse(node.value)
                assert node.value.attr != "name" or owner == "body.kind.name", (
                    f"{path.name}: {owner}"
                )


@pytest.mark.parametrize(
    ("robot", "mark", "tex"), [("RP", "i", "n_{"), ("polar_arm", "b", r"\mathbf{n}_{")]
)
def test_moments_look_alike_in_sentences_and_equations(robot, mark, tex):
    """Scalars in the plane, vectors in space."""
    derivation = fb.derive(fb.load(robot), "newton-euler")
    marked = set(re.findall("<(b|i)>n</[bi]><sub>", derivation.html()))
    assert marked == {mark}
    assert f"moment ${tex}" in derivation.markdown()
