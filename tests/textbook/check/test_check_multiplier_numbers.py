"""Multipliers and coordinates of closed chains in numbers, with their units."""

from __future__ import annotations

import pytest

import freebody as fb

BAR = fb.load("four_bar")
MOTION = "θ1 = 40°, θ̇1 = 0, θ̈1 = 0"


@pytest.mark.parametrize(
    "answer",
    [
        f"λ1 = 0.577 N at {MOTION}",
        f"λ1 = 0.577 at {MOTION}",
        f"λ1 = 0.000577 kN at {MOTION}",
        f"At {MOTION}: λ1 = 0.577 N, λ2 = -8.44 N",
        "In equilibrium at θ1 = 40°: λ1 = 0.577 N",
        "In equilibrium, at θ1 = 40°:\nλ1 = 0.577 N\nλ2 = -8.44 N",
        "λ1 = 0.577 N at θ1 = 40° in static equilibrium",
    ],
)
def test_a_multiplier_has_a_number_and_a_unit(answer: str):
    verdict = fb.check(BAR, answer)
    assert verdict, verdict
    assert len(verdict.equations) == answer.count("λ")


@pytest.mark.parametrize(
    ("robot", "answer", "at", "is_right"),
    [
        ("four_bar", "λ1 = 0.577 N", MOTION, True),
        ("four_bar", "λ1 = 0.587 N", MOTION, False),
        ("slider_crank", "d3 = 0.7648 m", {"theta1": "30 deg"}, True),
        ("slider_crank", "d3 = 0.7748 m", {"theta1": "30 deg"}, False),
    ],
)
def test_what_loops_tell_has_a_unit_where_the_state_is_given_besides(robot, answer, at, is_right):
    assert bool(fb.check(fb.load(robot), answer, at=at)) is is_right


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "answer",
    [
        f"λ1 = 0.587 N at {MOTION}",
        f"λ1 = 0.577 kN at {MOTION}",
        f"At {MOTION}: λ1 = 0.577 N, λ2 = 8.44 N",
        "In equilibrium at θ1 = 41°: λ1 = 0.577 N",
    ],
)
def test_a_wrong_number_is_not_right(answer: str):
    assert not fb.check(BAR, answer)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (f"λ1 = 0.577 N m at {MOTION}", "given in N m, and has the unit N"),
        ("λ1 = 0.577 N at θ1 = 40°", "depends on θ̇₁, θ̈₁, which are not given"),
    ],
)
def test_what_is_missing_or_does_not_fit_is_told(answer: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(BAR, answer)
