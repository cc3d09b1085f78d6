"""Conditions in front of equations, "At θ2 = 0:": these are right where the condition holds, up to
the next condition or paragraph."""

from __future__ import annotations

import pytest

import freebody as fb

ARM = fb.load("2R")
STRETCHED = "H12 = m2 lc2^2 + m2 l1 lc2 + I2"
BENT = "H12 = m2 lc2^2 + I2"
WEIGHTS = "τ1 = (m1 lc1 + m2 l1) g c1 + m2 g lc2 c12"
SLOW = "τ1 = H11 θ̈1 + H12 θ̈2 + G1"


@pytest.mark.parametrize(
    "answer",
    [
        f"θ₂ = 0:\n{STRETCHED}",
        f"θ2 = 0: {STRETCHED}",
        f"At θ2 = 0, {STRETCHED}",
        f"At θ2 = 0:\n{STRETCHED}\nH11 = m1 lc1^2 + I1 + m2 (l1+lc2)^2 + I2",
        f"For θ2 = 0\n{STRETCHED}",
        f"For θ2 = 0,\n{STRETCHED}",
        f"If θ2 = 0, then {STRETCHED}",
        f"If θ2 = 0 then {STRETCHED}",
        f"Let θ2 = 0. Then {STRETCHED}",
        f"With θ2 = 0 we get {STRETCHED}",
        f"When θ2 = 90°, {BENT}",
        f"At θ2 = 0:\n{STRETCHED}\nAt θ2 = π/2:\n{BENT}",
        f"For θ̇ = 0, θ̈ = 0\n{WEIGHTS}",
        f"At rest, {SLOW}",
        f"For θ̇1 = θ̇2 = 0,\n{SLOW}\nτ2 = H21 θ̈1 + H22 θ̈2 + G2",
        f"At θ2 = 60°: {BENT} + m2 l1 lc2/2",
    ],
)
def test_a_line_is_right_where_its_condition_holds(answer: str):
    verdict = fb.check(ARM, answer)
    assert verdict, verdict
    assert all(" At θ" in line for line in verdict.text.splitlines())


@pytest.mark.parametrize(
    "answer",
    [
        STRETCHED,
        f"At θ2 = 0, {BENT}",
        f"At θ1 = 0, {STRETCHED}",
        f"For θ2 = π/2\n{STRETCHED}",
        f"At θ2 = 0:\n{STRETCHED}\nAt θ2 = π/2:\n{STRETCHED}",
        f"At θ2 = 0:\n{STRETCHED}\n\n{STRETCHED}",
        f"For θ̇1 = 0,\n{SLOW}",
        f"For θ̇ = 0\n{WEIGHTS}",
        f"At θ2 = 60°: {BENT} + m2 l1 lc2/3",
    ],
)
def test_a_line_is_wrong_where_its_condition_is_another_or_ends(answer: str):
    assert not fb.check(ARM, answer)


def test_a_condition_on_a_paragraph_of_its_own_goes_on_over_blank_lines():
    assert fb.check(ARM, f"At θ2 = 0:\n\n{STRETCHED}\n\n{STRETCHED}")


def test_a_wrong_line_is_explained_where_its_condition_holds():
    text = fb.check(ARM, f"At θ2 = 0:\n{BENT}").text
    assert "It is compared at θ₂ = 0." in text
    assert "‘l₁’ of ‘m₂ lc₂ (l₁ + lc₂)’ is missing" in text
    assert "at θ₂ = 0.9" not in text
    assert "it must be ½ m₂ l₁ lc₂" in fb.check(ARM, f"At θ2 = 60°: {BENT} + m2 l1 lc2/3").text


SLIDER = fb.load("slider_crank")


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "answer",
    [
        "At θ1 = 90°: ḋ3 = -l1 θ̇1",
        "ḋ3 = -l1 ω1 at θ1 = π/2",
        "At θ1 = 90°: d3 = sqrt(l2^2 - l1^2)",
        "At θ1 = 0: α2 = -l1 α1/(l2 cos θ2)",
        "At rest: d̈3 = -l1 θ̈1 (sin θ1 + cos θ1 tan(-θ1-θ2))",
        "α2 = -l1 α1 cos θ1/(l2 cos(θ1+θ2)) at rest",
    ],
)
def test_a_line_of_a_closed_chain_is_right_where_its_condition_holds(answer: str):
    verdict = fb.check(SLIDER, answer)
    assert verdict, verdict


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "answer",
    [
        "ḋ3 = -l1 θ̇1",
        "At θ1 = 80°: ḋ3 = -l1 θ̇1",
        "At θ1 = 90°: ḋ3 = l1 θ̇1",
        "At θ1 = 90°: d3 = sqrt(l2^2 + l1^2)",
        "α2 = -l1 α1 cos θ1/(l2 cos(θ1+θ2))",
        "α2 = l1 α1 cos θ1/(l2 cos(θ1+θ2)) at rest",
    ],
)
def test_a_line_of_a_closed_chain_is_wrong_where_its_condition_is_another(answer: str):
    assert not fb.check(SLIDER, answer)


@pytest.mark.parametrize(
    "words", ["In general:", "Generally,", "In general", "For all θ2:", "For any θ2", "Otherwise:"]
)
def test_a_condition_ends_where_the_general_case_begins(words: str):
    verdict = fb.check(ARM, f"At θ2 = 0:\n{STRETCHED}\n{words}\n{STRETCHED}")
    assert [x.equal for x in verdict.equations] == [True, False]
    general = "H12 = m2 (lc2^2 + l1 lc2 c2) + I2"
    assert fb.check(ARM, f"At θ2 = 0:\n{STRETCHED}\n{words}\n{general}")


def test_what_holds_in_equilibrium_does_not_hold_in_motion():
    verdict = fb.check(ARM, "In equilibrium, τ2 = m2 g lc2 c12. In motion, τ2 = m2 g lc2 c12")
    assert [x.equal for x in verdict.equations] == [True, False]


@pytest.mark.parametrize(
    ("condition", "line"), [("θ2 = 0:", "det J = 0"), ("For θ̇1 = 0,", "c2 = 0")]
)
def test_a_zero_behind_the_paragraph_of_a_condition_is_not_taken_for_one_there(condition, line):
    assert fb.check(ARM, f"{condition}\n{line}")
    with pytest.raises(fb.AnswerError, match="was said of the paragraph before"):
        fb.check(ARM, f"{condition}\n{line}\n\n{line}")


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "words",
    ["For small θ2", "when the arm is horizontal", "if θ1 > 0", "Neglecting I2", "Linearised"],
)
def test_a_wrong_line_says_which_words_in_front_are_no_condition_that_is_read(words):
    arm = fb.load("2R")
    told = f"‘{words}’ in front of it is not read as a condition"
    line = "{}: G1 = m1 g lc1 + m2 g (l1 + lc2)"
    assert told in fb.check(arm, line.format(words)).text
    assert told not in fb.check(arm, f"{words}: G2 = m2 g lc2 c12").text
    for other in ("For the first joint", "In equilibrium", "For all θ1"):
        assert "not read as a condition" not in fb.check(arm, line.format(other)).text
