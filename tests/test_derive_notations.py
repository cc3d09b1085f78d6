"""What is derived in a notation is what `check` reads in it, and says who writes so."""

from __future__ import annotations

from functools import cache

import pytest

import freebody as fb
from freebody.derivations.notations.notation import PRESETS

ARM = fb.planar("RR")
DERIVED = [
    ("2R", "newton-euler"), ("2R", "lagrange"), ("2R", "kane"), ("RP", "lagrange"),
    ("pendulum", "lagrange"), ("furuta", "recursive"), ("cart_pole", "lagrange"),
    ("four_bar", "lagrange-first-kind"), ("slider_crank", "newton-euler"),
]  # fmt: skip


def lines(derivation: fb.Derivation) -> list[str]:
    return [str(line) for step in derivation.steps for line in step.equations]


def is_right(model: fb.Model, text: str, notation: str | None = None) -> bool:
    try:
        return bool(fb.check(model, text, notation=notation))
    except fb.FreebodyError:
        return False


@cache
def read_in_the_notes(robot: str, method: str) -> tuple[list[int], int]:
    """The lines before the closed form that `check` reads in the notes' own letters, by place."""
    model = fb.load(robot)
    told = fb.derive(model, method)
    closed = told.steps[-1].operation == "The closed form"
    before = lines(told)[: -len(told.steps[-1].equations) if closed else None]
    return [k for k, line in enumerate(before) if is_right(model, line)], len(before)


@pytest.mark.parametrize("notation", PRESETS)
@pytest.mark.parametrize(("robot", "method"), DERIVED)
def test_what_is_printed_in_a_notation_is_read_in_it(robot: str, method: str, notation: str):
    model = fb.load(robot)
    printed = lines(fb.derive(model, method, notation=notation))
    places, end = read_in_the_notes(robot, method)
    chosen = [printed[k] for k in places] + printed[end:]
    assert len(chosen) > 10
    if not is_right(model, "\n".join(chosen), notation):
        assert [line for line in chosen if not is_right(model, line, notation)] == []
