"""Names of one's own for expressions of quantities, names={"tau_g": "-G"}, and lines about them."""

from __future__ import annotations

import pytest

import freebody as fb

ARM = fb.load("2R")
NAMES = {"tau_g": "-G", "E_tot": "T + V"}
WEIGHTS = "(m1 lc1 + m2 l1) g c1 + m2 g lc2 c12"


@pytest.mark.parametrize(
    "line",
    [
        f"tau_g = [-({WEIGHTS}); -m2 g lc2 c12]",
        f"tau_g = -[{WEIGHTS}; m2 g lc2 c12]",
        f"tau_g1 = -({WEIGHTS})",
        r"\tau_{g2} = -m_2 g l_{c2} c_{12}",
        "τ = M q̈ + C q̇ - tau_g",
        "E_tot = ½ H11 θ̇1² + H12 θ̇1 θ̇2 + ½ H22 θ̇2² + m1 g yc1 + m2 g yc2",
    ],
)
def test_a_line_about_an_explained_name_is_judged(line: str):
    verdict = fb.check(ARM, line, names=NAMES)
    assert verdict, verdict


@pytest.mark.parametrize(
    "line",
    [
        f"tau_g = [{WEIGHTS}; m2 g lc2 c12]",
        f"tau_g1 = {WEIGHTS}",
        "tau_g2 = -m2 g lc2 c2",
        "tau_g = 0",
        "tau_g = G",
        "E_tot = T - V",
    ],
)
def test_a_wrong_line_about_it_is_not_right(line: str):
    assert not fb.check(ARM, line, names=NAMES)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("tau_g = -G", "this says only what tau_g stands for"),
        ("tau_g1 = -G1", "this says only what tau_g1 stands for"),
        ("G = -tau_g", "G1 is defined by itself"),
        ("tau_g = [1; 2; 3]", "tau_g has 2 × 1 entries here"),
    ],
)
def test_what_says_nothing_about_the_robot_is_refused(line: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(ARM, line, names=NAMES)
