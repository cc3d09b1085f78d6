"""`fb.check` reads the lines that freebody's own derivations print, and finds them right; with one
of the usual mistakes they are refused, with the reason."""

from __future__ import annotations

import re
import time

import pytest

import freebody as fb
from support.own_lines import own_lines

SHORT = [("2R", "kane"), ("RP", "statics"), ("elbow_arm", "lagrange")]
ARMS = (
    "2R", "RP", "acrobot", "cart_pole", "cylindrical_arm", "elbow_arm", "furuta", "pendulum",
    "scara",
)  # fmt: skip
OPEN = (
    "newton-euler",
    "recursive",
    "lagrange",
    "lagrange-first-kind",
    "kane",
    "kinematics",
    "statics",
)
CLOSED = ("newton-euler", "lagrange-first-kind", "kinematics")
LONG = [
    *(
        (robot, method)
        for robot in ARMS
        for method in OPEN
        if (robot, method) != ("cart_pole", "statics")
    ),
    *((robot, method) for robot in ("four_bar", "five_bar", "slider_crank") for method in CLOSED),
]
# Another name of the torques, of one coordinate or of J⁻¹, freedoms counted, the load's part of the
# torques, matrices of matrices, sin² + cos² = 1, the tangent or a length of a singular pose.
NOT_READ = re.compile(
    r"Q = |f = n|τ_f = |\\boldsymbol\{\\tau\}_f = |\[M, Φ|\\begin\{bmatrix\} M "
    r"|q̇? = \[θ̇?₁\]ᵀ|(?:q|\\dot\{\\mathbf\{q\}\}) = \\begin\{bmatrix\} \S{1,20} \\end"
    r"|J⁻¹ = K|J\^\{-1\} = K|K = |sin² θ₂ = 1|\\sin\^2 \\theta_2 = 1"
    r"|tan θ₂ = |\\tan \\theta_2 = |d₂ = −l₂|d_2 = -l_2"
)
"""Lines of which nothing can be checked, or that are not read."""


def holds(robot: str, method: str, latex: bool) -> None:
    model = fb.load(robot)
    lines = own_lines(model, fb.derive(model, method), latex)
    others = [x for x in lines if x.kind not in ("right", "name")]
    assert [x for x in others if not NOT_READ.match(x.text)] == []
    assert {x.kind for x in others} <= {"unread", "unused"}
    assert len(others) <= 0.2 * len(lines)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "method"), SHORT)
def test_its_own_lines_are_read_and_right(robot: str, method: str):
    holds(robot, method, latex=False)


@pytest.mark.long
@pytest.mark.parametrize("latex", [False, True], ids=["text", "latex"])
@pytest.mark.parametrize(("robot", "method"), LONG)
def test_the_lines_of_all_methods_are_read_and_right(robot: str, method: str, latex: bool):
    holds(robot, method, latex)


def quick(rows: list[tuple[str, ...]]) -> list[object]:
    """Those of longer closed chains apart."""
    slow = pytest.mark.long
    return [pytest.param(*x, marks=[slow] * (x[0] == "five_bar"), id=x[1]) for x in rows]


PARTIAL = "vc21 = [-l1 s1 - lc2 s12; l1 c1 + lc2 c12]"
BOTH = (
    "J_a = [cos(θ1+θ3), sin(θ1+θ3); cos(θ2+θ4), sin(θ2+θ4)]; J_b = [-l1 sin θ3, 0; 0, -l2 sin θ4]"
)
WRONG = [
    ("2R", "v_{c2,1} = [-lc2 s12; lc2 c12]", "This is the factor of joint 2's rate."),
    ("2R", PARTIAL.replace("l1 c1 +", "l1 c1 -"), "has the wrong sign"),
    ("2R", PARTIAL.replace("- lc2 s12", "- lc2 c12"), "must be sin(θ₁+θ₂)"),
    ("2R", PARTIAL.replace("-l1 s1", ""), "−l₁ sin θ₁’ is missing"),
    ("2R", "∂v_c2/∂q̇_1 = [-lc2 s12; lc2 c12]", "‘−l₁ sin θ₁’ is missing"),
    ("2R", "F_1^* = fc1·vc11 + nc1 ω11 + fc2·vc21 + nc2 ω21", "The inertia force is the opposite"),
    ("2R", "F_1 = m1 g·vc11 + m2 g·vc21", "The torque or force of the drive is missing."),
    ("2R", "F_2 = τ2 + m2 g lc2 c12; F_2 + F_2* = 0", "The weights have the wrong sign."),
    ("2R", "F₁ − F₁* = 0", "‘− F₁*’ has the wrong sign"),
    ("cylindrical_arm", "f12 = f23 + m2 v̇c2 + m2 g", "‘m2 g’ has the wrong sign"),
    ("slider_crank", "J_a = [cos θ2]; J_b = [l1 sin θ2]", "is not right"),
    ("five_bar", f"{BOTH}; J_a ẋ = J_b θ̇", "has the wrong sign: it must be l₁ sin θ₃"),
    ("five_bar", f"J_a ẋ + J_b θ̇ = 0; {BOTH.replace('l1 sin θ3', 'l1 cos θ3')}", "must be sin θ₃"),
    ("five_bar", BOTH.replace("a =", "b =", 1).replace("; J_b", "; J_a"), "the other matrix"),
    ("five_bar", "J_a = [cos(θ1+θ3), cos(θ2+θ4); sin(θ1+θ3), sin(θ2+θ4)]", "of the transpose"),
    ("five_bar", "J_a ẋ − J_b θ̇ = 0; J_a ẋ + J_b θ̇ = 0", "is not right"),
    ("four_bar", "N = [1; -(l1 sin(θ1-θ3))/(l2 sin(θ1+θ2-θ3)); (l1 s2)/(l3 sin(θ1+θ2-θ3))]", "N"),
    ("four_bar", "q̈ = N ü − γ", "‘− γ’ has the wrong sign"),
    (
        "four_bar",
        "γ₃ = ((l₂ + l₁ cos θ₂) θ̇₁² − l₂ θ̇₂² + l₃ cos(θ₁+θ₂−θ₃) θ̇₃² − 2 l₂ θ̇₁ θ̇₂)"
        "/(l₃ sin(θ₁+θ₂−θ₃))",
        "θ̇₁²’ has the wrong sign",
    ),
    ("four_bar", "Φ_q q̈ = Φ̇_q q̇", "is not right"),
    ("five_bar", "det J_a = -sin(θ1-θ2+θ3-θ4)\nθ₁ − θ₂ + θ₃ − θ₄ = π/2", "There det J is not 0"),
    ("2R", "f₁₂ + m₂ g + f = 0; f₀₁ = f₁₂ + m₁ g", "‘m₁ g’ has the wrong sign"),
    ("2R", "f₁₂ + m₂ g − f = 0; τ₂ = −sc₂ × m₂ g − s₂ × f", "‘− f’ has the wrong sign"),
    ("2R", "f₁₂ + m₂ g + f = 0; τ₂ = −sc₂ × m₂ g + s₂ × f", "has the wrong sign"),
    ("2R", "f₁₂ + m₂ g = 0", "is not right"),
    ("elbow_arm", "T₂ = ½ m₂ vc₂² − ½ ω₂ · I₂ ω₂", "has the wrong sign"),
    ("elbow_arm", "ω₂ = ω₁ − θ̇₂ z₂", "has the wrong sign"),
    ("elbow_arm", "R_0^1 = [cos θ₁, −sin θ₁, 0; sin θ₁, cos θ₁, 0; 0, 0, 1]", "its transpose"),
]


@pytest.mark.sample(5)
@pytest.mark.parametrize(("robot", "line", "reason"), quick(WRONG))
def test_a_mistake_in_such_a_line_is_refused_with_the_reason(robot: str, line: str, reason: str):
    verdict = fb.check(fb.load(robot), line)
    assert not verdict
    assert reason in verdict.text


RIGHT = [
    ("2R", "f₁₂ + m₂ g + f = 0; τ₂ = −sc₂ × m₂ g − s₂ × f; f₀₁ − f₁₂ + m₁ g = 0"),
    ("elbow_arm", "T₂ = ½ m₂ vc₂² + ½ ω₂ · I₂ ω₂; ω₂ = ω₁ + θ̇₂ z₂; ω₂ = R₁² ω₁ + θ̇₂ z₂"),
    ("five_bar", BOTH),
    ("five_bar", f"{BOTH.replace('-l', 'l')}; J_a ẋ = J_b θ̇"),
    ("five_bar", BOTH.replace("J_a", "J_x").replace("J_b", "J_q")),
    ("five_bar", "A ẋ = B q̇; A = [x + b - l1 c1, y - l1 s1; x - b - l2 c2, y - l2 s2]; "
     "B = [l1 l3 s3, 0; 0, l2 l4 sin θ4]"),
    ("four_bar", "Φ_q N = 0; q̈ = N ü + γ; Nᵀ M N ü = Nᵀ (n − M γ)"),
    ("four_bar", "M q̈ + Φ_qᵀ λ = n; Φ_q q̈ = −Φ̇_q q̇ = c; dΦ/dt = Φ_q q̇ = 0"),
]  # fmt: skip


@pytest.mark.parametrize(("robot", "line"), quick(RIGHT))
def test_such_lines_may_be_written_otherwise(robot: str, line: str):
    verdict = fb.check(fb.load(robot), line)
    assert verdict, verdict


def test_a_row_of_one_matrix_alone_is_not_judged():
    """J_a ẋ + J_b θ̇ = 0 may be multiplied by any factor."""
    with pytest.raises(fb.FreebodyError, match="Give both matrices"):
        fb.check(fb.load("five_bar"), "J_b = [cos θ3, 0; 0, l2 sin θ4]")


def test_a_row_times_what_loops_make_0_is_refused():
    """Any matrices would be right."""
    gap = "(l1 sin θ1 + l3 sin(θ1+θ3) - l2 sin θ2 - l4 sin(θ2+θ4))"
    assert not fb.check(
        fb.load("five_bar"), f"J_a = {gap} [1, 1; 1, 1]; J_b = {gap} [1, 0; 0, 1]; J_a ẋ = J_b θ̇"
    )


@pytest.mark.parametrize(
    ("robot", "line"),
    [("four_bar", "q̈ - q̈ = 0"), ("four_bar", "0 Φ_q = 0"), ("2R", "f12 - f12 = 0")],
)
def test_vectors_of_which_nothing_is_said_are_not_right(robot: str, line: str):
    with pytest.raises(fb.FreebodyError, match="both sides are the same"):
        fb.check(fb.load(robot), line)


def test_a_wrong_equation_of_long_matrices_is_refused_soon():
    begun = time.process_time()
    assert not fb.check(fb.load("four_bar"), "Nᵀ M N ü = Nᵀ (n + M γ)")
    assert time.process_time() - begun < 5.0


def test_a_matrix_that_has_no_inverse_is_said_to_have_none():
    with pytest.raises(fb.FreebodyError, match="has no inverse"):
        fb.check(fb.load("reaction_wheel"), "q̇ = J⁻¹ ṙ_P")


def test_names_of_kanes_equations_are_ones_own_where_nothing_else_is_of_these():
    own = "ω21 = θ̇2; F1 = m1 g; ω2 = θ̇1 + ω21; G1 = F1 lc1 c1 + G2 + m2 g l1 c1"
    verdict = fb.check(fb.load("2R"), own)
    assert verdict, verdict


def test_derivatives_by_all_coordinates_are_vectors_and_matrices():
    arm = fb.load("2R")
    assert fb.check(arm, "∂V/∂q = [G1; G2]")
    assert fb.check(arm, "∂v_c2/∂q̇ = [-l1 s1 - lc2 s12, -lc2 s12; l1 c1 + lc2 c12, lc2 c12]")
    assert not fb.check(arm, "∂V/∂q = [G2; G1]")


@pytest.mark.parametrize(
    "options",
    [
        {"names": {"a": None}},
        {"names": {5: "m1"}},
        {"names": "a=b"},
        {"at": 5},
        {"tolerance": "little"},
    ],
)
def test_an_option_of_another_type_is_refused_with_its_name(options):
    (name,) = options
    with pytest.raises(fb.AnswerError, match=name):
        fb.check(fb.load("2R"), "H22 = m2 lc2^2 + I2", **options)


def test_a_name_may_stand_for_a_number():
    assert fb.check(fb.load("2R"), "H22 = a*m2*lc2^2 + a*I2", names={"a": 1})
    assert not fb.check(fb.load("2R"), "H22 = a*m2*lc2^2 + a*I2", names={"a": 1.5})
