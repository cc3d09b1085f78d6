"""Steps of a recurrence: of few samples by code of their own, of more side by side, without LLVM
one by one. No public function has one that can be chosen freely, so internals are called."""

from __future__ import annotations

import numpy as np
import pytest

from freebody.elementary import minimum, sin
from freebody.program import Argument, trace
from freebody.targets import compile_program
from freebody.targets.recurrence import recurrence

STEPS = 7


def step(state, row, low):
    a, b = state
    total = sum(row[1:], row[0])
    return ((minimum(a + 0.1 * sin(total * b), low), b - a * row[4]),)


INPUTS = [Argument("state", (2,)), Argument("row", (13,)), Argument("low", ())]
PROGRAM = trace("steps", step, INPUTS, [Argument("next", (2,))])


def given(samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First states, rows that run backwards in an array of gaps, and numbers."""
    rng = np.random.default_rng(samples)
    rows = rng.normal(size=(STEPS, samples, 13, 2))[::-1, :, :, 0]
    return rng.normal(size=(samples, 2)), rows, rng.normal(size=(STEPS, samples))


@pytest.mark.parametrize("samples", [1, 3, 4, 21])
def test_steps_are_those_of_the_kernel(samples: int):
    kernel = compile_program(PROGRAM)
    state, rows, low = given(samples)
    found = recurrence(kernel, state, rows, low)
    assert found.shape == (STEPS + 1, samples, 2)
    for k in range(STEPS):
        state = kernel(state, rows[k], low[k])
        assert np.array_equal(found[k + 1], state)
    without = recurrence(compile_program(PROGRAM, target="numpy"), *given(samples))
    assert found == pytest.approx(without, rel=1e-12)


@pytest.mark.parametrize("samples", [1, 5])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("entry", [0, 7, 8, 12])
def test_what_is_not_finite_ends_a_sample_alone(samples: int, wrong: float, entry: int):
    state, rows, low = given(samples)
    rows[3, 0, entry] = wrong
    found = recurrence(compile_program(PROGRAM), state, rows, low)
    assert np.isfinite(found[:4]).all()
    assert np.isnan(found[4:, 0]).all()
    assert np.isfinite(found[:, 1:]).all()
    low[0, 0], rows[3, 0, entry] = wrong, 0.0
    assert np.isnan(recurrence(compile_program(PROGRAM), state, rows, low)[1:, 0]).all()


def test_no_steps_are_none():
    state, rows, low = given(2)
    found = recurrence(compile_program(PROGRAM), state, rows[:0], low[:0])
    assert np.array_equal(found, state[None])
