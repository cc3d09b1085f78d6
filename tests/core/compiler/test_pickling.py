"""Models, kernels and errors go to other processes and come back the same."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import freebody as fb
from freebody import errors
from freebody.model.joints import KINDS
from freebody.targets.llvm.machine import CompileError


def again(thing):
    return pickle.loads(pickle.dumps(thing))


def test_a_model_that_was_used():
    model = fb.planar("RP", l=[1, 0], lc=[0.5, 0.1], m=[1, 2], I=[0.1, 0.2])
    q, qd, qdd = fb.random_state(model, 1, 3)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    for other in (again(model), copy.copy(model), copy.deepcopy(model)):
        assert not other.compiled  # machine code of another process is no use here
        assert np.array_equal(fb.inverse_dynamics(other, q, qd, qdd), tau)
        assert other.parameters == model.parameters


@pytest.mark.parametrize("name", fb.models())
def test_bundled_models(name: str):
    model = fb.load(name, physical="ignore")
    assert repr(again(model)) == repr(model)
    assert [body.kind is KINDS[body.joint.kind] for body in again(model).bodies] == [True] * len(
        model.bodies
    )


@pytest.mark.parametrize("target", ["cpu", "numpy"])
def test_a_kernel(target: str):
    kernel = fb.kernel(fb.load("2R"), ["mass_matrix", "bias"], target=target)
    q = np.array([[0.1, 0.2], [0.3, 0.4]])
    other = again(kernel)
    assert (other.target, other.width, other.signature) == (
        kernel.target,
        kernel.width,
        kernel.signature,
    )
    for x, y in zip(other(q, q), kernel(q, q), strict=True):
        assert np.array_equal(x, y)


@pytest.mark.parametrize(
    "error",
    [
        errors.ShapeError("mass_matrix", "q", (3,), "(..., 2)", "model 'arm' has nq = 2"),
        errors.NotFiniteError("mass_matrix", "q", float("nan"), "at sample 3"),
        errors.UnknownNameError("frame", "forearn", "'arm'", ["forearm"]),
        errors.MissingValueError("the mass", ["m1"]),
        errors.ModelError("no"),
        errors.SingularError("no"),
        errors.FileError("arm.urdf", 3, "no"),
        CompileError("no"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_errors(error: errors.FreebodyError):
    other = again(error)
    assert (type(other), str(other), vars(other)) == (type(error), str(error), vars(error))
