"""What mutants showed to be untested: small laws, each seen to fail with the change that had
survived."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb
from freebody.expressions.printed_names import sym
from freebody.expressions.typesetting.latex import width_of
from freebody_textbook.check.asked.right_equations import setting
from freebody_textbook.check.verdicts.verdict_sentences import example
from freebody_textbook.closed_chains.linear_equations import product
from support.printed_values import evaluate


def test_a_name_that_is_nothing_but_the_mark_of_a_rate_is_a_name():
    assert (sym("_d").dots, sym("theta1_d").dots, sym("theta1_dd").dots) == (0, 1, 2)


def test_scripts_in_a_formula_are_narrower_than_letters_and_wider_than_nothing():
    assert width_of("x") < width_of("x_{12}") < width_of("x12") + width_of("{}")


def test_there_is_no_example_that_tells_an_answer_from_itself():
    where = setting(fb.equations(fb.planar("RR")), ())
    length, mass = where.ring["l1"], where.ring["m1"]
    assert example(where, length, length) is None
    assert example(where, length, mass) is not None


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_square_has_no_sign_of_its_factor(power: int):
    equations = fb.equations(fb.planar("RR"))
    ring = equations.symbols.ring
    factor = (
        ring.sin("theta1") * ring.cos("theta1") - ring["l1"] * ring["lc1"] - ring["l1"] * ring["l2"]
    )
    values = {"theta1": 0.4, "l1": 0.7, "l2": 0.5, "lc1": 0.3}
    number = math.sin(0.4) * math.cos(0.4) - 0.7 * 0.3 - 0.7 * 0.5
    x = ring["l1"]
    for _ in range(power):
        x = x * factor
    assert evaluate(product(x, equations.layout), values) == pytest.approx(
        0.7 * number**power, rel=1e-12
    )


def test_mutants_are_drawn_from_every_file():
    """The tool refuses where a file of the source is in none of its areas."""
    tool = Path(__file__).parents[3] / "tools/mutants.py"
    done = subprocess.run(
        [sys.executable, str(tool), "--list", "--count", "14"],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-500:]
    areas = [line.partition(":")[0] for line in done.stdout.splitlines()]
    assert len(areas) == len(set(areas)) == 14
