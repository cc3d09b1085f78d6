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
from support.sources import SOURCES, place


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
        "times": lambda: fb.Motion.of(arm, times, np.zeros((len(times), 1))),
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


COMPARING = re.compile(
    r"\b(above|below|limits?|allowed|expected|exceed\w*|beyond|outside|at (most|least)|range"
    r"|must be|(more|less|faster) than|needs|ends with|follows|after|two values)\b|<|>"
)
NOT_COMPARED = {
    "design/load_tables.py": "a force and a moment",
    "identification/filters.py": "a rate and a cutoff",
    "identification/given_logs.py": "a rate, and the highest frequency that is taken from it",
    "identification/logs/read_log.py": "the length of a log and what its ends take",
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


@pytest.mark.long
def test_where_numbers_have_nothing_in_common_each_stands_where_it_is():
    assert (
        "rc₄ = [−0.433013 + 0.15 cos θ₄, −0.25 + 0.15 sin θ₄]ᵀ" in fb.derive(fb.load("3RRR")).text()
    )


def test_what_numbers_have_in_common_stands_in_front():
    scara = fb.derive(fb.load("scara"), "newton-euler").text()
    assert "vc₂ = [0.425 θ̇₁ sin θ₂, 0.1875 (θ̇₁ + θ̇₂) + 0.425 θ̇₁ cos θ₂, 0]ᵀ" in scara
    wrist = fb.derive(fb.load("stanford")).text()
    assert "v̇c₆z = v̇₆z − (d₆ − 0.15) ω₆x² − (d₆ − 0.15) ω₆y²" in wrist
    assert "v̇₃x = −0.4318 (θ̇₂² + ω₂y²) cos θ₃ + 0.4318 (θ̈₂ + ω₂x ω₂y) sin θ₃" in (
        fb.derive(fb.load("puma560", physical="ignore")).text()
    )


@pytest.mark.sample(1)
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
