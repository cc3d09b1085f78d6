"""Matrices by columns equal the ones that are compiled whole; second derivatives equal differences
of first ones.

Columns are made from 65 coordinates on; to hold them against a whole matrix, small robots are given
to them directly.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.kernels import lookup
from freebody.kernels.formulas import FORMULAS, Formula, Option
from freebody.kernels.formulas.record import Output
from freebody.kernels.lookup import ColumnKernel, KernelList
from freebody.kernels.tracing import arguments
from freebody.targets import KernelError
from freebody.trees.public_calls import evaluate
from support.branched import MODELS, difference_along
from support.helpers import refused, several

BY_COLUMNS = [name for name, formula in FORMULAS.items() if formula.by_columns]
INPUTS = {"q": 0, "qd": 1, "qdd": 2, "tau": 2}


@pytest.mark.sample(2)
@pytest.mark.parametrize("model_name", MODELS)
@pytest.mark.parametrize("name", BY_COLUMNS)
def test_columns_equal_the_whole(model_name, name):
    model = MODELS[model_name]()
    state = fb.random_state(model, seed=2, batch=(2, 3))
    given = [state[INPUTS[x]] for x in FORMULAS[name].inputs]
    inputs = arguments(model, (name,), Option())
    one = fb.kernel(model, name)
    columns = ColumnKernel(
        name, inputs, model.nv, lambda part: fb.kernel(model, part), lambda: one.program
    )
    by_columns, whole = columns(*given), one(*given)
    for a, b in zip(np.atleast_1d(by_columns), np.atleast_1d(whole), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-10 * np.abs(b).max())


def test_refusals_are_those_of_a_kernel():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    inputs = arguments(model, ("coriolis_matrix",), Option())
    kernel = ColumnKernel(
        "coriolis_matrix",
        inputs,
        2,
        lambda part: fb.kernel(model, part),
        lambda: fb.kernel(model, "coriolis_matrix").program,
    )
    q = np.zeros(2)
    for text, call in (
        ("coriolis_matrix: 1 arguments given, expected 2: q(2), qd(2).", lambda: kernel(q)),
        ("coriolis_matrix: qd has shape (3,), expected (..., 2).", lambda: kernel(q, np.zeros(3))),
        (
            "coriolis_matrix: q holds complex numbers, expected real numbers; .real has their real "
            "parts.",
            lambda: kernel(q + 0j, q),
        ),
        (
            "coriolis_matrix: out has shape (3, 2, 2), expected (2, 2).",
            lambda: kernel(q, q, out=np.zeros((3, 2, 2))),
        ),
    ):
        refused(text, call)
    assert repr(kernel) == "ColumnKernel(coriolis_matrix: q(2), qd(2); n = 2)"
    out = np.empty((2, 2))
    assert kernel(q, q, out=out) is out
    with pytest.raises(TypeError, match="same_kind"):
        kernel(q, q, out=np.zeros((2, 2), dtype=int))


def long_chain(n: int) -> fb.Model:
    """A chain in space of n equal links, each turned against the one before it."""
    row = {
        "a": 0.02,
        "d": 0.01,
        "alpha": 0.7,
        "m": 0.1,
        "com": [0.01, 0, 0],
        "I": np.diag([1e-4, 2e-4, 2e-4]),
    }
    return fb.dh([row] * n, convention="modified")


@pytest.mark.parametrize("n", [12, pytest.param(200, marks=pytest.mark.long)])
def test_matrices_of_long_chains(n, monkeypatch):
    """Each by columns, and each against another quantity of the same robot."""
    monkeypatch.setattr(lookup, "LARGEST", 8)
    model = long_chain(n)
    q, qd, qdd = fb.random_state(model, seed=9)
    M, bias = fb.mass_matrix(model, q), fb.bias(model, q, qd)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    size = np.abs(tau).max()
    np.testing.assert_allclose(M, M.T, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(M @ qdd + bias, tau, atol=1e-9 * size)
    C = fb.coriolis_matrix(model, q, qd)
    np.testing.assert_allclose(
        C @ qd + fb.gravity_torque(model, q), bias, atol=1e-9 * np.abs(bias).max()
    )
    by_q, by_qd, _ = fb.inverse_dynamics_derivatives(model, q, qd, qdd)
    ahead, behind = (fb.inverse_dynamics(model, q, qd + s * qdd, qdd) for s in (1, -1))
    np.testing.assert_allclose(
        by_qd @ qdd, (ahead - behind) / 2, atol=1e-9 * np.abs(ahead - behind).max()
    )
    h = 1e-4
    ahead, behind = (fb.inverse_dynamics(model, q + s * h * qdd / n, qd, qdd) for s in (1, -1))
    np.testing.assert_allclose(
        by_q @ qdd / n, (ahead - behind) / (2 * h), atol=1e-5 * np.abs(by_q @ qdd / n).max()
    )
    again = fb.forward_dynamics(model, q, qd, tau)
    condition = np.linalg.cond(M)
    np.testing.assert_allclose(again, qdd, atol=max(1e-10, 1e-15 * condition) * np.abs(qdd).max())
    derivatives = fb.forward_dynamics_derivatives(model, q, qd, tau)
    np.testing.assert_allclose(
        derivatives[0], -derivatives[2] @ by_q, atol=1e-9 * np.abs(derivatives[0]).max()
    )


def test_several_quantities_of_a_long_chain(monkeypatch):
    """One callable, whose program grows with the chain and not with its square."""
    monkeypatch.setattr(lookup, "LARGEST", 8)
    model = long_chain(9)
    q, qd, _ = fb.random_state(model, seed=9, batch=(2, 3))
    kernel = fb.kernel(model, ["bias", "mass_matrix", "gravity_torque"])
    assert isinstance(kernel, KernelList)
    assert "ColumnKernel(mass_matrix" in repr(kernel)
    found = kernel(q[0, 0], qd)
    expected = (
        fb.bias(model, q[0, 0], qd),
        fb.mass_matrix(model, q[0, 0]),
        fb.gravity_torque(model, q[0, 0]),
    )
    for ours, alone in zip(found, expected, strict=True):
        np.testing.assert_allclose(
            ours, np.broadcast_to(alone, ours.shape), atol=1e-12 * np.abs(alone).max()
        )
    assert [x.shape[:2] for x in found] == [(2, 3)] * 3
    columns_of_one = fb.kernel(model, "mass_matrix")
    assert isinstance(columns_of_one, ColumnKernel)
    monkeypatch.setattr(lookup, "LARGEST", 9)
    again = long_chain(9)
    for columns, names in (
        (kernel, ["bias", "mass_matrix", "gravity_torque"]),
        (columns_of_one, "mass_matrix"),
    ):
        assert columns.program == fb.kernel(again, names).program
    out = tuple(map(np.empty_like, found))
    assert all(a is b for a, b in zip(kernel(q[0, 0], qd, out=out), out, strict=True))
    assert all(map(np.array_equal, out, found))
    with pytest.raises(
        KernelError, match=r"^fb.kernel: 1 arguments given, expected 2: q\(9\), qd\(9\)\.$"
    ):
        kernel(q)


@pytest.mark.sample(1)
@pytest.mark.parametrize("model_name", MODELS)
def test_second_derivatives_are_differences_of_first_ones(model_name):
    model = MODELS[model_name]()
    q, qd, qdd = fb.random_state(model, seed=6)
    by_q_q, by_qd_q, by_qd_qd, M_q = several(
        model, "inverse_dynamics_second_derivatives", q, qd, qdd
    )

    def first(part):
        return lambda x: fb.inverse_dynamics_derivatives(model, x, qd, qdd)[part]

    scale = np.abs(by_q_q).max()
    for tensor, part in ((by_q_q, 0), (by_qd_q, 1), (M_q, 2)):
        np.testing.assert_allclose(
            tensor, difference_along(model, first(part), q), atol=1e-8 * scale
        )
    step = np.eye(model.nv)
    ahead, behind = (
        np.stack(
            [fb.inverse_dynamics_derivatives(model, q, qd + s * e, qdd)[1] for e in step], axis=-1
        )
        for s in (1, -1)
    )
    np.testing.assert_allclose(by_qd_qd, (ahead - behind) / 2, atol=1e-10 * scale)
    np.testing.assert_allclose(by_qd_qd, np.swapaxes(by_qd_qd, -1, -2), atol=1e-10 * scale)


def test_a_public_function_takes_scalars_and_matrices_as_well_as_vectors(monkeypatch):
    """As a new formula may have them."""

    def weighted(tree, option, q, reactions, h):
        return (tuple(h * x + reactions[1][0] for x in q),)

    formula = Formula(("q", "reactions", "h"), {"y": Output(("nq",), "what comes out")}, weighted)
    monkeypatch.setitem(FORMULAS, "weighted", formula)
    model, rng = fb.load("2R"), np.random.default_rng(1)
    for batch in ((), (5,), (4, 5)):
        q, w, h = rng.normal(size=(*batch, 2)), rng.normal(size=(*batch[1:], 2, 3)), 0.3
        expected = h * q + w[..., 1, :1]
        for _ in range(2):  # carefully, and by what was kept
            np.testing.assert_allclose(evaluate("weighted", model, (q, w, h)), expected, rtol=1e-15)
    q, w = np.zeros((5, 2)), np.zeros((2, 3))
    for given, words in (
        ((q, w[:1], 0.3), r"reactions has shape \(1, 3\), expected \(..., 2, 3\)"),
        ((q, w, np.zeros(4)), r"do not broadcast together: q \(5,\), reactions \(\), h \(4,\)"),
        ((q, w, np.nan), "weighted: h"),
        ((q, np.full((2, 3), np.inf), 0.3), "weighted: reactions"),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            evaluate("weighted", model, given)
