"""Functions without brackets in front of other functions and roots, 2 arctan √…"""

from __future__ import annotations

import pytest

import freebody as fb

ABOVE, BELOW = "(l_1+l_2)^2 - x^2 - y^2", "x^2 + y^2 - (l_1-l_2)^2"
COSINE = r"\frac{x^2+y^2-l_1^2-l_2^2}{2l_1l_2}"

RIGHT = [
    rf"\theta_2 = 2\arctan\sqrt{{\frac{{{ABOVE}}}{{{BELOW}}}}}",
    rf"\theta_2 = \pm 2\arctan\sqrt{{\frac{{{ABOVE}}}{{{BELOW}}}}}",
    f"θ2 = 2 arctan √(({ABOVE})/({BELOW}))",
    f"θ2 = ±2 arctan √(({ABOVE})/({BELOW}))",
    f"θ2 = 2 atan sqrt(({ABOVE})/({BELOW}))",
    r"\sin\theta_2 = \sqrt{1-\cos^2\theta_2}",
    rf"\cos\theta_2 = \cos\arccos{COSINE}",
    "H12 = √4 m2 lc2^2/2 + m2 l1 lc2 c2 + I2",
]

WRONG = [
    rf"\theta_2 = \arctan\sqrt{{\frac{{{ABOVE}}}{{{BELOW}}}}}",
    rf"\theta_2 = 2\arctan\sqrt{{\frac{{{BELOW}}}{{{ABOVE}}}}}",
    f"θ2 = 2 arctan √(({ABOVE})/(x^2 + y^2 - (l_1+l_2)^2))",
    f"θ2 = ±arctan √(({ABOVE})/({BELOW}))",
    r"\sin\theta_2 = \sqrt{1+\cos^2\theta_2}",
    rf"\sin\theta_2 = \cos\arccos{COSINE}",
    "H12 = √9 m2 lc2^2/2 + m2 l1 lc2 c2 + I2",
]


@pytest.mark.parametrize("line", RIGHT)
def test_a_function_needs_no_bracket_before_another(line: str):
    verdict = fb.check(fb.load("2R"), line)
    assert verdict, verdict


@pytest.mark.sample(1)
@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_line_with_such_a_function_is_not_right(line: str):
    assert not fb.check(fb.load("2R"), line)


POSTURE_BEFORE = "D = (x² + y² - l1² - l2²)/(2 l1 l2)\n"


@pytest.mark.parametrize(
    "line",
    [
        "G2 = √((m2 g lc2 c12)²)",
        "G2 = -√((m2 g lc2 c12)²)",
        "G2 = m2 g lc2 √(1 - s12²)",
        "m2 g lc2 c12 = √((m2 g lc2 c12)²)",
        "y = √((l1 s1 + l2 s12)²)",
        "det J = l1 l2 √(1 - c2²)",
        "τ1 θ̇1 = √((τ1 θ̇1)²)",
        "w = √((m2 g lc2 c12)²)\nG2 = w",
    ],
)
def test_only_a_posture_may_have_the_second_value_of_a_root(line: str):
    verdict = fb.check(fb.load("2R"), line)
    assert not verdict
    assert "24 positions only" in str(verdict)


@pytest.mark.parametrize(
    "text",
    [
        POSTURE_BEFORE + "S = √(1 - D²)\nG2 = m2 g lc2 (c1 D - s1 S)",
        POSTURE_BEFORE + "s2 = √(1 - D²)\nG2 = m2 g lc2 (c1 D - s1 s2)",
        POSTURE_BEFORE + "a = arccos(D)\nG2 = m2 g lc2 cos(θ1 + a)",
        "G2 = m2 g lc2 c12 √(m2²)/m2",
        "H22 = √((I2 + m2 lc2²)²)",
    ],
)
def test_a_posture_that_a_line_before_chooses_and_roots_of_what_is_positive_are_right(text: str):
    verdict = fb.check(fb.load("2R"), text)
    assert verdict, verdict
