"""The compiled forward dynamics of closed chains, for one state and many."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.trees.passive import all_driven

CLOSED = [
    "four_bar",
    "slider_crank",
    "five_bar",
    "five_bar_rods",
    "double_four_bar",
    "3RRR",
    "bricard",
    "stewart",
]


@pytest.mark.parametrize("name", CLOSED)
def test_a_kernel_is_the_function(name: str):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=33)
    tau = np.random.default_rng(0).normal(size=motion.qd.shape)
    found = fb.kernel(model, "forward_dynamics")(motion.q, motion.qd, tau)
    expected = fb.forward_dynamics(
        all_driven(model), motion.q, motion.qd, tau
    )  # it refuses a torque on passive joints
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_dependent_equations_are_left_out_of_the_kernel():
    model = fb.load("double_four_bar")
    q, still = fb.assemble(model), np.zeros(model.nv)
    in_space = fb.kernel(model.to_space(), "forward_dynamics")(q, still, still)  # 10 equations of rank 4
    np.testing.assert_allclose(in_space, fb.forward_dynamics(model, q, still, still), rtol=1e-12)


def test_wrenches_on_frames():
    model = fb.load("five_bar")
    q, still = fb.assemble(model), np.zeros(model.nv)
    load = np.array([3.0, -2.0, 0.5])
    kernel = fb.kernel(model, "forward_dynamics", wrench_frames=["P"])
    expected = fb.forward_dynamics(model, q, still, still, wrenches={"P": load})
    np.testing.assert_allclose(kernel(q, still, still, load), expected, rtol=1e-12)


@pytest.mark.parametrize("name", ["inverse_dynamics", "static_torque", "mass_matrix_inverse"])
def test_what_leaves_loops_out_is_refused(name: str):
    with pytest.raises(fb.FreebodyError, match=f"kernel: {name}: 'five_bar' is a closed chain"):
        fb.kernel(fb.load("five_bar"), name)
