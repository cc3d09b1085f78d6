"""Sums over bodies in answers, with bounds and without."""

from __future__ import annotations

import pytest

import freebody as fb

RIGHT = [
    ("2R", r"V = \sum_{i=1}^{2} m_i g y_{ci}"),
    ("2R", r"V = \sum\limits_{i=1}^2 m_i g y_{ci}"),
    ("2R", "V = ∑_{k=1}^2 m_k g y_ck"),
    ("2R", "V = g Σ m_i y_ci"),
    ("2R", "V = sum(m_i*g*y_ci)"),
    ("2R", "T = Σ ½ m_i v_ci² + ½ I_i ω_i²"),
    ("2R", "T = Σ ½ m_i v_ci² + Σ ½ I_i ω_i²"),
    ("2R", "T = Σᵢ ½ mᵢ vcᵢ² + ½ Iᵢ ωᵢ²"),
    ("2R", "T = sum(m_i*v_ci**2/2 + I_i*omega_i**2/2, i=1..2)"),
    ("2R", "T = Sum(m_i*v_ci**2/2 + I_i*omega_i**2/2, (i, 1, 2))"),
    ("2R", r"T = \sum_{i=1}^{n} \left( \frac12 m_i v_{ci}^2 + \frac12 I_i \omega_i^2\right)"),
    ("2R", r"T = \frac12 \sum_{i} \sum_{j} H_{ij} \dot\theta_i \dot\theta_j"),
    ("2R", "L = Σ (T_i - V_i)"),
    ("2R", "L = Σ T_i - Σ V_i"),
    ("3R", "V = m1 g lc1 s1 + Σ_{i=2}^{3} m_i g y_ci"),
    ("3R", "V = Σ_{i=2}^{3} m_i g y_ci + m1 g lc1 s1"),
    ("four_bar", "T = Σ ½ m_i v_ci² + ½ I_i ω_i²"),
    ("panda", "T = Σ T_i"),
]

WRONG = [
    ("2R", "V = Σ m_i g x_ci"),
    ("2R", "V = -Σ m_i g y_ci"),
    ("2R", r"V = \sum_{i=1}^{1} m_i g y_{ci}"),
    ("2R", "T = Σ ½ m_i v_ci² - ½ I_i ω_i²"),
    ("2R", "T = Σ m_i v_ci² + ½ I_i ω_i²"),
    ("2R", "T = Σ ½ m_i v_ci² + ½ I_1 ω_1²"),
    ("2R", "T = ½ Σ_i Σ_j H_ij θ̇_i θ̇_i"),
    ("2R", "L = Σ T_i + V_i"),
    ("3R", "V = Σ_{i=1}^{2} m_i g y_ci"),
    ("four_bar", "V = Σ m_i g x_ci"),
]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("robot", "line"), RIGHT)
def test_a_sum_is_read_for_every_body(robot: str, line: str):
    verdict = fb.check(fb.load(robot), line)
    assert verdict, verdict


@pytest.mark.sample(2)
@pytest.mark.parametrize(("robot", "line"), WRONG)
def test_a_wrong_sum_is_not_right(robot: str, line: str):
    assert not fb.check(fb.load(robot), line)


def test_a_mistake_in_a_sum_is_shown_where_it_is_written():
    text = fb.check(fb.load("2R"), "T = Σ m_i v_ci² + ½ I_i ω_i²").text
    assert "A factor ½ is missing: the kinetic energy of a body is ½ m v² + ½ I ω²." in text
    text = fb.check(fb.load("2R"), "V = Σ m_i g y_ci + m_i g x_ci").text
    assert "m_i g x_ci" in text


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("V = Σ m g", "no symbol 'Σ'"),
        ("V = Σ_{i=1}^{3} m_i g y_ci", "no symbol 'm_i'"),
    ],
)
def test_what_is_no_sum_over_the_bodies_is_refused(line: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(fb.load("2R"), line)


def test_a_sum_stands_among_words_of_a_document():
    answer = "The potential energy is $V = \\sum_{i=1}^{2} m_i g y_{ci}$ of both links."
    assert fb.check(fb.load("2R"), answer, form="markdown")
