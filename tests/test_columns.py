"""Matrices by columns equal the ones that are compiled whole; second derivatives equal differences of first ones."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.numerics.columns import BY_COLUMNS, ColumnKernel
from freebody.numerics.formulas import FORMULAS, Option
from freebody.numerics.kernels import fetch, reference
from test_derivatives import MODELS, _difference

INPUTS = {"q": 0, "qd": 1, "qdd": 2, "tau": 2}


@pytest.mark.parametrize("model_name", MODELS)
@pytest.mark.parametrize("name", BY_COLUMNS)
def test_columns_equal_the_whole(model_name, name):
    model = MODELS[model_name]()
    state = fb.random_state(model, seed=2, batch=(2, 3))
    given = [state[INPUTS[x]] for x in FORMULAS[name].inputs]
    by_columns = ColumnKernel(name, model.nv, lambda part: fetch(model, (part,), Option()))(*given)
    whole = fetch(model, (name,), Option())(*given)
    for a, b in zip(np.atleast_1d(by_columns), np.atleast_1d(whole), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-10 * np.abs(b).max())


@pytest.mark.parametrize("model_name", MODELS)
def test_second_derivatives_are_differences_of_first_ones(model_name):
    model = MODELS[model_name]()
    q, qd, qdd = fb.random_state(model, seed=6)
    by_q_q, by_qd_q, by_qd_qd, M_q = reference(
        model, "inverse_dynamics_second_derivatives", Option(), q, qd, qdd
    )

    def first(part):
        return lambda x: fb.inverse_dynamics_derivatives(model, x, qd, qdd)[part]

    scale = np.abs(by_q_q).max()
    for tensor, part in ((by_q_q, 0), (by_qd_q, 1), (M_q, 2)):
        np.testing.assert_allclose(tensor, _difference(model, first(part), q), atol=1e-8 * scale)
    step = np.eye(model.nv)
    ahead, behind = (
        np.stack([fb.inverse_dynamics_derivatives(model, q, qd + s * e, qdd)[1] for e in step], axis=-1)
        for s in (1, -1)
    )
    np.testing.assert_allclose(by_qd_qd, (ahead - behind) / 2, atol=1e-10 * scale)
    np.testing.assert_allclose(by_qd_qd, np.swapaxes(by_qd_qd, -1, -2), atol=1e-10 * scale)
