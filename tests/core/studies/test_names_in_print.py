"""Names as files have them, foreign, long or hostile, in formulas, sentences and drawings: legible
and well-formed."""

from __future__ import annotations

import ast
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import freebody as fb
from freebody import Inertia, Parameter
from support.hostile import NAMES, balanced
from support.robots import Joint, Link, Mount, Robot, loaded, shift

WORD_JOINER = "\u2060"
"""Marks names within sentences of freebody's own, and goes before they print."""


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


# ---------------------------------------------------------------- whole documents
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", NAMES)
def test_documents_of_hostile_names_are_well_formed(name: str):
    derivation = fb.derive(four_bar(name), "statics")
    document = derivation.latex()
    assert ("{5173}" in document) == ("关" in name)
    assert balanced(document), "braces and environments close"
    assert document.count(r"\begin{") == document.count(r"\end{")
    assert not re.search(r"(?<!\\)[%#]", document)
    assert r"\input" not in document
    assert WORD_JOINER not in document + derivation.text() + derivation.markdown()
    page = derivation.html()
    empty = r"<!doctype html>|<(meta|link|input|br)[^>]*>|<script.*?</script>"
    ET.fromstring(re.sub(empty, "", page, flags=re.DOTALL).replace("&nbsp;", " "))
    assert "<b>1" not in page
    assert "\x1b" not in derivation.text()


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


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("robot", "mark", "tex"), [("RP", "i", "n_{"), ("polar_arm", "b", r"\mathbf{n}_{")]
)
def test_moments_look_alike_in_sentences_and_equations(robot, mark, tex):
    """Scalars in the plane, vectors in space."""
    derivation = fb.derive(fb.load(robot), "newton-euler")
    marked = set(re.findall("<(b|i)>n</[bi]><sub>", derivation.html()))
    assert marked == {mark}
    assert f"moment ${tex}" in derivation.markdown()
