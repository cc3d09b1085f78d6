"""Quotients in answers: inverses, solved accelerations and rates, cosines by the tip's position."""

from __future__ import annotations

import pytest

import freebody as fb

ARM, CART, ACROBOT = fb.planar("RR"), fb.load("cart_pole"), fb.load("acrobot")
BAR = fb.load("pendulum")

INVERSE = (
    r"J^{-1} = \frac{1}{l_1 l_2 \sin\theta_2} \begin{bmatrix} l_2 c_{12} & l_2 s_{12} \\"
    r" -l_1 c_1 - l_2 c_{12} & -l_1 s_1 - l_2 s_{12}\end{bmatrix}"
)
INVERSE_3R = (
    "J^{-1} = [[c12/(l1 s2), s12/(l1 s2), l3 s3/(l1 s2)],"
    "[-(l1 c1 + l2 c12)/(l1 l2 s2), -(l1 s1 + l2 s12)/(l1 l2 s2),"
    " -l3 (l1 sin(theta2+theta3) + l2 s3)/(l1 l2 s2)],"
    "[c1/(l2 s2), s1/(l2 s2), (l2 s2 + l3 sin(theta2+theta3))/(l2 s2)]]"
)
ANGULAR = "θ̈ = (-F cos θ - m2 l2 θ̇^2 cos θ sin θ - (m1+m2) g sin θ)/(l2 (m1 + m2 sin^2 θ))"
LINES = [  # of a robot a right line, and a piece of it whose sign is changed
    (ARM, INVERSE, r"& l_2 s_{12}", r"& -l_2 s_{12}"),
    (fb.planar("RRR"), INVERSE_3R, "+ l2 s3)", "- l2 s3)"),
    (ARM, "M^{-1} = 1/(H11 H22 - H12²) [H22, -H12; -H12, H11]", "[H22, -H12", "[H22, H12"),
    (ARM, "q̇ = J⁻¹ ẋ", "J⁻¹", "-J⁻¹"),
    (ARM, r"\ddot\theta = J^{-1}(\ddot x - \dot J\dot\theta)", "- ", "+ "),
    (ARM, "q̈ = M^{-1}(tau - C q̇ - g)", "- C", "+ C"),
    (ARM, "θ̇1 = (ẋ c12 + ẏ s12)/(l1 s2)", "+ ẏ", "- ẏ"),
    (ARM, "θ̈1 = (τ1 - H12 θ̈2 - v1 - G1)/H11", "- v1", "+ v1"),
    (ARM, "cos θ2 = (x² + y² - l1² - l2²)/(2 l1 l2)", "- l2²", "+ l2²"),
    (ARM, "c2 = (x² + y² - l1² - l2²)/(2 l1 l2)", "- l2²", "+ l2²"),
    (ARM, "s1 = ((l1 + l2 c2) y - l2 s2 x)/(x² + y²)", "- l2 s2", "+ l2 s2"),
    (ARM, "2 l1 l2 c2 = x² + y² - l1² - l2²", "- l1²", "+ l1²"),
    (CART, ANGULAR, "- m2 l2", "+ m2 l2"),
    (CART, "ẍ = (F + m2 sin θ (l2 θ̇² + g cos θ))/(m1 + m2 sin²θ)", "+ g", "- g"),
    (CART, "q̈ = M^{-1}(tau - C q̇ - g)", "- g", "+ g"),
    (CART, r"\ddot\theta + \frac{\ddot x}{l_2} \cos\theta + g/l_2 \sin\theta = 0", "+ g", "- g"),
    (BAR, r"θ̈ + m g l_c/(I + m l_c^2) cos θ = τ/(I + m l_c^2)", "+ m g", "- m g"),
    (ACROBOT, "θ̈1 = -(M12 θ̈2 + v1 + G1)/M11", "+ G1", "- G1"),
    (
        ACROBOT,
        "τ2 = (M22 - M12²/M11) θ̈2 + v2 + G2 - M12 (v1 + G1)/M11",
        "- M12²",
        "+ M12²",
    ),
]  # fmt: skip


@pytest.mark.sample(4)
@pytest.mark.parametrize(("model", "line", "piece", "other"), LINES)
def test_quotients_are_right_and_wrong_with_one_sign_changed(model, line, piece, other):
    assert fb.check(model, line), line
    assert piece in line
    verdict = fb.check(model, line.replace(piece, other, 1))
    assert not verdict
    wrong = [x for x in verdict.equations if not x.equal]
    assert all(x.findings or x.causes for x in wrong), verdict
    assert "sign" in wrong[0].text


def test_an_equation_of_a_passive_joint_that_is_put_in_is_told():
    told = "It holds with what follows from no drive at joint"
    assert f"{told} 2." in fb.check(CART, ANGULAR).text
    assert told not in fb.check(ARM, "θ̈1 = (τ1 - H12 θ̈2 - v1 - G1)/H11").text


def test_mistakes_about_inverses_are_named():
    rows = "[l2 c12, l2 s12; -l1 c1 - l2 c12, -l1 s1 - l2 s12]"
    undivided = fb.check(ARM, f"J^{{-1}} = {rows}")
    assert undivided.causes == ("It is not divided by the determinant.",) * 4
    flipped = "[l2 c12, -l1 c1 - l2 c12; l2 s12, -l1 s1 - l2 s12]"
    transposed = fb.check(ARM, f"J^{{-1}} = 1/(l1 l2 s2) {flipped}")
    assert transposed.causes == ("This is the entry of the inverse's transpose.",) * 2


def test_a_quotient_for_a_polynomial_is_wrong():
    for line in ("H12 = l1/l2", "H12 = l1^-1"):
        verdict = fb.check(ARM, line)
        assert not verdict
        assert verdict.equations[0].example is not None


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("θ̈1 = θ̈1 + τ1 - τ1", "θ̈1 stands on both sides: solve for it"),
        ("J^{-1} = J^{-1}", "is defined by itself"),
        ("θ̈1 = 3", "θ̈1 is a symbol of the model"),
        ("θ2 = θ1", "θ2 is a symbol of the model"),
        ("θ̈1 = τ1/(H11 - H11)", "division by zero"),
        ("H12 = cos(l1/l2)", "this quotient is not a polynomial"),
    ],
)
def test_what_tells_nothing_is_refused(line: str, words: str):
    with pytest.raises(fb.AnswerError, match=words.replace("(", r"\(")):
        fb.check(ARM, line)


def test_the_coordinate_of_a_cart_is_not_the_tip():
    """The tip of the bundled cart-pole is its bob; x is the joint's name."""
    assert fb.check(CART, "ẍ = (F + m2 l2 (sin(θ) θ̇² - cos(θ) θ̈))/(m1 + m2)")
    assert fb.check(CART, "xP = x + l2 sin θ")


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("line", "piece", "other"),
    [
        ("theta2 = acos((x² + y² - 0.41)/0.4)", "0.41", "0.42"),
        ("cos θ2 = (x² + y² - 0.41)/0.4", "0.41", "0.42"),
        ("θ̇1 = (ẋ c12 + ẏ s12)/(0.5 s2)", "0.5", "0.6"),
        ("θ̇1 = (ẋ c12 + ẏ s12)/(l1 s2)", "l1", "l2"),
        (
            "J^{-1} = 1/(0.2 s2) [0.4 c12, 0.4 s12; -0.5 c1 - 0.4 c12, -0.5 s1 - 0.4 s12]",
            "-0.5 s1", "-0.4 s1",
        ),
    ],
)  # fmt: skip
def test_quotients_in_numbers(line: str, piece: str, other: str):
    arm = fb.planar("RR", l=[0.5, 0.4])
    assert fb.check(arm, line)
    assert not fb.check(arm, line.replace(piece, other))
