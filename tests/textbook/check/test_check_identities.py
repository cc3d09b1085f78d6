"""Identities of sines and cosines on lines of their own: right, and nothing is claimed of the
robot."""

from __future__ import annotations

import pytest

import freebody as fb

NOTHING = "It claims nothing of the robot."


@pytest.mark.sample(2)
@pytest.mark.parametrize("robot", ["2R", "four_bar", "panda"])
@pytest.mark.parametrize(
    "line",
    [
        "s12 = s1 c2 + c1 s2",
        "c12 = c1·c2 - s1·s2",
        "c1 = c12 c2 + s12 s2",
        "sin(θ1+θ2) = s1 c2 + c1 s2",
        "sin²θ1 + cos²θ1 = 1",
        "1 - cos²θ2 = sin²θ2",
        "cos 2θ1 = 2 c1² - 1",
        "tan θ1 = s1/c1",
    ],
)
def test_an_identity_is_right(robot: str, line: str):
    verdict = fb.check(fb.load(robot), line)
    assert verdict, verdict
    assert NOTHING in verdict.text


@pytest.mark.parametrize(
    "line",
    [
        "s12 = s1 c2 - c1 s2",
        "c12 = c1·c2 + s1·s2",
        "c1 = c12 c2 - s12 s2",
        "cos 2θ1 = 2 c1² + 1",
        "tan θ1 = c1/s1",
    ],
)
def test_a_wrong_one_is_not_right(line: str):
    assert not fb.check(fb.load("2R"), line)


@pytest.mark.parametrize("line", ["sin θ2 = 0", "c1 c2 = 0", "c1² + s1² = 2", "s12 = sin(θ1+θ2)"])
def test_an_equation_for_a_pose_and_an_abbreviation_are_no_identities(line: str):
    with pytest.raises(fb.AnswerError):
        fb.check(fb.load("2R"), line)


def test_other_lines_are_judged_beside_it():
    verdict = fb.check(fb.load("2R"), "s12 = s1 c2 + c1 s2\nG2 = m2·g·lc2·(c1·c2 - s1·s2)")
    assert [x.equal for x in verdict.equations] == [True, True]
    assert not fb.check(fb.load("2R"), "s12 = s1 c2 + c1 s2\nG2 = m2 g lc2 c2")


@pytest.mark.parametrize(
    ("line", "is_right"),
    [
        ("h = m2 l1 lc2 s2", True),
        ("h = m2 l1 l2 s2 / 2", True),
        ("h = -m2·l1·l2·s2 / 2", True),
        ("h = m2 l1 l2 s2", False),
        ("h = m2 l1 l2 c2 / 2", False),
    ],
)
def test_the_velocity_coefficient_follows_parameters_by_formulas(line: str, is_right: bool):
    assert bool(fb.check(fb.load("2R"), line, parameters={"lc": "l/2"})) is is_right
