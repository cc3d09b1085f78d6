"""Singular poses in answers, in sentences and formulas."""

from __future__ import annotations

import pytest

import freebody as fb

ARM = fb.planar("RR")


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("singular at theta2 = 0, pi", 2),
        ("The arm is singular at θ2 = 0 or π.", 2),
        ("The singularities are at q2 = 0 and q2 = ±180°", 3),
        ("It is singular where sin θ2 = 0", 1),
        (r"the arm is singular at $\theta_2 = 0$ or $\theta_2 = \pi$.", 2),
        ("det J = l1 l2 s2 = 0, so the arm is singular at θ2 = 0", 2),
    ],
)
def test_singular_poses_are_put_into_the_determinant(text: str, count: int):
    verdict = fb.check(ARM, text, form="markdown" if "$" in text else "text")
    assert verdict, verdict
    assert len(verdict.equations) == count
    assert "det J = l₁ l₂ sin θ₂." in verdict.text
    for other in ("θ1", "q1", r"\theta_1", "theta1"):
        name = other.replace("1", "2")
        if name in text:
            assert not fb.check(ARM, text.replace(name, other), form="markdown")


@pytest.mark.parametrize("text", ["singular at θ2 = π/2", "singular at θ2 = 90°, 0"])
def test_poses_that_are_not_singular(text: str):
    verdict = fb.check(ARM, text)
    assert not verdict
    assert verdict.causes == ("There det J is not 0: det J = l₁ l₂ sin θ₂.",)


def test_nothing_beside_a_pose_is_passed_over():
    verdict = fb.check(ARM, "singular at θ2 = 0; H12 = m2 lc2^2 + I2; singular at θ2 = π")
    assert [x.name for x in verdict.equations if not x.equal] == ["H12"]
    sliding = fb.check(fb.planar("RP"), "singular at d2 = 0")
    assert "det J = −l₁ − d₂." in sliding.text
    assert not sliding


@pytest.mark.parametrize(
    "text",
    [
        "The arm is not singular at θ2 = π/2",
        "singular at l1 = 0",
        "singular at θ2 = 0 or " * 101,
    ],
)
def test_what_is_no_singular_pose_is_not_judged(text: str):
    with pytest.raises(fb.AnswerError):
        fb.check(ARM, text)


@pytest.mark.parametrize("pose", ["2 θ₂ = π", "2θ₂ = 2π", "θ₁ + θ₂ = 0", "1 - θ₂ = 0"])
def test_a_multiple_of_an_angle_is_not_the_angle(pose: str):
    arm = fb.load("2R")
    assert fb.check(arm, "singular at θ₂ = π")
    with pytest.raises(fb.FreebodyError):
        fb.check(arm, f"singular at {pose}")


@pytest.mark.parametrize(
    ("robot", "determinant", "right", "wrong"),
    [
        ("slider_crank", "cos(θ1+θ2)", "θ1 + θ2 = ±π/2", "θ1 - θ2 = π/2"),
        ("slider_crank", "cos(θ1+θ2)", "-θ1 - θ2 = π/2", "-θ1 + θ2 = π/2"),
        ("slider_crank", "cos(θ1+θ2)", "θ2 + θ1 = 90°", "θ2 + θ1 = 0"),
        ("four_bar", "-sin(θ1+θ2-θ3)", "-θ1 - θ2 + θ3 = 0, π", "-θ1 - θ2 - θ3 = 0, π"),
        ("four_bar", "-sin(θ1+θ2-θ3)", "θ3 - θ2 - θ1 = 0, π", "θ3 - θ2 + θ1 = 0, π"),
    ],
)
def test_a_sum_of_angles_is_a_pose_with_its_signs(
    robot: str, determinant: str, right: str, wrong: str
):
    """A line below the determinant, which the one angle is told from."""
    model, above = fb.load(robot), f"det J_a = {determinant}\n"
    assert fb.check(model, above + right)
    verdict = fb.check(model, above + wrong)
    assert verdict.equations[0].equal
    assert not any(x.equal for x in verdict.equations[1:])
