"""Forces at the tip in answers: τ = Jᵀ F, with weights and motion, in either sense."""

from __future__ import annotations

import pytest

import freebody as fb

ARM = fb.planar("RR")
BY_THE_TIP = "F is the force that the tip exerts on its surroundings."
ON_THE_TIP = "F is a force on the tip, from outside."
FIRST = "tau_1 = (-l1 s1 - l2 s12) Fx + (l1 c1 + l2 c12) Fy"
FORCE = "τ2 = -l2 s12 fx + l2 c12 fy"
LINES = [  # of a model a right line, and a piece of it whose sign is changed
    (ARM, FIRST, "(-l1 s1 - l2 s12)", "(-l1 s1 + l2 s12)"),
    (ARM, FIRST, "+ (l1 c1", "- (l1 c1"),
    (ARM, f"{FORCE} + M_z", "+ M_z", "- M_z"),
    (ARM, f"{FORCE} + m2 g lc2 c12", "+ m2", "- m2"),
    (ARM, "τ = g + Jᵀ F", "= g", "= -g"),
    (ARM, "τ = M q̈ + c + g + Jᵀ F", "+ c", "- c"),
    (ARM, r"\tau = J^T \begin{bmatrix} F_x \\ F_y \end{bmatrix}", r"\\ F_y", r"\\ -F_y"),
    (ARM, "τ2 = [-l2 s12, l2 c12] [Fx; Fy]", ", l2 c12", ", -l2 c12"),
    (fb.planar("RP"), "f2 = Fx c1 + Fy s1", "+ Fy", "- Fy"),
    (fb.planar("RRR"), "τ3 = -l3 s123 Fx + l3 c123 Fy", "+ l3", "- l3"),
]


@pytest.mark.sample(3)
@pytest.mark.parametrize(("model", "line", "piece", "other"), LINES)
def test_torques_that_hold_a_force(model, line: str, piece: str, other: str):
    assert BY_THE_TIP in fb.check(model, line).text
    assert piece in line
    verdict = fb.check(model, line.replace(piece, other, 1))
    assert not verdict
    assert "sign" in verdict.text


def test_the_force_of_either_sense_is_told():
    left, _, right = FIRST.partition("=")
    told = fb.check(ARM, f"{left} = -({right})")
    assert told
    assert ON_THE_TIP in told.text
    assert ON_THE_TIP in fb.check(ARM, "τ = -Jᵀ F").text
    assert ON_THE_TIP in fb.check(ARM, "τ = M q̈ + c + g - Jᵀ F").text


def test_the_force_in_a_joint_of_an_arm_at_rest_is_that_at_its_tip():
    """Where an answer tells of nothing that moves."""
    assert fb.check(ARM, "f_12x = -fx")
    assert not fb.check(ARM, "f_12x = fx")


def test_lines_of_one_answer_have_one_sense():
    verdict = fb.check(ARM, f"{FIRST}\ntau_2 = l2 s12 Fx - l2 c12 Fy")
    assert [x.equal for x in verdict.equations] == [True, False]
    assert verdict.causes == (
        "What has either sense, as a force at the tip, has another one here than in other lines.",
    )


def test_what_is_left_out_is_told():
    assert "The links' weights are left out." in fb.check(ARM, FIRST).text
    assert "left out" not in fb.check(ARM, "τ = g + Jᵀ F").text
    assert "It has no other component than x." in fb.check(ARM, "τ2 = -l2 s12 Fx").text
    assert not fb.check(ARM, f"{FIRST}\nτ2 = -l2 s12 Fx")


def test_forces_by_torques_and_the_transpose():
    assert fb.check(ARM, "F = J^{-T} τ")
    assert "This is Jᵀ τ" in fb.check(ARM, "F = Jᵀ τ").causes[0]
    assert "This is J F" in fb.check(ARM, "τ = J F").causes[0]


def test_absolute_angles():
    assert fb.check(ARM, "τ2 = -l2 s2 Fx + l2 c2 Fy", absolute=True)
    assert not fb.check(ARM, "τ2 = -l2 s12 Fx + l2 c12 Fy", absolute=True)


def test_the_notes_numbers():
    """(2.52): l1 = 3.5, l2 = 3, θ1 = θ2 = π/6, f = [-4.5, -3]."""
    arm = fb.planar("RR", l=[3.5, 3.0])
    line = "τ2 = -3 sin(θ1 + θ2) fx + 3 cos(θ1 + θ2) fy"
    assert fb.check(arm, line)
    assert not fb.check(arm, line.replace("+ 3", "- 3"))


CRANK = fb.load("slider_crank")
BAR = fb.load("four_bar")
WEIGHTS = "m1 g lc1 c1 + m2 g (l1 c1 - lc2 l1 c1/l2)"


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("model", "line", "notes"),
    [
        (CRANK, "τ1 = F l1 sin(θ2)/cos(θ1+θ2)", ["weights are left out"]),
        (CRANK, "τ1 = -F l1 sin(θ2)/cos(θ1+θ2)", ["from outside", "weights are left out"]),
        (CRANK, "τ1 = -F_x l1 (s1 - c1 tan(θ1+θ2))", ["weights are left out"]),
        (CRANK, f"τ1 = {WEIGHTS} + F l1 s2/c12", ["45 states"]),
        (CRANK, "τ1 θ̇1 = F ḋ3", ["weights are left out"]),
        (CRANK, "τ1 = F ḋ3/θ̇1", []),
        (CRANK, "τ1 θ̇1 = dT/dt + dV/dt + F ḋ3", ["45 states"]),
        (BAR, "τ1 = l1 s2 (F_y c3 - F_x s3)/sin(θ1+θ2-θ3)", ["weights are left out"]),
        (BAR, "τ1 = -F_y l1 s2 c3/sin(θ1+θ2-θ3)", ["from outside"]),
    ],
)
def test_a_drive_of_a_closed_chain_holds_a_force_on_its_slide_or_tip(model, line, notes):
    verdict = fb.check(model, line)
    assert verdict, verdict.text
    assert all(note in verdict.text for note in notes)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "line", "words"),
    [
        (CRANK, "τ1 = F l1 sin(θ1)/cos(θ1+θ2)", "must be sin θ₂"),
        (CRANK, "τ1 = F l2 sin(θ2)/cos(θ1+θ2)", "must be l₁"),
        (CRANK, "τ1 = F θ̇2/θ̇1", "must be ḋ₃"),
        (CRANK, f"τ1 = {WEIGHTS.replace('-', '+')} + F l1 s2/c12", "wrong sign"),
        (CRANK, "τ1 θ̇1 = dT/dt + F ḋ3", "is not right"),
        (BAR, "τ1 = l1 s2 (F_y c3 + F_x s3)/sin(θ1+θ2-θ3)", "wrong sign"),
        (CRANK, "τ1 = F l1 s2/c12\nτ1 = -F l1 s2/c12", "is not right"),
    ],
)
def test_what_does_not_hold_it_is_wrong(model, line, words):
    verdict = fb.check(model, line)
    assert not verdict
    assert words in verdict.text


def test_of_a_closed_chain_under_a_force_only_torques_are_read():
    with pytest.raises(fb.FreebodyError, match="only torques are read under a force"):
        fb.check(BAR, "0 = (I3 + m3 lc3²) θ̈3 + m3 g lc3 c3 + λ1 l3 s3 - λ2 l3 c3 + F_x")
