"""What is derived in a notation is what `check` reads in it, and says who writes so."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import freebody as fb
from freebody.cli.app import run
from freebody.derivations.notations.notation import PRESETS, BookNotation

ARM = fb.planar("RR")
DERIVED = [
    ("2R", "newton-euler"), ("2R", "lagrange"), ("2R", "kane"), ("RP", "lagrange"),
    ("pendulum", "lagrange"), ("furuta", "recursive"), ("cart_pole", "lagrange"),
    ("four_bar", "lagrange-first-kind"), ("slider_crank", "newton-euler"),
]  # fmt: skip


def lines(derivation: fb.Derivation) -> list[str]:
    return [str(line) for step in derivation.steps for line in step.equations]


def is_right(model: fb.Model, text: str, notation: str | None = None) -> bool:
    try:
        return bool(fb.check(model, text, notation=notation))
    except fb.FreebodyError:
        return False


@cache
def read_in_the_notes(robot: str, method: str) -> tuple[list[int], int]:
    """The lines before the closed form that `check` reads in the notes' own letters, by place."""
    model = fb.load(robot)
    told = fb.derive(model, method)
    closed = told.steps[-1].operation == "The closed form"
    before = lines(told)[: -len(told.steps[-1].equations) if closed else None]
    return [k for k, line in enumerate(before) if is_right(model, line)], len(before)


@pytest.mark.parametrize("notation", PRESETS)
@pytest.mark.parametrize(("robot", "method"), DERIVED)
def test_what_is_printed_in_a_notation_is_read_in_it(robot: str, method: str, notation: str):
    model = fb.load(robot)
    printed = lines(fb.derive(model, method, notation=notation))
    places, end = read_in_the_notes(robot, method)
    chosen = [printed[k] for k in places] + printed[end:]
    assert len(chosen) > 10
    if not is_right(model, "\n".join(chosen), notation):
        assert [line for line in chosen if not is_right(model, line, notation)] == []


CLOSED = {
    "notes": ["τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² − 2 h θ̇₁ θ̇₂ + G₁", "h = m₂ l₁ lc₂ sin θ₂"],
    "craig": ["τ₁ = M₁₁ θ̈₁ + M₁₂ θ̈₂ + V₁ + G₁", "V₂ = m₂ l₁ lc₂ s₂ θ̇₁²", "G₂ = m₂ g lc₂ c₁₂"],
    "spong": ["τ₂ = d₂₁ q̈₁ + d₂₂ q̈₂ + C₂₁ q̇₁ + g₂", "C₂₁ = m₂ l₁ lc₂ sin(q₂) q̇₁"],
    "siciliano": ["b₂₂ = ml₂ l₂² + Il₂", "C₂₁ = ml₂ a₁ l₂ s₂ θ̇₁", "g₂ = ml₂ g l₂ c₁₂"],
    "murray-li-sastry": ["M₂₂ = m₂ r₂² + Iz₂", "N₂ = m₂ g r₂ c₁₂"],
    "lynch-park": ["M₂₂ = m₂ r₂² + I₂", "h₂ = m₂ L₁ r₂ sin(θ₂) θ̇₁² + m₂ g r₂ cos(θ₁+θ₂)"],
    "featherstone": ["τ₂ = H₂₁ q̈₁ + H₂₂ q̈₂ + C₂", "H₂₂ = m₂ lc₂² + I₂"],
}


@pytest.mark.parametrize("notation", PRESETS)
def test_each_book_has_its_letters(notation: str):
    told = fb.derive(ARM, "lagrange", notation=notation)
    assert set(CLOSED[notation]) <= set(lines(told)[-10:])
    own = fb.equations(ARM).text(names=notation).splitlines()
    assert set(CLOSED[notation]) <= set(own)


def test_sentences_tables_and_documents_have_the_letters_too():
    told = fb.derive(fb.load("2R"), "lagrange", notation="siciliano")
    text = told.text()
    assert "h = ml₂ a₁ l₂ sin θ₂" in text
    assert "ml₁             mass of body 1 [kg]" in text
    words = " ".join(text.split())
    assert "the mass matrix B, the matrix C of velocity terms and gravity g" in words
    assert "Letters: B. Siciliano" in words
    assert "lc" not in text
    assert "T_i, U_i" in text
    assert r"\begin{aligned}" in told.latex()
    assert r"b_{22} &= m_{l2} l_2^2 + I_{l2}" in told.latex()
    spong = fb.derive(ARM, "lagrange", notation="spong")
    assert "10. Derivatives for q₂" in spong.text()
    assert "θ" not in spong.text()


def test_pages_and_drawings_have_the_letters():
    told = fb.derive(fb.load("2R"), "lagrange", notation="siciliano")
    page = told.html()
    assert ">a_1<" in page or "<tspan" in page
    assert "lc1" not in page.split("<script>", maxsplit=1)[0].replace('data-of="lc1"', "").replace(
        'data-input="lc1"', ""
    )
    assert '"called":{"l2":"lc2"' in page or '"l2":"lc2"' in page
    assert "--notation siciliano" in page
    figure = fb.free_body_diagram(fb.load("2R"), show="lengths", notation="siciliano")
    names = {getattr(x, "label", "") for drawing in figure.drawings for x in drawing.elements}
    assert {"a_1", "l_1", "l_2", "m_{l1} *g*"} <= names
    diagram = fb.kinematic_diagram(fb.load("2R"), notation="spong")
    assert diagram.named("q_2")


def test_two_things_are_never_printed_by_one_name():
    one = BookNotation("one", names={"r": "lc", "r1": "l1"})
    with pytest.raises(fb.FreebodyError, match="notation 'one' calls both l1 and lc1 r1"):
        fb.derive(ARM, notation=one)
    torque = BookNotation("two", letters={"tau": ("L",)}, names={"L": "l"})
    with pytest.raises(fb.FreebodyError, match=r"notation 'two' calls both .*τ₁.* L₁"):
        fb.derive(ARM, notation=torque)
    crane = fb.load("gantry_crane")  # its only length is l, and L the Lagrangian
    told = fb.derive(crane, "lagrange", notation="lynch-park")
    assert "∂L/∂ẋ = (m₁ + m₂ + m) ẋ + m l cos(θ₄) θ̇₄" in lines(told)
    assert is_right(crane, "∂L/∂ẋ = (m₁ + m₂ + m) ẋ + m l cos(θ₄) θ̇₄", "lynch-park")


@pytest.mark.parametrize(
    "file",
    [
        "[names]\n'<script>alert(1)</script>' = 'l'",
        "[letters]\nmass = '\\input{/etc/passwd}'",
        "[letters]\nmass = 'M</title>'",
        "[letters]\nkinetic = 'é'",
        "[names]\n'l;import os' = 'l1'",
    ],
)
def test_hostile_names_are_refused(tmp_path: Path, file: str):
    path = tmp_path / "mine.toml"
    path.write_text(file, encoding="utf-8")
    with pytest.raises(fb.FreebodyError, match=r"is no letter|can be printed"):
        fb.derive(ARM, "lagrange", notation=path)


def test_what_a_notation_tells_of_itself_is_text(tmp_path: Path):
    path = tmp_path / "mine.toml"
    path.write_text("title = '<b>\\input{x}</b>$_'\n[letters]\nmass = 'A'", encoding="utf-8")
    told = fb.derive(ARM, "lagrange", notation=path)
    assert "&lt;b&gt;" in told.html()
    assert "<b>\\input" not in told.html()
    assert r"\input" not in told.latex()
    assert "A₂₂ = m₂ lc₂² + I₂" in lines(told)


def test_the_commands_take_a_notation(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["derive", "RR", "--notation", "craig"]) == 0
    assert "V₂ = m₂ l₁ lc₂ " in capsys.readouterr().out
    out = tmp_path / "arm.svg"
    assert run(["fbd", "2R", "--notation", "siciliano", "--out", str(out)]) == 0
    assert "ml1 g" in capsys.readouterr().out
    assert run(["derive", "RR", "--notation", "crag"]) == 2
    assert "Did you mean 'craig'" in capsys.readouterr().err
