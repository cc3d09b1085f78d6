"""Inverse kinematics in answers: coordinates by arccos, atan2 and roots, on their branches."""

from __future__ import annotations

import pytest

import freebody as fb

ARM, SLIDE = fb.planar("RR"), fb.planar("RP")
COSINE = "(x² + y² - l1² - l2²)/(2 l1 l2)"
D = f"D = {COSINE}; "
ELBOWS = "are the two postures"
LINES = [  # right lines of textbooks, and a piece of them that is changed, with what is said
    (ARM, f"theta2 = acos({COSINE})", "- l2²", "+ l2²", "‘l2²’ has the wrong sign"),
    (ARM, f"theta2 = acos({COSINE})", "acos", "asin", "It is the arccosine of that."),
    (
        ARM,
        r"\theta_2 = \arccos\frac{x^2+y^2-l_1^2-l_2^2}{2 l_1 l_2}",
        "2 l_1", "l_1", "is not right",
    ),
    (
        ARM,
        r"\theta_2 = \cos^{-1}\left(\frac{x^2+y^2-l_1^2-l_2^2}{2 l_1 l_2}\right)",
        "-l_1^2", "+l_1^2", "has the wrong sign",
    ),
    (ARM, "θ2 = π - acos((l1² + l2² - x² - y²)/(2 l1 l2))", "π - ", "", "is not right"),
    (ARM, D + "θ2 = atan2(sqrt(1 - D²), D)", "1 - D²", "1 + D²", "‘D²’ has the wrong sign"),
    (
        ARM,
        D + r"\theta_2 = \operatorname{atan2}\left(\pm\sqrt{1-D^2}, D\right)",
        r"\pm\sqrt{1-D^2}, D", r"D, \pm\sqrt{1-D^2}", "atan2(y, x)",
    ),
    (ARM, "θ1 = atan2(y, x) - atan2(l2 s2, l1 + l2 c2)", ") - ", ") + ", "has the wrong sign"),
    (ARM, "θ1 = atan2(y, x) - atan2(l2 s2, l1 + l2 c2)", "y, x", "x, y", "atan2(y, x)"),
    (ARM, "θ1 = atan2(y, x) - atan2(l2 s2, l1 + l2 c2)", "2(l2", "2(l1", "‘l1’ must be l₂"),
    (ARM, "θ1 = atan2(-l2 s2 x + (l1 + l2 c2) y, l2 s2 y + (l1 + l2 c2) x)", "2(-", "2(", "sign"),
    (
        ARM,
        "θ1 = atan2(y, x) - acos((x² + y² + l1² - l2²)/(2 l1 sqrt(x² + y²)))",
        "- l2²", "+ l2²", "‘l2²’ has the wrong sign",
    ),
    (SLIDE, "θ1 = atan2(y, x)", "y, x", "x, y", "atan2(y, x)"),
    (SLIDE, "d2 = sqrt(x² + y²) - l1", "+ y²", "- y²", "has the wrong sign"),
    (
        fb.planar("RRR"),
        "xw = x - l3 cos(θ1+θ2+θ3); yw = y - l3 sin(θ1+θ2+θ3);"
        "θ2 = acos((xw² + yw² - l1² - l2²)/(2 l1 l2))",
        "- l2²", "+ l2²", "‘l2²’ has the wrong sign",
    ),
]  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize(("model", "line", "piece", "other", "reason"), LINES)
def test_inverse_kinematics(model, line: str, piece: str, other: str, reason: str):
    told = fb.check(model, line)
    assert told, line
    assert "Compared in numbers at 24 positions" in told.text
    assert "proved" not in told.text
    assert piece in line
    verdict = fb.check(model, line.replace(piece, other, 1))
    assert not verdict
    assert reason in verdict.text


def test_the_branch_is_told():
    up, down = (fb.check(ARM, f"θ2 = {sign}acos({COSINE})") for sign in ("", "-"))
    assert up
    assert down
    counts = [int(x.text.split("stands at ")[1].split(",")[0]) for x in (up, down)]
    assert sum(counts) == 24
    assert ELBOWS in up.text
    assert ELBOWS not in fb.check(ARM, "θ1 = atan2(y, x) - atan2(l2 s2, l1 + l2 c2)").text
    quadrant = fb.check(ARM, "θ1 = arctan(y/x) - arctan(l2 s2/(l1 + l2 c2))")
    assert quadrant
    assert "arctan loses the quadrant" in quadrant.text


def test_functions_are_read_in_any_quantity():
    """A speed is the root of the sum of squares; a torque is no root of a mass."""
    assert fb.check(ARM, "lc1 θ̇1 c1 = sqrt(lc1² θ̇1²) c1")
    wrong = fb.check(ARM, "τ1 = sqrt(m1)")
    assert not wrong
    assert "Compared in numbers at 24 states" in wrong.text


def test_two_lines_are_of_one_posture():
    first = "θ1 = atan2(y, x) {} acos((x² + y² + l1² - l2²)/(2 l1 sqrt(x² + y²)))"
    assert fb.check(ARM, f"θ2 = acos({COSINE})\n{first.format('-')}")
    assert fb.check(ARM, f"θ2 = -acos({COSINE})\n{first.format('+')}")
    mixed = fb.check(ARM, f"θ2 = acos({COSINE})\n{first.format('+')}")
    assert [x.equal for x in mixed.equations] == [True, False]
    assert "another posture than the line before" in mixed.causes[0]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("θ1 = atan2(s1, c1)", "θ1 stands on both sides"),
        ("θ2 = " + "acos(" * 6 + "0" + ")" * 6, "at most 5 inverse functions"),
        ("θ1 = atan2(y)", "the comma of atan2"),
        ("θ2 = arccos x", "a bracket after arccos"),
    ],
)
def test_what_is_no_position_is_refused(line: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(ARM, line)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("robot", "line"),
    [
        ("2R", "θ2 = arccos(1)"),
        ("2R", "θ1 = arcsin(1)"),
        ("2R", "τ1 = arccos(1)"),
        ("2R", "θ1 = atan2(0, 0)"),
        ("slider_crank", "τ1 = tan(arccos(1)) + 3"),
        ("slider_crank", "τ1 = 5/(l1 s1 + l2 s12)"),
        ("slider_crank", "d3 = 1/(l1 s1 + l2 s12)"),
        ("slider_crank", "θ̇2 = θ̇1/(d3 - l1 c1 - l2 c12)"),
    ],
)
def test_where_a_function_is_steep_or_loops_divide_by_nothing_wrong_is_wrong(robot, line):
    verdict = fb.check(fb.load(robot), line)
    assert not verdict
    assert "another assembly" not in verdict.text


@pytest.mark.parametrize(
    ("robot", "line"),
    [
        ("2R", "G2 = m2 g lc2 c12 + 0.001 + 10^12 sqrt(l1) - 10^12 sqrt(l1)"),
        ("2R", "θ2 = arccos((x²+y²-l1²-l2²)/(2 l1 l2)) + 0.01 + 10^9 (sqrt(l1)² - l1)/l1"),
        (
            "four_bar",
            "ω3 = l1 s2 θ̇1/(l3 sin(θ1+θ2-θ3)) + θ̇1/10 + 10^12 θ̇1 (l1 s1 + l2 s12 - l3 s3)",
        ),
        ("four_bar", "T1 + 0.1 + 10^9 l1 s1 = T1 + 10^9 (l3 s3 - l2 s12)"),
        ("cart_pole", "τ1 = (m1+m2) ẍ + 10^9 (c2 ẍ + l2 θ̈2 + g s2)"),
    ],
)
def test_what_cancels_hides_no_mistake(robot, line):
    """Where rounding could, the line is left unread; smaller terms that cancel do no harm."""
    with pytest.raises(fb.AnswerError, match="rounding could hide a mistake"):
        fb.check(fb.load(robot), line)
    assert fb.check(ARM, "G2 = m2 g lc2 c12 + 100 sqrt(l1) - 100 sqrt(l1)")


_WRIST = "x_w = x - l3 cos(θ1+θ2+θ3)\ny_w = y - l3 sin(θ1+θ2+θ3)\n"


@pytest.mark.parametrize(
    "line",
    [
        "cos θ2 = (x_w^2 + y_w^2 - l1^2 - l2^2)/(2 l1 l2)",
        "x_w^2 + y_w^2 = l1^2 + l2^2 + 2 l1 l2 cos θ2",
        "θ2 = arccos((x_w^2 + y_w^2 - l1^2 - l2^2)/(2 l1 l2))",
    ],
)
def test_a_line_is_about_what_names_of_ones_own_are_given_by(line: str):
    arm = fb.planar("RRR")
    assert fb.check(arm, _WRIST + line)
    wrong = line.replace("- l1^2", "+ l1^2").replace("= l1^2", "= 2 l1^2")
    assert not fb.check(arm, _WRIST + wrong)


def test_a_line_that_holds_whatever_stands_behind_ones_own_names_is_refused():
    with pytest.raises(fb.FreebodyError, match="nothing to check"):
        fb.check(fb.planar("RR"), "A = T + V\nB = A + T\nB - V = 2 T")


@pytest.mark.sample(1)
@pytest.mark.parametrize("robot", ["2R", "four_bar"])
def test_a_level_is_an_energy_also_under_a_root(robot):
    model = fb.load(robot)
    for level in ("m1 g sqrt(l1²)", "m1 g l1 sqrt(m2/m1) + 5", "sqrt(5)"):
        assert fb.check(model, f"V1 = m1 g lc1 s1 + {level}")
    for level in ("m1 g sqrt(l1)", "sqrt(l1)", "m1 g l1 + g sqrt(m1)"):
        assert not fb.check(model, f"V1 = m1 g lc1 s1 + {level}")
