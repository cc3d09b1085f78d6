"""Names that other robots have a meaning for: what to write instead is told."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.derivations.check.spelling.answer_text import AnswerError

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
    with pytest.raises(AnswerError, match=r"'two_wheels' has no tip.*r_c1"):
        fb.check(model, line)
    assert fb.check(model, "x_c1 = lc1 c1")


@pytest.mark.parametrize("line", ["F = 0", "F_x = m3 d̈3", "F3 = m3 d̈3", "τ = Jᵀ F"])
def test_a_force_on_a_closed_chain_is_refused_in_words(line: str):
    with pytest.raises(AnswerError, match=r"may be a force from outside.*is f_12.*λ_1"):
        fb.check(fb.load("slider_crank"), line)


def test_a_force_of_ones_own_may_be_introduced():
    assert fb.check(fb.load("slider_crank"), "F = m3 d̈3\n0 = F - λ1")
    assert not fb.check(fb.load("slider_crank"), "F = m3 d̈3\n0 = F + λ1")
