"""Robots whose file gives gravity as a vector of numbers, and answers that call it g."""

from __future__ import annotations

import pytest

import freebody as fb

PENDULUM = """
dim = 2
gravity = [0, {}]

[[link]]
name = "ground"

[[link]]
name = "bar"
mass = "m"
com = ["l", 0]

[[joint]]
name = "pin"
kind = "revolute"
parent = "ground"
child = "bar"

[parameters]
m = 2.0
l = 0.3
"""


@pytest.fixture
def pendulum(tmp_path):
    def of(y: float) -> fb.Model:
        path = tmp_path / "pendulum.toml"
        path.write_text(PENDULUM.format(y))
        return fb.load(path)

    return of


@pytest.mark.parametrize(
    ("line", "right"),
    [
        ("V = m g l sin θ", True),
        ("V = 9.81 m l sin θ", True),
        ("τ = m l² θ̈ + m g l cos θ", True),
        ("G = m g l cos θ\nG = 5.886 cos θ", True),
        ("τ = H θ̈ + c + G", True),
        ("τ = m l² θ̈ + m g l sin θ", False),
        ("V = m g l cos θ", False),
        ("V = 1.62 m l sin θ", False),
    ],
)
def test_g_is_the_size_of_gravity(pendulum, line: str, right: bool):
    verdict = fb.check(pendulum(-9.81), line)
    assert bool(verdict) is right, verdict


def test_it_may_be_a_name_of_the_users_own(pendulum):
    assert fb.check(pendulum(-9.81), "V = m g l sin θ", names={"g": "9.81"})
    assert not fb.check(pendulum(-9.81), "V = m g l sin θ", names={"g": "1.62"})


def test_where_nothing_weighs_the_verdict_says_that_g_is_zero(pendulum):
    verdict = fb.check(pendulum(0), "τ = m l² θ̈ + m g l cos θ")
    assert verdict
    assert "g is 0 in 'pendulum'" in verdict.text


def test_an_answer_that_only_gives_a_parameters_value_is_refused(tmp_path):
    path = tmp_path / "pendulum.toml"
    path.write_text(PENDULUM.format(-9.81).replace("m = 2.0", "T = 2.0").replace('"m"', '"T"'))
    with pytest.raises(fb.AnswerError, match="only gives values of parameters"):
        fb.check(fb.load(path), "T = 2.0")
