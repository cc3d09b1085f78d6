"""`fb.check` reads the lines that freebody's own derivations print, and finds them right; with one
of the usual mistakes they are refused, with the reason."""

from __future__ import annotations

import pytest

import freebody as fb
from support.own_lines import own_lines

SHORT = [("2R", "kane"), ("cart_pole", "kane"), ("cylindrical_arm", "newton-euler")]


@pytest.mark.parametrize("latex", [False, True], ids=["text", "latex"])
@pytest.mark.parametrize(("robot", "method"), SHORT)
def test_its_own_lines_are_read_and_right(robot: str, method: str, latex: bool):
    model = fb.load(robot)
    lines = own_lines(model, fb.derive(model, method), latex)
    assert [x for x in lines if x.kind not in ("right", "name")] == []


PARTIAL = "vc21 = [-l1 s1 - lc2 s12; l1 c1 + lc2 c12]"
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
    ("elbow_arm", "R_0^1 = [cos θ₁, −sin θ₁, 0; sin θ₁, cos θ₁, 0; 0, 0, 1]", "its transpose"),
]


@pytest.mark.parametrize(("robot", "line", "reason"), WRONG, ids=[x[1] for x in WRONG])
def test_a_mistake_in_such_a_line_is_refused_with_the_reason(robot: str, line: str, reason: str):
    verdict = fb.check(fb.load(robot), line)
    assert not verdict
    assert reason in verdict.text


def test_names_of_kanes_equations_are_ones_own_where_nothing_else_is_of_these():
    own = "ω21 = θ̇2; F1 = m1 g; ω2 = θ̇1 + ω21; G1 = F1 lc1 c1 + G2 + m2 g l1 c1"
    verdict = fb.check(fb.load("2R"), own)
    assert verdict, verdict


def test_derivatives_by_all_coordinates_are_vectors_and_matrices():
    arm = fb.load("2R")
    assert fb.check(arm, "∂V/∂q = [G1; G2]")
    assert fb.check(arm, "∂v_c2/∂q̇ = [-l1 s1 - lc2 s12, -lc2 s12; l1 c1 + lc2 c12, lc2 c12]")
    assert not fb.check(arm, "∂V/∂q = [G2; G1]")
