"""Derivatives of inverse and forward dynamics beside Pinocchio: a dozen robots, in the long run
every file.

Both take them on the tangent space, of free joints in body axes, and by angle and not by (cos,
sin).
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.helpers import numbers
from support.pinocchio_twin import (
    BASES,
    DOZEN,
    EPS,
    SINGULAR,
    Theirs,
    dry,
    every_robot,
    pair,
    pin,
    state,
    symmetric,
)

TOLERANCE = 1e-8
SOON_COMPILED = [name for name in DOZEN if "baxter" not in name and "solo" not in name]


@pytest.mark.sample(7)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("name", DOZEN)
def test_formulas(name: str, base: str):
    compare(name, base, by_formula)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", SOON_COMPILED)
def test_kernels(name: str):
    compare(name, "fixed", compiled)


@pytest.mark.long
@every_robot
def test_all_formulas(name: str, base: str):
    compare(name, base, by_formula)


@pytest.mark.long
@every_robot
def test_all_kernels(name: str, base: str):
    compare(name, base, compiled)


def by_formula(model: fb.Model, name: str, *arrays: np.ndarray):
    return np.moveaxis(numbers(model, name, *arrays), -3, 0)


def compiled(model: fb.Model, name: str, *arrays: np.ndarray):
    return getattr(fb, name)(model, *arrays)


def compare(name: str, base: str, compute) -> None:
    """All six matrices at two states."""
    model, theirs = pair(name, base)
    if model.nv == 0:
        return
    q, qd, qdd = state(model, name)
    bare = dry(model)
    expected = matrices(theirs, pin.computeRNEADerivatives, q, qd, qdd)
    agree(compute(bare, "inverse_dynamics_derivatives", q, qd, qdd), expected, TOLERANCE)
    if name in SINGULAR:
        return
    tau = theirs.of(pin.rnea, q, qd, qdd)  # accelerations of the size that a robot has
    condition = max(np.linalg.cond(symmetric(m)) for m in theirs.of(pin.crba, q))
    expected = matrices(theirs, pin.computeABADerivatives, q, qd, tau)
    found = compute(bare, "forward_dynamics_derivatives", q, qd, tau)
    agree(found, expected, max(TOLERANCE, 1e3 * EPS * condition))


def matrices(theirs: Theirs, compute, q: np.ndarray, *rates: np.ndarray) -> list[np.ndarray]:
    """The three matrices of Pinocchio at each state, in our order of joints."""
    rows = []
    for one in zip(q, *rates, strict=True):
        by_q, by_qd, by_last = compute(
            theirs.model, theirs.data, theirs.q(one[0]), *map(theirs.rates, one[1:])
        )
        found = (by_q, by_qd, symmetric(np.array(by_last)))
        rows.append([np.array(x)[theirs.v][:, theirs.v] for x in found])
    return [np.array(x) for x in zip(*rows, strict=True)]


def agree(found, expected: list[np.ndarray], tolerance: float) -> None:
    """Each entry within the tolerance of max(1, its own value)."""
    for ours, theirs, what in zip(found, expected, ("q", "rates", "the last"), strict=True):
        error = np.abs(ours - theirs)
        own = tolerance * np.maximum(1.0, np.abs(theirs))
        assert (error <= own).all(), f"by {what}: {(error / own).max():.2g} times the tolerance"
