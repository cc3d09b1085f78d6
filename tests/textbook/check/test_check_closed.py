"""Answers about closed chains: loop equations, Φ_q, equations with multipliers; and branched
robots."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb

BAR = fb.load("four_bar")

RIGHT = [
    "Φ1 = l1 c1 + l2 c12 - d - l3 c3 = 0",
    "l1 c1 + l2 c12 = d + l3 c3; l1 s1 + l2 s12 - l3 s3 = 0",
    r"\Phi_q = \begin{bmatrix} -l_1 s_1 - l_2 s_{12} & -l_2 s_{12} & l_3 s_3 \\"
    r" l_1 c_1 + l_2 c_{12} & l_2 c_{12} & -l_3 c_3 \end{bmatrix}",
    "0 = (m3 lc3² + I3) θ̈3 + m3 g lc3 c3 + l3 s3 λ1 - l3 c3 λ2",
    "(m3 lc3² + I3) θ̈3 + m3 g lc3 c3 = -l3 s3 λ1 + l3 c3 λ2",
    "τ1 = H11 θ̈1 + H12 θ̈2 - h θ̇2² - 2 h θ̇1 θ̇2 + G1 + ∂Φ1/∂θ1 λ1 + ∂Φ2/∂θ1 λ2\nh = m2 l1 lc2 s2",
    "d/dt (∂L/∂θ̇1) - ∂L/∂θ1 + ∂Φ1/∂θ1 λ1 + ∂Φ2/∂θ1 λ2 = τ1",
    "vc3 = [-lc3 θ̇3 s3; lc3 θ̇3 c3]",
    "T3 = ½ (m3 lc3² + I3) ω3²",
    "gamma2 = (l1 s1 + l2 s12) θ̇1² + l2 s12 θ̇2² - l3 s3 θ̇3² + 2 l2 s12 θ̇1 θ̇2",
]


@pytest.mark.parametrize("answer", RIGHT)
def test_lines_about_a_closed_chain_are_right(answer: str):
    assert fb.check(BAR, answer), answer


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("Φ1 = l1 c1 + l2 c12 - d + l3 c3 = 0", "‘l3 c3’ has the wrong sign"),
        ("l1 c1 + l2 c12 = d - l3 c3", "the loop equation of 'closing_pin' along x, is not right"),
        ("l1 s1 + l2 s2 - l3 s3 = 0", "of 'closing_pin' along y"),
        ("0 = (m3 lc3² + I3) θ̈3 + m3 g lc3 c3 - l3 s3 λ1 - l3 c3 λ2",
         "equation of joint 3, which nothing drives, is not right.\n  ‘- l3 s3 λ1’ has the wrong"),
        ("d/dt (∂L/∂θ̇1) - ∂L/∂θ1 - ∂Φ1/∂θ1 λ1 + ∂Φ2/∂θ1 λ2 = τ1", "‘- ∂Φ1/∂θ1 λ1’ has the wrong"),
        ("τ1 = H11 θ̈1 + H12 θ̈2 + v1 + G1", "The forces of the loops are missing."),
        ("T3 = ½ (m3 lc3² + I3) (θ̇1 + θ̇2 + θ̇3)²", "T3, the kinetic energy of body 3, is not"),
        ("c1 = 0", "row 1 of Φ_q q̈"),
    ],
)  # fmt: skip
def test_mistakes_about_a_closed_chain_are_named(answer: str, words: str):
    verdict = fb.check(BAR, answer)
    assert not verdict
    assert words in verdict.text


def test_a_derivation_of_a_closed_chain_is_an_answer():
    """What is not read is told, the matrix of matrices; nothing is called wrong."""
    derivation = fb.derive(BAR, "lagrange-first-kind")
    lines = [str(equation) for step in derivation.steps for equation in step.equations]
    verdict = fb.check(BAR, "\n\n".join(lines), form="markdown")
    assert len(verdict.equations) > 95
    assert all(equation.equal for equation in verdict.equations), verdict
    assert not verdict
    assert [x.text for x in verdict.left_out] == ["[M, Φ_qᵀ; Φ_q, 0] [q̈, λ]ᵀ = [n, c]ᵀ"]


def test_a_name_whose_own_line_cannot_be_read_leaves_others_unread():
    text = "K2 = l1^l2\n\nH22 = K2 + 0\n\nH11 = H11 + H12 - H12 + 0*K2"
    verdict = fb.check(fb.planar("RR"), text + "\n\nG2 = m2 g lc2 c12", form="markdown")
    assert [equation.name for equation in verdict.equations] == ["G2"]
    assert not verdict


def test_angular_velocities_of_a_branched_robot_go_along_its_own_branch():
    """Body 3 hangs on the ground; in absolute angles each link's own rate is its angular
    velocity."""
    assert fb.check(BAR.opened, "T3 = ½ (m3 lc3² + I3) ω3²")
    assert not fb.check(BAR.opened, "T3 = ½ (m3 lc3² + I3) (θ̇1 + θ̇2 + θ̇3)²")
    arm = fb.planar("RR")
    assert fb.check(arm, "T2 = ½ m2 vc2² + ½ I2 ω2²; ω2 = θ̇2", absolute=True)
    assert not fb.check(arm, "ω2 = θ̇1 + θ̇2", absolute=True)


def test_forces_in_joints_hold_what_loops_transmit():
    """f12 of the tree that is left when a loop is cut would lack it."""
    assert fb.check(BAR, "f12 = m2 (v̇c2 − g) − f32; f32 = [−λ1; −λ2]")
    assert not fb.check(BAR, "f12 = m2 (v̇c2 − g)")
    assert not fb.check(BAR, "f12 = m2 (v̇c2 − g) + f32")


FIVE_BAR = fb.load("five_bar")


@pytest.mark.parametrize(
    "answer",
    [
        "x = b + l2 cos θ2 + l4 cos(θ2+θ4)",
        "r = [b + l2 c2 + l4 cos(θ2+θ4); l2 s2 + l4 sin(θ2+θ4)]",
        "(x + b - l1 cos θ1)^2 + (y - l1 sin θ1)^2 = l3^2",
        "(x - b - l2 cos θ2)^2 + (y - l2 sin θ2)^2 = l4^2",
    ],
)
def test_the_tip_of_a_closed_chain_is_reached_along_every_leg(answer: str):
    assert fb.check(FIVE_BAR, answer)
    assert fb.check(FIVE_BAR, [answer, "x = -b + l1 c1 + l3 cos(θ1+θ3)"])


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "answer",
    [
        "x = -b + l2 cos θ2 + l4 cos(θ2+θ4)",
        "y = l2 sin θ2 - l4 sin(θ2+θ4)",
        "(x - b - l1 cos θ1)^2 + (y - l1 sin θ1)^2 = l3^2",
        "(x - b - l2 cos θ2)^2 + (y - l2 sin θ2)^2 = l3^2",
        "(x - b - l2 cos θ2)^2 + (y + l2 sin θ2)^2 = l4^2",
        "x + y = 2 b",
    ],
)
def test_a_wrong_way_along_a_leg_is_not_right(answer: str):
    assert not fb.check(FIVE_BAR, answer)


IN_EQUILIBRIUM = [
    ("2R", "f12 + m2 g = 0", "f12 - m2 g = 0"),
    ("2R", "τ2 = m2 g lc2 cos(θ1+θ2)", "τ2 = -m2 g lc2 cos(θ1+θ2)"),
    ("four_bar", "f01 - f12 + m1 g = 0", "f01 - f12 - m1 g = 0"),
    ("four_bar", "τ1 - s1 × f12 + sc1 × m1 g = 0", "τ1 - s1 × f12 - sc1 × m1 g = 0"),
    ("four_bar", "f03 = [-λ1, m3 g - λ2]", "f03 = [-λ1, m3 g + λ2]"),
]


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "line", "wrong"), IN_EQUILIBRIUM)
def test_statics_is_right_in_equilibrium_only_and_a_wrong_sign_nowhere(robot, line, wrong):
    model, still = fb.load(robot), "It is right where nothing moves: write ‘In equilibrium:’"
    for said in (
        f"In equilibrium: {line}",
        f"{line} in static equilibrium",
        f"Held still:\n{line}",
    ):
        assert fb.check(model, said)
    verdict = fb.check(model, line)
    assert not verdict
    assert still in verdict.text
    for said in (wrong, f"In equilibrium: {wrong}"):
        verdict = fb.check(model, said)
        assert not verdict
        assert still not in verdict.equations[-1].text


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["2R", "four_bar"])
def test_equilibrium_tells_nothing_of_what_stands_at_an_acceleration(name: str):
    model = fb.load(name)
    assert fb.check(model, "In equilibrium: f01 - f12 + m1 g = m1 v̇c1")
    for wrong in ("f01 - f12 + m1 g = 5 m1 v̇c1", "τ1 = s1 × f12 - sc1 × m1 g + 3 θ̈1"):
        assert not fb.check(model, f"In equilibrium: {wrong}")


CRANK, TWO_BARS = fb.load("slider_crank"), fb.load("double_four_bar")
ROCKER = (
    "f = l1² + l3² + d² - l2² - 2 l1 d c1\na = 2 l3 (d - l1 c1)\nb = -2 l1 l3 s1\n"
    "θ3 = atan2(b, a) {} arccos(-f/sqrt(a² + b²))"
)
BY_THE_LOOPS = [
    (CRANK, "T3 = ½ m3 (l1 s1 θ̇1 + l2 s12 (θ̇1+θ̇2))²"),
    (CRANK, "V = m1 g lc1 s1 + m2 g (l1 - lc2 l1/l2) s1"),
    (CRANK, "V = m1 g lc1 s1 + m2 g (l1 - lc2 l1/l2) s1 + 5 m1 g lc1"),
    (CRANK, "d/dt(T + V) = τ1 θ̇1"),
    (CRANK, "P = τ1 θ̇1"),
    (CRANK, "d3 = l1 cos θ1 + sqrt(l2² - l1² sin²θ1)"),
    (CRANK, "x = l1 c1 + l2 sqrt(1 - (l1 s1/l2)²)"),
    (CRANK, "ḋ3 = -l1 s1 θ̇1 - l1² s1 c1 θ̇1/sqrt(l2² - l1² s1²)"),
    (CRANK, "θ2 = -θ1 - arcsin(l1 s1/l2)"),
    (CRANK, "θ1 = arccos((d3² + l1² - l2²)/(2 l1 d3))"),
    (CRANK, "ω2 = -l1 c1 θ̇1/(l2 c12)"),
    (CRANK, "λ1 = m3 d̈3"),
    (
        CRANK,
        "τ1 θ̇1 = (m1 lc1² + I1) θ̈1 θ̇1 + m1 g lc1 c1 θ̇1 + m2 (vc2x v̇c2x + vc2y v̇c2y)"
        " + m2 g vc2y + I2 ω2 ω̇2 + m3 ḋ3 d̈3",
    ),
    (BAR, "V3 = m3 g (lc3/l3) (l1 s1 + l2 s12)"),
    (BAR, "ω3 = l1 sin θ2 θ̇1/(l3 sin(θ1+θ2-θ3))"),
    (BAR, "l2² = (d + l3 c3 - l1 c1)² + (l3 s3 - l1 s1)²"),
    (BAR, "θ3 = atan2(l1 s1 + l2 s12, l1 c1 + l2 c12 - d)"),
    (BAR, ROCKER.format("+")),
    (
        BAR,
        "K1 = d/l1\nK2 = d/l3\nK3 = (l1² - l2² + l3² + d²)/(2 l1 l3)\n"
        "K1 cos θ3 - K2 cos θ1 + K3 = cos(θ1 - θ3)",
    ),
    (BAR, "k = sqrt((d - l1 c1)² + (l1 s1)²)\ncos(θ1+θ2-θ3) = (l2² + l3² - k²)/(2 l2 l3)"),
    (TWO_BARS, "θ̇1 = θ̇3"),
    (TWO_BARS, "θ3 = θ1"),
    (FIVE_BAR, "x = (l1 c1 + l2 c2 + l3 cos(θ1+θ3) + l4 cos(θ2+θ4))/2"),
]


@pytest.mark.sample(3)
@pytest.mark.parametrize(("model", "line"), BY_THE_LOOPS)
def test_what_the_loops_make_right_is_right(model: fb.Model, line: str):
    assert fb.check(model, line)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("model", "line", "words"),
    [
        (CRANK, "T3 = ½ m3 (l1 s1 θ̇1 + l2 s12 θ̇2)²", "is not right"),
        (CRANK, "V = m1 g lc1 s1 + m2 g (l1 - lc2) s1", "is not right"),
        (CRANK, "d3 = l1 cos θ1 + sqrt(l2² + l1² sin²θ1)", "‘l1² sin²θ1’ has the wrong sign"),
        (CRANK, "d3 = l1 cos θ1 - sqrt(l2² - l1² sin²θ1)", "another assembly"),
        (BAR, ROCKER.format("-"), "another assembly"),
        (CRANK, "λ1 = -m3 d̈3", "has the wrong sign"),
        (BAR, "ω3 = l1 sin θ2 θ̇1/(l3 sin(θ1+θ2+θ3))", "must be"),
        (BAR, "V3 = m3 g (lc3/l2) (l1 s1 + l2 s12)", "is not right"),
        (TWO_BARS, "θ̇1 = -θ̇3", "is not right"),
    ],
)
def test_what_the_loops_do_not_make_right_is_wrong(model: fb.Model, line: str, words: str):
    verdict = fb.check(model, line)
    assert not verdict
    assert words in verdict.text


def test_an_example_is_a_state_that_closes_the_loops():
    for line in (ROCKER.format("-"), "θ̇3 = l1 l2 sin θ2 θ̇1/(d l3 sin(θ1+θ3))"):
        at = fb.check(BAR, line).equations[0].example.values
        crank, rocker = (at[f"l{k}"] * np.exp(1j * at[f"theta{k}"]) for k in (1, 3))
        assert abs(at["d"] + rocker - crank) == pytest.approx(at["l2"], abs=2e-3)


def test_numbers_of_a_closed_chain_follow_from_its_loops_and_nothing_is_taken_for_zero():
    assert fb.check(CRANK, "d3 = 0.739 m at θ1 = 40°")
    assert not fb.check(CRANK, "d3 = 0.75 m at θ1 = 40°")
    assert fb.check(CRANK, "At θ₁ = 30°:\nd3 = 0.76481 m")
    for line in ("τ1 = 3 N m at θ1 = 40°", "d̈3 = 1 m/s² at θ1 = 40°, θ̇1 = 2 rad/s"):
        with pytest.raises(fb.FreebodyError, match="not given"):
            fb.check(CRANK, line)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "line", ["v_3x = ḋ3", "v_3 = [ḋ3; 0]", "T3 = m3 v_3²/2", "v_2y = l1 ω1 cos θ1"]
)
def test_velocities_of_joints_are_known_in_closed_chains(line: str):
    assert fb.check(fb.load("slider_crank"), line)
    assert not fb.check(fb.load("slider_crank"), line.replace("= ", "= 2 "))


def test_c_is_the_rest_of_a_loop_equation_or_a_velocity_term_as_its_value_tells():
    assert fb.check(BAR, "c1 = l1 c1 θ̇1² + l2 c12 (θ̇1+θ̇2)² - l3 c3 θ̇3²")
    term = "m2 l1 lc2 s2 (2 θ̇1 θ̇2 + θ̇2²)"
    verdict = fb.check(BAR, f"c1 = -{term}")
    assert verdict
    assert "the velocity term of joint 1" in verdict.text
    verdict = fb.check(BAR, f"c1 = {term}")
    assert not verdict
    assert "is read as the velocity term of joint 1" in verdict.text
