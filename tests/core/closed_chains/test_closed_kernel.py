"""The compiled forward dynamics of closed chains, for one state and many.

That nothing is compiled anew is seen by watching the entrance of the compiler.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.helpers import all_driven, numbers
from support.loop_scales import rate_scale, row_scale

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


@pytest.mark.sample(3)
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
    in_space = fb.kernel(model.to_space(), "forward_dynamics")(
        q, still, still
    )  # 10 equations of rank 4
    np.testing.assert_allclose(in_space, fb.forward_dynamics(model, q, still, still), rtol=1e-12)


def test_wrenches_on_frames():
    model = fb.load("five_bar")
    q, still = fb.assemble(model), np.zeros(model.nv)
    load = np.array([3.0, -2.0, 0.5])
    kernel = fb.kernel(model, "forward_dynamics", wrench_frames=["P"])
    expected = fb.forward_dynamics(model, q, still, still, wrenches={"P": load})
    np.testing.assert_allclose(kernel(q, still, still, load), expected, rtol=1e-12)


@pytest.mark.sample(3)
@pytest.mark.parametrize("every", [False, True], ids=["own drives", "all driven"])
@pytest.mark.parametrize("name", CLOSED)
def test_torques_of_the_drives_do_what_the_tree_needs(name: str, every: bool):
    """The same power in every motion that the loops allow, and no smaller torques do that: by
    singular values."""
    model = fb.load(name)
    model = all_driven(model) if every else model
    motion = fb.default_motion(model, samples=9)
    loads = np.random.default_rng(4).normal(size=(9, 3 if model.dim == 2 else 6))
    state = motion.q, motion.qd, motion.qdd
    found = fb.kernel(model, "inverse_dynamics", wrench_frames=[model.frame().name])(*state, loads)
    needed = fb.inverse_dynamics(model.opened, *state, loads)
    driven = [k for k, body in enumerate(model.bodies) if not body.joint.passive]
    driven = [k for b in driven for k in model.coordinates[b].v]
    assert not np.delete(found, driven, axis=-1).any()
    rates = rate_scale(model)
    for k in range(9):
        J = numbers(model, "constraint_jacobian", motion.q[k]) * rates
        _, s, Vt = np.linalg.svd(J)
        N = Vt[int((s > 1e-9 * s[0]).sum()) :].T
        least = np.linalg.pinv(N[driven].T) @ N.T @ (rates * needed[k])
        np.testing.assert_allclose(
            rates[driven] * found[k, driven], least, atol=1e-11 * np.abs(needed[k]).max()
        )
    np.testing.assert_allclose(
        fb.inverse_dynamics(model, *state, loads),
        found,
        rtol=0,
        atol=1e-13 * (1.0 + np.abs(found).max()),
    )
    held = fb.kernel(model, "static_torque")(motion.q)
    np.testing.assert_allclose(
        fb.static_torque(model, motion.q), held, rtol=0, atol=1e-13 * (1.0 + np.abs(held).max())
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "bricard", "double_four_bar", "flat", "stewart"])
def test_multipliers_are_the_smallest_that_do_what_the_drives_do_not(name: str):
    """By singular values; where equations depend on one another too. `flat`: ten equations of rank
    four, in space."""
    model = fb.load("double_four_bar").to_space() if name == "flat" else fb.load(name)
    motion = fb.default_motion(model, samples=9)
    found = fb.reactions(model, motion.q, motion.qd, qdd=motion.qdd)
    assert found.balance < 1e-12
    needed = fb.inverse_dynamics(model.opened, motion.q, motion.qd, motion.qdd)
    rows, rates = row_scale(model), rate_scale(model)
    slopes = numbers(model, "constraint_jacobian", motion.q)
    for k in range(9):
        J = rows[:, None] * slopes[k] * rates
        least = rows * (np.linalg.pinv(J.T, rcond=1e-9) @ (rates * (found.tau[k] - needed[k])))
        np.testing.assert_allclose(
            found.multipliers[k], least, rtol=0, atol=1e-10 * np.abs(least).max()
        )
        _, s, Vt = np.linalg.svd(J.T)
        loose = Vt[int((s > 1e-9 * s[0]).sum()) :]
        # a component is determined if no multipliers without power change it
        still = np.zeros(model.nv)
        wrenches = fb.kernel(model, "reaction_wrenches")
        change = wrenches(motion.q[k], still, still, rows * loose) - wrenches(
            motion.q[k], still, still, 0 * rows * loose
        )
        undisturbed = np.abs(change).max(axis=0, initial=0.0) < 1e-8
        np.testing.assert_array_equal(found.determined[k], undisturbed)


def test_a_formula_is_known_by_its_former_name_too():
    model = fb.load("five_bar")
    assert fb.kernel(model, "closed_wrenches") is fb.kernel(model, "reaction_wrenches")


@pytest.mark.parametrize("name", ["joint_wrenches", "mass_matrix_inverse"])
def test_what_leaves_loops_out_is_refused(name: str):
    with pytest.raises(fb.FreebodyError, match=f"kernel: {name}: 'five_bar' is a closed chain"):
        fb.kernel(fb.load("five_bar"), name)


def test_accelerations_near_a_singular_pose_are_right_or_nan():
    """A parallelogram, on its way to where it lies flat, by kernels alone: what rounding has taken
    is not told. One equation of the loop follows from another there."""
    model = fb.load("four_bar").bind(d=0.9, l2=0.9, l3=0.3)
    angle = np.logspace(0.0, -12.0, 121)
    q = np.stack([angle, -angle, angle], axis=-1)
    # M(t) ẗ + V'(t) = τ of one bar that turns twice and one that is carried along
    p = model.parameters
    inertia = p["I1"] + p["m1"] * p["lc1"] ** 2 + p["I3"] + p["m3"] * p["lc3"] ** 2
    inertia += p["m2"] * p["l1"] ** 2
    weight = (p["m1"] * p["lc1"] + p["m2"] * p["l1"] + p["m3"] * p["lc3"]) * p["g"]
    second = (1.0 - weight * np.cos(angle)) / inertia
    exact = np.stack([second, -second, second], axis=-1)
    for dtype, allowed, fewest in (("float64", 1e-5, 40), ("float32", 0.05, 20)):
        found = fb.kernel(model, "forward_dynamics", dtype=dtype)(
            q.astype(dtype), np.zeros(3, dtype), np.array([1.0, 0.0, 0.0], dtype)
        )
        told = np.isfinite(found).all(axis=-1)
        assert fewest <= told.sum() < 80
        off = np.abs(found[told] - exact[told]).max(axis=-1) / np.abs(exact[told]).max(axis=-1)
        assert off.max() < allowed
