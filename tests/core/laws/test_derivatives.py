"""Derivatives of inverse and forward dynamics against differences of our own functions along the
tangent space."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.branched import MODELS, difference_along
from support.helpers import STEPS, numbers, rate, several

pytestmark = pytest.mark.usefixtures("numpy_kernels")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MODELS)
def test_inverse_dynamics_derivatives_are_differences(name):
    model = MODELS[name]()
    q, qd, qdd = fb.random_state(model, seed=3, batch=3)
    by_q, by_qd, M = fb.inverse_dynamics_derivatives(model, q, qd, qdd)
    scale = np.abs(by_q).max()
    np.testing.assert_allclose(
        by_q,
        difference_along(model, lambda x: fb.inverse_dynamics(model, x, qd, qdd), q),
        atol=1e-9 * scale,
    )
    unit = np.eye(model.nv)[:, None]
    ahead, behind = (fb.inverse_dynamics(model, q, qd + s * unit, qdd) for s in (1, -1))
    # tau is quadratic in the rates, so this difference is exact
    np.testing.assert_allclose(by_qd, np.moveaxis((ahead - behind) / 2, 0, -1), atol=1e-11 * scale)
    np.testing.assert_allclose(M, fb.mass_matrix(model, q), atol=1e-12 * scale)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MODELS)
def test_forward_dynamics_derivatives_are_differences(name):
    model = MODELS[name]()
    q, qd, tau = fb.random_state(model, seed=4, batch=3)
    by_q, by_qd, inverse = fb.forward_dynamics_derivatives(model, q, qd, tau)
    scale = np.abs(by_q).max()
    np.testing.assert_allclose(
        by_q,
        difference_along(model, lambda x: fb.forward_dynamics(model, x, qd, tau), q),
        atol=1e-8 * scale,
    )
    unit = np.eye(model.nv)[:, None]
    ahead, behind = (fb.forward_dynamics(model, q, qd + s * unit, tau) for s in (1, -1))
    np.testing.assert_allclose(by_qd, np.moveaxis((ahead - behind) / 2, 0, -1), atol=1e-9 * scale)
    np.testing.assert_allclose(
        inverse @ fb.mass_matrix(model, q),
        np.broadcast_to(np.eye(model.nv), inverse.shape),
        atol=1e-9,
    )


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(
    "formula", ["inverse_dynamics_derivatives", "forward_dynamics_derivatives", "coriolis_matrix"]
)
def test_kernels_equal_the_reference(name, formula):
    model = MODELS[name]()
    state = fb.random_state(model, seed=5, batch=3)[: 2 if formula == "coriolis_matrix" else 3]
    compiled = getattr(fb, formula)(model, *state)
    plain = (numbers if formula == "coriolis_matrix" else several)(model, formula, *state)
    for a, b in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-11 * np.abs(b).max())


def _complex_steps(model, formula, q, *rates):
    """Derivatives of a formula along the tangent of q and along the first rates, to rounding."""
    function, h, far = fb.formula(model, formula), 1e-30, 1e-2
    exact = [tuple(map(complex, x)) for x in (q, *rates)]
    by_q, by_rates = [], []
    for unit in np.eye(model.nv):
        ahead = rate(numbers(model, "integrate", q, far * STEPS[:, None] * unit), far)
        moved = tuple(x + 1j * h * step for x, step in zip(exact[0], ahead, strict=True))
        by_q.append(np.imag(function(moved, *exact[1:])) / h)
        faster = tuple(x + 1j * h * step for x, step in zip(exact[1], unit, strict=True))
        by_rates.append(np.imag(function(exact[0], faster, *exact[2:])) / h)
    return np.stack(by_q, axis=-1), np.stack(by_rates, axis=-1)


@pytest.mark.parametrize("name", MODELS)
def test_derivatives_are_complex_steps_of_the_recursions(name):
    """No difference of what is differentiated is taken, so all digits count: the recursion on
    complex numbers, a step of 1e-30."""
    model = MODELS[name]().without("friction")
    q, qd, qdd = fb.random_state(model, seed=8)
    for formula in ("inverse_dynamics", "forward_dynamics"):
        found = several(model, f"{formula}_derivatives", q, qd, qdd)
        for ours, theirs in zip(found, _complex_steps(model, formula, q, qd, qdd), strict=False):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-11 * np.abs(theirs).max())
