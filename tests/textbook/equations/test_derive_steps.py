"""The steps where students stop: squares of velocities, cross products by components, what each
term means, limits; and that no document calls two things by one name."""

from __future__ import annotations

import re
from collections import defaultdict
from typing import Any

import pytest

import freebody as fb
from support.methods import METHODS
from support.notations import NOTATIONS
from support.own_lines import own_lines
from support.printed_lines import symbols_in


def step(derivation: Any, operation: str) -> Any:
    return next(x for x in derivation.steps if x.operation == operation)


def printed(derivation: Any, operation: str) -> list[str]:
    return list(map(str, step(derivation, operation).equations))


WORDS = ["RR", "RP", "RRR"]


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["lagrange", "newton-euler"])
@pytest.mark.parametrize("word", WORDS)
def test_their_lines_are_read_and_right(word: str, method: str):
    model = fb.planar(word)
    lines = own_lines(model, fb.derive(model, method))
    told = ("Squares", "Kinetic", "Angles between", "Substitute", "Two limits", "A limit")
    ours = [x for x in lines if x.step.startswith(told)]
    assert len(ours) > 4
    assert [(x.text, x.reason) for x in ours if x.kind != "right"] == []


def test_products_of_sines_and_cosines_stand_before_the_cosine_of_the_difference():
    products = "(cos θ₁ cos(θ₁+θ₂) + sin θ₁ sin(θ₁+θ₂))"
    lagrange = fb.derive(fb.planar("RR"), "lagrange")
    first, second = printed(lagrange, "Squares of the velocities")
    assert first == "vc₁x² + vc₁y² = lc₁² θ̇₁²"
    assert f"2 l₁ θ̇₁ lc₂ (θ̇₁ + θ̇₂) {products} = " in second
    assert second.endswith("= l₁² θ̇₁² + 2 l₁ lc₂ θ̇₁ (θ̇₁ + θ̇₂) cos θ₂ + lc₂² (θ̇₁ + θ̇₂)²")
    kinetic = printed(lagrange, "Kinetic energies")[1]
    assert kinetic.count(" = ") == 3
    assert "+ ½ I₂ (θ̇₁ + θ̇₂)² = " in kinetic
    arms = printed(fb.derive(fb.planar("RR"), "newton-euler"), "Angles between the arms")
    assert arms[0] == f"sc₁x sc₂x + sc₁y sc₂y = lc₁ lc₂ {products} = lc₁ lc₂ cos θ₂"
    assert arms[1].endswith("= lc₁ lc₂ sin θ₂")


def test_cross_products_are_told_by_components_before_they_are_put_in():
    lines = printed(fb.derive(fb.planar("RR"), "newton-euler"), "Substitute the motion: joint 1")
    assert lines[0].startswith("sc₁ × m₁ (v̇c₁ − g) = m₁ (sc₁x (v̇c₁y + g) − sc₁y v̇c₁x) = m₁ (")
    assert lines[1].startswith("s₁ × m₂ (v̇c₂ − g) = m₂ (s₁x (v̇c₂y + g) − s₁y v̇c₂x) = m₂ (")
    assert lines[-1].startswith("τ₁ = ")


DRIVEN = fb.planar("RP", drives=[fb.Drive(0.4, 0.2, 0.1, 2.0), fb.Drive(0.1, stiffness=5.0)])
TERMS = [fb.planar("R"), fb.planar("RR"), fb.planar("RP"), fb.load("cart_pole"), DRIVEN]


@pytest.mark.sample(5)
@pytest.mark.parametrize("notation", ["notes", "spong"])
@pytest.mark.parametrize("model", TERMS, ids=["R", "RR", "RP", "cart_pole", "drives"])
def test_the_terms_are_those_of_the_equations(model: fb.Model, notation: str):
    """Of each equation they add up to its right side."""
    derivation = fb.derive(model, "lagrange", notation=notation)
    closed, meanings = (
        step(derivation, name) for name in ("The closed form", "What each term means")
    )
    lines = [*map(str, closed.equations)]
    totals: dict[str, list[str]] = defaultdict(list)
    for row in meanings.terms:
        (joint,) = re.findall(r"(?:at|of) joint (\d)", row.words.partition("by the")[0])[-1:]
        totals[joint].append(str(row.symbols[0]))
    for k, line in enumerate(closed.equations[: model.nv], 1):
        lines.append(f"{line.lhs} = {' + '.join(f'({x})' for x in totals[str(k)])}")
    verdict = fb.check(model, "\n".join(lines), notation=notation)
    assert verdict, verdict


def test_terms_are_named_by_what_is_in_them():
    rows = step(fb.derive(fb.planar("RR")), "What each term means").terms
    told = [(str(row.symbols[0]), row.words) for row in rows]
    assert told[:5] == [
        ("H₁₁ θ̈₁", "inertia felt at joint 1"),
        ("H₁₂ θ̈₂", "coupling: what the acceleration of joint 2 takes at joint 1"),
        ("−h θ̇₂²", "centrifugal, at joint 1 by the rate of joint 2"),
        ("−2 h θ̇₁ θ̇₂", "Coriolis, at joint 1 by the rates of joint 1 and joint 2 together"),
        ("m₁ g lc₁ cos θ₁", "gravity: the weight of body 1, at joint 1"),
    ]
    words = {row.words for row in step(fb.derive(DRIVEN), "What each term means").terms}
    assert {"viscous friction of joint 1", "dry friction of joint 1", "spring of joint 2"} <= words
    closing = step(fb.derive(fb.load("four_bar"), "newton-euler"), "What each term means").terms
    assert any("closing forces" in row.words for row in closing)
    spinning = step(fb.derive(fb.load("gyro")), "What each term means").terms
    assert not any("Coriolis" in row.words for row in spinning)


@pytest.mark.parametrize("word", ["RR", "PR", "RRR"])
def test_without_the_last_mass_the_shorter_arm_remains(word: str):
    lines = printed(fb.derive(fb.planar(word), "newton-euler"), "Two limits")[1:]
    x = "θ₁" if word[0] == "R" else "d₁"
    shorter = printed(fb.derive(fb.planar(word[:-1]), "lagrange"), f"The equation of {x}")
    assert lines[0].startswith(shorter[1])
    n = len(word)
    assert len(lines) == n - 1
    assert all(f"m{chr(0x2080 + n)} " in line for line in lines)


def test_with_the_other_joints_held_an_arm_is_a_compound_pendulum():
    line = printed(fb.derive(fb.planar("RRR"), "kane"), "Two limits")[0]
    assert line == (
        "θ₂ = θ₃ = θ̇₂ = θ̇₃ = θ̈₂ = θ̈₃ = 0: τ₁ = (m₁ lc₁² + I₁ + m₂ (l₁ + lc₂)² + I₂ "
        "+ m₃ (l₁ + l₂ + lc₃)² + I₃) θ̈₁ + m₁ g lc₁ cos θ₁ + m₂ g (l₁ + lc₂) cos θ₁ "
        "+ m₃ g (l₁ + l₂ + lc₃) cos θ₁"
    )
    cart = printed(fb.derive(fb.load("cart_pole")), "Two limits")[0]
    assert cart == "ẋ = ẍ = 0: 0 = m₂ l₂² θ̈₂ + m₂ g l₂ sin θ₂"
    reason = step(fb.derive(fb.planar("RR")), "Two limits").reason
    assert "the arm stretched" in reason
    assert "stretched" not in step(fb.derive(fb.planar("RP")), "Two limits").reason


@pytest.mark.parametrize("name", ["pendulum", "four_bar", "scara"])
def test_there_are_no_limits_where_they_say_nothing(name: str):
    operations = [x.operation for x in fb.derive(fb.load(name), "newton-euler").steps]
    assert not any("limit" in x for x in operations)


@pytest.mark.parametrize("form", ["text", "markdown", "latex", "html"])
def test_terms_are_in_every_form(form: str):
    written = getattr(fb.derive(fb.planar("RR")), form)()
    assert "What each term means" in written
    assert "inertia felt at joint 1" in written


# ---------------------------------------------------------------- one name, one thing
SHORT = {"2R", "RP", "cart_pole", "elbow_arm", "furuta", "pendulum", "scara"}


def quick(name: str, notation: str) -> list[pytest.MarkDecorator]:
    return [] if name in SHORT and notation in ("notes", "siciliano") else [pytest.mark.long]


NAMED = [
    pytest.param(x, notation, marks=quick(x, notation))
    for x in fb.models()
    for notation in NOTATIONS
]


@pytest.mark.parametrize(("name", "notation"), NAMED)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_no_document_has_one_name_for_two_things(name: str, notation: str):
    """A printed symbol, bold or not, is one quantity, and has one meaning in the table."""
    model = fb.load(name)
    for method in METHODS:
        try:
            derivation = fb.derive(model, method, notation=notation)
        except fb.FreebodyError:
            continue
        called, meant = defaultdict(set), defaultdict(set)
        for row in derivation.glossary:
            for symbol in row.symbols:
                meant[symbol.latex()].add(row.words)
        rows = [x for one in derivation.steps for row in one.terms for x in row.symbols]
        lines = [line for one in derivation.steps for line in one.equations]
        for line in [*lines, *rows]:
            for x in symbols_in(line):
                called[x.latex()].add(x.name)
        assert {x: names for x, names in called.items() if len(names) > 1} == {}, method
        assert {x: words for x, words in meant.items() if len(words) > 1} == {}, method
