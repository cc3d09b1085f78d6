"""Angular momenta in answers, whose letters are those of the mass matrix and the Lagrangian too."""

from __future__ import annotations

import pytest

import freebody as fb

RIGHT = [
    ("pendulum", "H = I θ̇", "centre of mass"),
    ("pendulum", "H = I ω", "centre of mass"),
    ("pendulum", "L = (I + m lc²) θ̇", "base's origin"),
    ("pendulum", "H = (I1 + m1 lc1^2) θ̇1", "base's origin"),
    ("pendulum", "H_O = (I1 + m1 lc1²) ω", "base's origin"),
    ("pendulum", "H_G = I θ̇", ""),
    ("pendulum", r"\mathbf{H}_O = (I_1 + m_1 l_{c1}^2) \dot\theta_1", "base's origin"),
    ("pendulum", "H = I1 + m1 lc1^2", ""),
    ("pendulum", "L = ½ (I + m lc²) θ̇² - m g lc s1", ""),
    ("2R", "L2 = I2 (θ̇1+θ̇2)", "centre of mass"),
    ("2R", "H_2 = I2 ω2 + m2 (lc2² (θ̇1+θ̇2) + l1 lc2 c2 θ̇1)", "its own joint"),
    ("2R", "H = H11 θ̇1 + H12 θ̇2", "base's origin"),
    ("2R", "H_1 = m1 lc1² + I1\nH11 = H_1 + m2 (l1² + lc2² + 2 l1 lc2 c2) + I2", ""),
    ("four_bar", "H_3 = (I3 + m3 lc3²) θ̇3", "its own joint"),
    ("RPR", "H_3 = I3 (θ̇1+θ̇3)", "centre of mass"),
    ("slider_crank", "H_3 = 0", "centre of mass"),
]

WRONG = [
    ("pendulum", "H = 2 I θ̇"),
    ("pendulum", "H = (I + m lc) θ̇"),
    ("pendulum", "H = I θ̈"),
    ("pendulum", "H = I1"),
    ("pendulum", "H_O = I θ̇"),
    ("pendulum", "H_G = (I + m lc²) θ̇"),
    ("2R", "L2 = I2 θ̇2"),
    ("2R", "L2 = I1 (θ̇1+θ̇2)"),
    ("2R", "H_2 = I2 ω2 + m2 (lc2² (θ̇1+θ̇2) - l1 lc2 c2 θ̇1)"),
    ("2R", "H = H11 θ̇1 + H22 θ̇2"),
    ("four_bar", "L2 = I2 θ̇2"),
    ("slider_crank", "H_O = 0"),
]


@pytest.mark.parametrize(("robot", "line", "point"), RIGHT)
def test_an_angular_momentum_is_right_about_the_point_that_its_verdict_names(robot, line, point):
    verdict = fb.check(fb.load(robot), line)
    assert verdict, verdict
    assert point in verdict.text


@pytest.mark.sample(3)
@pytest.mark.parametrize(("robot", "line"), WRONG)
def test_a_wrong_angular_momentum_is_not_right(robot, line):
    assert not fb.check(fb.load(robot), line)


def test_relative_rates_are_named_as_the_reason():
    text = fb.check(fb.load("2R"), "H_2 = I2 θ̇2").text
    assert "angular momentum of body 2" in text
    assert "from the previous link" in text


def test_a_length_called_like_a_momentum_is_not_read_as_one():
    arm, line = fb.load("2R"), "H12 = m2 (lc2^2 + L1 lc2 c2) + I2"
    assert fb.check(arm, line, names={"L1": "l1"})
    assert fb.check(arm, f"L1 = l1\n{line}")
    with pytest.raises(fb.AnswerError, match="no symbol 'L1'"):
        fb.check(arm, f"L2 = I2 ω2\n{line}")


def test_a_unit_tells_that_a_letter_of_the_mass_matrix_is_a_momentum():
    """At rest in θ2 it is (m1 lc1² + I1 + m2 (l1 + lc2)² + I2) θ̇1 = 8.04 kg m²/s."""
    state = "θ1 = 0, θ2 = 0, θ̇1 = 1 rad/s, θ̇2 = 0"
    assert fb.check(fb.load("2R"), f"H = 8.04 kg m²/s at {state}")
    assert not fb.check(fb.load("2R"), f"H = 8.14 kg m²/s at {state}")
