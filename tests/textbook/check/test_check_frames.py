"""Vectors in the axes of any body, as Craig writes them, {}^1v_2: right there, wrong in others."""

from __future__ import annotations

import pytest

import freebody as fb

ARM = fb.planar("RR")
ELBOW = fb.load("elbow_arm")
FALLING = r"{}^0\dot v_0 = [0; g; 0]"

PLANAR = [
    (r"{}^0P_{C_2} = [l1 c1 + lc2 c12; l1 s1 + lc2 s12; 0]", "c12", "c2"),
    (r"{}^1P_{C_2} = [l1 + lc2 c2; lc2 s2; 0]", "s2", "s12"),
    (r"{}^2P_{C_2} = [lc2; 0]", "lc2", "l2"),
    (r"{}^1P_2 = [l1; 0; 0]", "l1", "l2"),
    (r"{}^2\omega_2 = \dot\theta_1 + \dot\theta_2", "+", "-"),
    (r"{}^{2}\omega_{2} = \begin{bmatrix} 0 \\ 0 \\ \dot\theta_1 + \dot\theta_2 \end{bmatrix}",
     "0 ", "1 "),
    ("²ω₂ = θ̇₁ + θ̇₂", "+", "-"),
    (r"{}^2v_2 = [l1 s2 \dot\theta_1; l1 c2 \dot\theta_1; 0]", "s2", "s1"),
    (r"{}^0v_2 = [-l1 s1 \dot\theta_1; l1 c1 \dot\theta_1; 0]", "s1", "s2"),
    (FALLING + "\n" + r"{}^1\dot v_{C_1} = [g s1 - l_{c1} θ̇1²; l_{c1} \ddot\theta_1 + g c1; 0]",
     "g s1 ", "g c1 "),
    (FALLING + "\n" + r"{}^2f_2 = {}^2F_2", "f_2", "f_1"),
    (r"{}^2F_2 = m2 {}^2\dot v_{C_2}", "F_2 = m2", "F_2 = m1"),
    (r"{}^1f_2 = {}^1F_2 - m_2 [-g s1; -g c1]", "s1", "s12"),
    (r"{}^2N_2 = [0; 0; I2 (\ddot\theta_1 + \ddot\theta_2)]", "I2", "I1"),
    (r"{}^2n_2 = [0; 0; τ2]", "τ2", "τ1"),
]  # fmt: skip


@pytest.mark.sample(3)
@pytest.mark.parametrize(("answer", "old", "new"), PLANAR)
def test_vectors_of_a_planar_arm_are_compared_in_their_frame(answer: str, old: str, new: str):
    assert fb.check(ARM, answer, notation="craig"), answer
    assert not fb.check(ARM, answer.replace(old, new, 1), notation="craig")


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "answer",
    [
        r"{}^0\omega_2 = {}^0_2R {}^2\omega_2",
        r"{}^1v_3 = {}^1_2R{}^2v_3",
        r"{}^0P_{C_2} = {}^0P_2 + {}^0_2R {}^2P_{C_2}",
        r"{}^1P_3 = {}^1P_2 + {}^1_2R {}^2P_3",
        r"{}^1f_2 = {}^1_2R f_12",
        r"{}^1\dot\omega_2 = {}^1_2R {}^2\dot\omega_2",
    ],
)
def test_rotations_lead_from_frame_to_frame(answer: str):
    assert fb.check(ELBOW, answer), answer
    frames = {"0_2R": "2_0R", "1_2R": "2_1R"}
    old = next(x for x in frames if x in answer)
    assert not fb.check(ELBOW, answer.replace(old, frames[old]))


@pytest.mark.parametrize(
    "answer",
    [
        r"{}^0\omega_2 = {}^2\omega_2",
        r"{}^2v_{C_2} = {}^0v_{C_2}",
        r"{}^2\omega_2 = {}^1\omega_1 + \dot\theta_2 z_2",
    ],
)
def test_without_rotations_components_in_two_frames_differ(answer: str):
    """Relations between vectors need no axes, but not where the answer names two."""
    assert not fb.check(ELBOW, answer)
    assert fb.check(ELBOW, r"\omega_2 = \omega_1 + \dot\theta_2 z_2")


def test_the_worlds_axes_are_named_where_a_frame_is_asked():
    verdict = fb.check(ARM, r"{}^2v_2 = [-l1 s1 \dot\theta_1; l1 c1 \dot\theta_1; 0]")
    assert (
        "right in the world's axes; here the components are along those of body 2" in verdict.text
    )


def test_a_power_behind_empty_braces_is_no_frame():
    for square in (
        r"\dot\theta_1{}^2 l_{c2}",
        r"{\dot\theta_1}{}^2 l_{c2}",
        r"l_{c2} \dot\theta_1 ^2",
    ):
        answer = rf"$v_2 = m_2 l_1 {square} \sin\theta_2$"
        assert fb.check(ARM, answer, form="latex"), answer
