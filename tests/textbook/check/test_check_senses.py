"""Signs that are everybody's own choice: of loop equations and of multipliers; loop equations that
are solved for a length."""

from __future__ import annotations

import pytest

import freebody as fb

BAR = fb.load("four_bar")
CRANK = fb.load("slider_crank")
PHI_X = "Φ1 = l1 c1 + l2 c12 - d - l3 c3"
ROCKER = "(I3 + m3 lc3²) θ̈3 + m3 g lc3 c3"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "lines", "notes"),
    [
        (BAR, "Φ2 = l3 s3 - l1 s1 - l2 s12", ["Φ₂ has the opposite sign"]),
        (BAR, "Φ1 = d + l3 c3 - l1 c1 - l2 c12\n" + "Φ2 = l1 s1 + l2 s12 - l3 s3", ["Φ₁ has", ""]),
        (
            BAR,
            "Φ_q = [[l1 s1 + l2 s12, l2 s12, -l3 s3], [-l1 c1 - l2 c12, -l2 c12, l3 c3]]",
            ["Φ₁ and Φ₂ have the opposite sign"] * 6,
        ),
        (BAR, f"0 = {ROCKER} + λ1 l3 s3 - λ2 l3 c3", [""]),
        (BAR, "d/dt (∂L/∂θ̇1) - ∂L/∂θ1 - ∂Φ1/∂θ1 λ1 - ∂Φ2/∂θ1 λ2 = τ1", ["τ = M q̈ + … − Φ_qᵀ λ"]),
        (BAR, f"0 = {ROCKER} - λ1 l3 s3 + λ2 l3 c3", ["τ = M q̈ + … − Φ_qᵀ λ"]),
        (
            BAR,
            "Φ1 = d + l3 c3 - l1 c1 - l2 c12\n" + f"0 = {ROCKER} - λ1 l3 s3 - λ2 l3 c3",
            ["Φ₁ has the opposite sign"] * 2,
        ),
    ],
)
def test_signs_of_loop_equations_and_multipliers_are_the_answers_own(model, lines, notes):
    verdict = fb.check(model, lines)
    assert verdict, verdict.text
    for equation, note in zip(verdict.equations, notes, strict=True):
        assert note in equation.note
        assert bool(equation.note) == bool(note)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "lines", "right"),
    [
        (BAR, "Φ1 = d + l3 c3 + l1 c1 - l2 c12", [False]),
        (BAR, "Φ1 = -(l1 c1 + l2 c12 - d - l3 c3)", [False]),
        (BAR, "Φ_q12 = l2 s12", [False]),
        (BAR, f"0 = {ROCKER} - (λ1 l3 s3 - λ2 l3 c3)", [False]),
        (CRANK, "m3 d̈3 = λ1\nλ1 = -m3 d̈3", [1, 0]),
        (CRANK, "λ1 = -m3 d̈3", [False]),
        (BAR, f"0 = {ROCKER} - λ1 l3 s3 - λ2 l3 c3", [False]),
        (BAR, f"0 = {ROCKER} + λ1 l3 s3 - λ2 l3 c3\n0 = {ROCKER} - λ1 l3 s3 + λ2 l3 c3", [1, 0]),
        (BAR, "Φ2 = l3 s3 - l1 s1 - l2 s12\nΦ̇2 = l1 c1 θ̇1 + l2 c12 (θ̇1 + θ̇2) - l3 c3 θ̇3", [1, 0]),
    ],
)
def test_but_one_answer_has_one_sense_and_a_single_sign_is_a_mistake(model, lines, right):
    verdict = fb.check(model, lines)
    assert sum(x.equal for x in verdict.equations) == sum(right)
    assert not verdict


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "right", "wrong"),
    [
        (BAR, "d = l1 c1 + l2 c12 - l3 c3", "d = l1 c1 + l2 c12 + l3 c3"),
        (BAR, "l2² = (d + l3 c3 - l1 c1)² + (l3 s3 - l1 s1)²", "l2² = (d + l3 c3 - l1 c1)²"),
        (CRANK, "l2 = (d3 - l1 c1)/c12", "l2 = (d3 - l1 c1)/c2"),
    ],
)
def test_a_loop_equation_may_be_solved_for_a_length(model, right, wrong):
    assert fb.check(model, right)
    verdict = fb.check(model, wrong)
    assert not verdict
    assert "loop equation" in verdict.text


def test_a_wrong_line_about_rods_of_symbolic_length_is_explained():
    verdict = fb.check(fb.load("five_bar_rods"), "V = m1 g lc1 s1")
    assert not verdict
    assert "is missing" in verdict.text


def test_a_term_that_vanishes_in_the_assembly_of_the_file_shows_no_sense():
    """θ3 + θ4 = 0 in a parallelogram: the sign of λ3 says nothing there."""
    model = fb.load("double_four_bar")
    line = (
        "τ4 = {} λ4 cos(θ3+θ4) {} λ3 sin(θ3+θ4) + θ̈3 cos(θ4)/2 + θ̈3/3 + θ̈4/3"
        " + g cos(θ3+θ4)/2 + θ̇3² sin(θ4)/2"
    )
    assert fb.check(model, line.format("", "-"))
    assert fb.check(model, line.format("-", "+"))
    assert not fb.check(model, line.format("-", "-"))
