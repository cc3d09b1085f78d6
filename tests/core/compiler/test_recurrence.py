"""Steps of a recurrence: of few samples by code of their own, of more side by side, without LLVM
one by one. No public function has one that can be chosen freely, so internals are called."""

from __future__ import annotations

import numpy as np
import pytest

from freebody.math import minimum, sin
from freebody.program import Argument, trace
from freebody.targets import compile_program
from freebody.targets.in_turn import Placed, in_turn, recurrence
from freebody.targets.llvm import scan

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


@pytest.mark.parametrize("target", ["cpu", "numpy"])
@pytest.mark.parametrize("samples", [1, 21])
def test_states_may_stay_where_they_are_or_go_elsewhere(target: str, samples: int, monkeypatch):
    """Of five steps the results of two are kept; a row for all steps, numbers for all samples."""
    # as where two threads compile it at once: each must keep its own
    monkeypatch.setattr(scan, "_repeat", scan._repeat.__wrapped__)
    kernel = compile_program(PROGRAM, target=target)
    state, rows, low = given(samples)
    kept = np.full((samples, 4, 3, 2), np.nan)[:, :, 1].swapaxes(0, 1)
    now, expected = state.copy(), [state]
    where = [-1, 2, -1, 0, -1, -1]
    places = [
        Placed((now[None], kept), np.array([k >= 0 for k in some]) * 1, np.maximum(some, 0))
        for some in (where[:-1], where[1:])
    ]
    in_turn(kernel, (places[0], rows[0], low[:5, :1], places[1]), 5, samples)
    for k in range(5):
        expected.append(kernel(expected[-1], rows[0], low[k, 0]))
    np.testing.assert_array_equal(kept[2], expected[1])
    np.testing.assert_array_equal(kept[0], expected[3])
    np.testing.assert_array_equal(now, expected[5])
    assert np.isnan(kept[[1, 3]]).all()
