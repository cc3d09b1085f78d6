"""Results depend on the arguments alone: not on what was called before, nor on how a batch is
cut."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.public_calls import DRAWINGS, LONG, bits, public_calls, state


def outcome(call: Callable[..., Any], model: fb.Model, given: dict[str, Any]) -> Any:
    """All bits of the result, or the error in full."""
    try:
        return bits(call(model, given))
    except fb.FreebodyError as problem:
        return type(problem).__name__, str(problem)


def fresh(model: fb.Model) -> fb.Model:
    return pickle.loads(pickle.dumps(model))


def last_entry(model: fb.Model, vector: np.ndarray, value: float) -> np.ndarray:
    return np.where(np.arange(vector.shape[-1]) == vector.shape[-1] - 1, value, vector)


def states(model: fb.Model) -> dict[str, dict[str, Any]]:
    """Ordinary ones, and those that overflow in some entries of a result, hold NaN or have another
    shape."""
    usual = state(model, 1)
    given = {
        "usual": usual,
        "one overflow": {**usual, "qd": last_entry(model, usual["qd"], 1e200)},
        "another": {**usual, "qdd": last_entry(model, usual["qdd"], 1e308) * 5.0},
        "nan": {**usual, "q": np.where(np.arange(model.nq) == 0, np.nan, usual["q"])},
    }
    if model.loops:
        return given
    return given | {
        "batch": state(model, 2, (3,)),
        "lists": {name: np.asarray(x).tolist() for name, x in usual.items()},
        "short": {**usual, "qd": usual["qd"][:-1]},
    }


@pytest.mark.sample(1)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of overflows, which are meant
@pytest.mark.parametrize("optimised", [0, pytest.param(2, marks=pytest.mark.long)], indirect=True)
@pytest.mark.parametrize("name", ["2R", "quadrotor", "four_bar"])
def test_no_answer_depends_on_what_was_called_before(name):
    """What is kept between calls is the same whatever LLVM's effort, which takes most of the time
    of some hundred kernels."""
    model = fb.load(name)
    calls = {k: call for k, call in public_calls().items() if k not in LONG | DRAWINGS}
    given = states(model)
    alone = {}
    for what, call in calls.items():
        for how in given:
            alone[what, how] = outcome(call, fresh(model), given[how])
    for seed in range(3):
        warm, order = fresh(model), np.random.default_rng(seed).permutation(len(alone))
        for what, how in np.array(list(alone))[order]:
            found = outcome(calls[what], warm, given[how])
            assert found == alone[what, how], f"{what}, {how}, order {seed}"


def test_an_overflow_is_refused_by_every_call_alike():
    """The first call refused it, the second returned [0, inf]."""
    slides = {"l": [0, 0], "lc": [0, 0], "m": [1, 1], "I": [0, 0], "g": 0}
    table = fb.planar("PP", **slides, drives=[None, fb.Drive(viscous=1e60)])
    q, qd = np.array([0.3, 0.4]), np.array([0.0, 1e260])
    said = set()
    for _ in range(3):
        with pytest.raises(fb.FreebodyError) as refusal:
            fb.bias(table, q, qd)
        said.add(str(refusal.value))
        fb.bias(table, q, q)
    assert said == {"bias: qd reaches 1e+260; the result overflows. Check its units."}


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["2R", "quadrotor", pytest.param("ur5e", marks=pytest.mark.long)])
def test_a_batch_has_the_bits_of_its_samples(name):
    model = fb.load(name)
    batch = state(model, 3, (5,))
    skipped = (
        LONG
        | DRAWINGS
        | {"random_state", "neutral", "parameters", "inverse_kinematics", "mobility", "assemble"}
        | {"payload_map", "dexterity", "ellipsoids", "deflection", "natural_frequencies"}
    )
    for what, call in public_calls().items():
        if what in skipped:
            continue
        try:
            whole = call(model, batch)
        except fb.FreebodyError:
            continue  # of loops, or needs another model
        for k in range(5):
            one = call(
                model, {key: x if key in ("t", "seed") else x[k] for key, x in batch.items()}
            )
            pair = [x.wrenches if what == "reactions" else x for x in (whole, one)]
            for a, b in zip(*(x if isinstance(x, tuple) else (x,) for x in pair), strict=True):
                assert np.ascontiguousarray(a[k]).tobytes() == np.ascontiguousarray(b).tobytes(), (
                    what,
                    k,
                )
