"""Names that other robots have a meaning for: what to write instead is told."""

from __future__ import annotations

import pytest

import freebody as fb

NO_TIP = """
name = "two_wheels"
dim = 2

[[link]]
name = "ground"

[[link]]
name = "wheel1"
mass = "m1"
com = ["lc1", 0]
inertia = "I1"

[[link]]
name = "wheel2"
mass = "m2"
com = ["lc2", 0]
inertia = "I2"

[[joint]]
name = "axle1"
kind = "revolute"
parent = "ground"
child = "wheel1"

[[joint]]
name = "axle2"
kind = "revolute"
parent = "ground"
child = "wheel2"

[parameters]
g = 9.81
m1 = 2.0
lc1 = 0.1
I1 = 0.3
m2 = 2.0
lc2 = 0.1
I2 = 0.3
"""


@pytest.mark.parametrize(
    "line", ["x = lc1 c1", "ẏ = lc1 c1 θ̇1", "v_x = 0", "T = ½ m1 ẋ²", "r = [lc1 c1; lc1 s1]"]
)
def test_of_a_mechanism_without_tip_it_is_told_that_it_has_none(line: str, tmp_path):
    file = tmp_path / "two_wheels.toml"
    file.write_text(NO_TIP)
    model = fb.load(file)
    with pytest.raises(fb.AnswerError, match=r"'two_wheels' has no tip.*r_c1"):
        fb.check(model, line)
    assert fb.check(model, "x_c1 = lc1 c1")


@pytest.mark.parametrize("line", ["F = 0", "F_x = m3 d̈3", "F3 = m3 d̈3", "τ = Jᵀ F"])
def test_a_force_on_a_closed_chain_is_refused_in_words(line: str):
    with pytest.raises(fb.AnswerError, match=r"may be a force from outside.*is f_12.*λ_1"):
        fb.check(fb.load("slider_crank"), line)


def test_a_force_of_ones_own_may_be_introduced():
    assert fb.check(fb.load("slider_crank"), "F = m3 d̈3\n0 = F - λ1")
    assert not fb.check(fb.load("slider_crank"), "F = m3 d̈3\n0 = F + λ1")


_COEFFICIENTS = """A = c sin θ3
B = b sin θ2
C = a α1 sin θ1 + a ω1^2 cos θ1 + b ω2^2 cos θ2 - c ω3^2 cos θ3
D = c cos θ3
E = b cos θ2
F = a α1 cos θ1 - a ω1^2 sin θ1 - b ω2^2 sin θ2 + c ω3^2 sin θ3
α2 = (C D - A F)/(A E - B D)
α3 = (C E - B F)/(A E - B D)"""


def test_a_matrix_letter_that_a_line_gives_as_one_number_is_ones_own():
    """Norton's accelerations of a four-bar, whose C is no matrix."""
    letters = {"a": "l1", "b": "l2", "c": "l3"}
    four_bar = fb.load("four_bar")
    assert fb.check(four_bar, _COEFFICIENTS, names=letters, absolute=True)
    wrong = _COEFFICIENTS.replace("+ c ω3^2 sin", "- c ω3^2 sin")
    assert not fb.check(four_bar, wrong, names=letters, absolute=True)


@pytest.mark.parametrize("own", ["C = -m2 l1 lc2 sin θ2", "M = m1"])
def test_what_is_one_number_there_is_no_matrix_elsewhere(own: str):
    assert not fb.check(fb.load("2R"), f"{own}\nτ = M q̈ + C q̇ + G")
