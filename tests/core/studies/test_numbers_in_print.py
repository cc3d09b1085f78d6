"""How numbers print for people."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest

import freebody as fb
from freebody.motion.motion import vector_of_times
from freebody.outputs.number_text import compared, fixed, rounded_up, shortest, significant
from freebody.report.results import LimitUse
from support.sources import SOURCES, place


@pytest.mark.parametrize(
    ("value", "as_measured", "as_short"),
    [
        (0.4, "0.400", "0.4"),
        (-12.0, "−12.0", "−12"),
        (9.99e-4, "9.99·10⁻⁴", "0.000999"),
        (1e-3, "0.00100", "0.001"),
        (99999.0, "99999", "99999"),
        (-123456789.0, "−1.23·10⁸", "−123456789"),
        (2.5e-7, "2.50·10⁻⁷", "2.5·10⁻⁷"),
        (6e23, "6.00·10²³", "6·10²³"),
    ],
)
def test_a_number_prints_with_its_digits(value: float, as_measured: str, as_short: str) -> None:
    assert significant(value) == as_measured
    assert shortest(value) == as_short


def test_what_is_no_number_and_signs() -> None:
    assert [significant(x) for x in (math.nan, math.inf, -math.inf, 0.0)] == ["–", "∞", "−∞", "0"]
    assert fixed(-0.256, 2) == "−0.26"


@pytest.mark.parametrize("value", [3.14159, -2.5e-9, 7.5e6, 0.02, 1e-300])
@pytest.mark.parametrize("digits", [2, 4])
def test_what_is_printed_is_the_number(value: float, digits: int) -> None:
    """Read back, it is the number to the digits that are given."""
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for text in (significant(value, digits), shortest(value, digits)):
        mantissa, _, power = text.replace("−", "-").partition("·10")
        read = float(f"{mantissa}e{power.translate(raised) or 0}")
        assert read == pytest.approx(value, rel=10.0 ** (1 - digits) / 2)


PAIRS = [(0.78539, 0.78541), (1.0 + 1e-9, 1.0), (100000.2, 100000.1), (-3.0, 3.0), (0.0, 1e-9)]


@pytest.mark.parametrize("pair", PAIRS)
def test_numbers_that_a_message_compares_differ_in_print(pair: tuple[float, float]) -> None:
    one, other = compared(*pair)
    assert one != other
    assert (float(one) < float(other)) == (pair[0] < pair[1])
    assert compared(pair[0], pair[0])[0] == compared(pair[0], pair[0])[1]


def test_compared_numbers_have_no_more_digits_than_it_takes() -> None:
    assert compared(1.23456, 9.87654) == ("1.235", "9.877")
    assert compared(0.78539, 0.78541) == ("0.78539", "0.78541")
    assert compared(math.inf, 2.0) == ("inf", "2")


def test_what_a_message_states_of_numbers_is_true_of_the_printed_ones() -> None:
    printed = compared(0.1, 0.2, 0.3000004, digits=6, holds=lambda a, b, c: a + b < c)
    assert printed == ("0.1", "0.2", "0.3000004")


def refusals() -> dict[str, Callable[[], object]]:
    """Inputs that miss what is allowed by less than four digits show."""
    arm = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1])
    free = fb.load("quadrotor")
    q = fb.neutral(free)
    q[3] = 1.0 + 2e-6
    zeros = np.zeros(free.nv)
    times = [0.0, 1.0, 1000.0, 1000.0 - 1e-9, 1001.0, 1002.0, 1003.0, 1004.0, 1005.0]
    inertia = [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3 + 1e-7]]
    return {
        "limits": lambda: fb.Limits(lower=1.0 + 1e-9, upper=1.0).fault() or "",
        "quaternion": lambda: fb.inverse_dynamics(free, q, zeros, zeros),
        "times": lambda: vector_of_times(times),
        "inertia": lambda: fb.Inertia.of(1.0, [0, 0, 0], inertia).fault() or "",
        "too large": lambda: arm.bind({"link1.mass": 1e60 * (1 + 1e-12)}),
    }


KINDS = ("limits", "quaternion", "times", "inertia", "too large")


@pytest.mark.parametrize("kind", KINDS)
def test_no_message_compares_a_number_with_its_equal(kind: str) -> None:
    """Of two numbers that a message compares, none prints like the other."""
    try:
        text = str(refusals()[kind]())
    except fb.FreebodyError as error:
        text = str(error)
    numbers = re.findall(r"(?<![\w.\[])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w\]])", text)
    assert len(numbers) >= 2, text
    assert all(one != other for one, other in pairwise(numbers)), text


def test_a_limit_that_is_exceeded_prints_so() -> None:
    use = LimitUse("speed", "elbow", 0.78541, 0.78539, 0.78541 / 0.78539, 1.0, "rad/s")
    assert use.exceeded
    assert use.text == (
        "the speed of elbow is 0.78541 rad/s at t = 1 s, 100.003 % of its limit of 0.78539 rad/s"
    )
    by_rounding = LimitUse(
        "position", "elbow", math.pi, math.nextafter(math.pi, 3), 1.0, 0.5, "rad", "upper"
    )
    assert by_rounding.text == (
        "elbow goes to 3.142 rad at t = 0.5 s, its upper limit being 3.142 rad"
    )
    at_zero = LimitUse("position", "elbow", 1.776e-15, 0.0, 1.0, 0.5, "rad", "lower")
    assert at_zero.text == "elbow goes to 0 rad at t = 0.5 s, its lower limit being 0 rad"


COMPARING = re.compile(
    r"\b(above|below|limits?|allowed|expected|exceed\w*|beyond|outside|at (most|least)|range"
    r"|must be|(more|less|faster) than|needs|ends with|follows|after|two values)\b|<|>"
)
NOT_COMPARED = {
    "model/number_editors.py": "a factor, and the limit of what it multiplies",
    "motion/optimal/geometric_path.py": "a place, and the size of a jump there",
    "motion/planning/tip_following.py": "a place, and a ratio there",
    "motion/planning/tip_paths.py": "a length, and a radius that must be half of it",
    "report/checks.py": "a time and a time",
    "report/replay.py": "a time and a distance",
    "report/summary.py": "a time and a torque",
}
"""Files with a message of several numbers that are not compared with each other."""


def sentences_of_several_numbers(text: str) -> Iterator[str]:
    """F-strings with two or more rounded numbers and a word of comparison."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.JoinedStr):
            continue
        specs = [
            ast.unparse(part.format_spec).strip("f'\"")
            for part in node.values
            if isinstance(part, ast.FormattedValue) and part.format_spec is not None
        ]
        words = "".join(str(x.value) for x in node.values if isinstance(x, ast.Constant))
        if sum(spec[-1:] in ("g", "f", "e") for spec in specs) >= 2 and COMPARING.search(words):
            yield words


def test_what_a_message_compares_goes_through_compared() -> None:
    found = {
        place(path): list(sentences_of_several_numbers(path.read_text("utf-8")))
        for path in SOURCES
        if not {"figures", "targets", "render", "typesetting", "freebody_notes"} & {*path.parts}
    }
    assert {name: said for name, said in found.items() if said and name not in NOT_COMPARED} == {}
    assert [*sentences_of_several_numbers("f'{x:.4g} is above {y:g}'")] == [" is above "]


def test_what_has_to_be_given_at_least_is_never_rounded_down() -> None:
    assert rounded_up(1.234501, 4) == "1.235"
    assert rounded_up(1.2349, 4) == "1.235"
    assert rounded_up(1.25, 4) == "1.25"
    rng = np.random.default_rng(3)
    for x in np.exp(rng.uniform(-20, 20, 200)):
        assert x <= float(rounded_up(float(x), 5)) <= x * (1 + 1e-4)


def test_what_numbers_have_in_common_stands_in_front():
    scara = fb.derive(fb.load("scara"), "newton-euler").text()
    assert "vc₂ = [0.425 θ̇₁ sin θ₂, 0.1875 (θ̇₁ + θ̇₂) + 0.425 θ̇₁ cos θ₂, 0]ᵀ" in scara
    assert (
        "rc₄ = [−0.433013 + 0.15 cos θ₄, −0.25 + 0.15 sin θ₄]ᵀ" in fb.derive(fb.load("3RRR")).text()
    )
    wrist = fb.derive(fb.load("stanford")).text()
    assert "v̇c₆z = v̇₆z − (d₆ − 0.15) ω₆x² − (d₆ − 0.15) ω₆y²" in wrist
    assert "v̇₃x = −0.4318 (θ̇₂² + ω₂y²) cos θ₃ + 0.4318 (θ̈₂ + ω₂x ω₂y) sin θ₃" in (
        fb.derive(fb.load("puma560", physical="ignore")).text()
    )


@pytest.mark.parametrize("name", ["stewart", "scara", "stanford", "3RRR", "ur5e"])
def test_no_bracket_behind_a_minus_begins_with_one(name):
    assert "−(−" not in fb.derive(fb.load(name)).text()


def test_a_square_is_completed_only_with_numbers_that_are_printed_whole():
    """0.3 ω² - 2 ω ḋ is no multiple of the square of ω - 3.33333 ḋ."""
    rows = [
        {"m": "m1"},
        {"a": 0.4, "m": "m2", "com": [0.2, 0, 0]},
        {"a": 0.3, "alpha": math.pi / 2, "joint": "P", "m": "m3", "com": [0, 0, 0.1]},
    ]
    text = fb.derive(fb.dh(rows, convention="modified"), "recursive").text()
    assert "3.33333" not in text
    assert "(d₃ + 0.1)²" in text
