"""Generalized forces that no drive gives: counted as Jᵀ w is, at passive joints too."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, NotFiniteError, PassiveJointError, ShapeError
from support.branched import MODELS
from support.springs import K, loaded, springs

pytestmark = pytest.mark.usefixtures("numpy_kernels")

CLOSED = ("four_bar", "five_bar", "slider_crank")


@pytest.mark.parametrize("name", MODELS)
def test_they_are_counted_as_wrenches_are(name):
    model = MODELS[name]()
    q, qd, qdd = fb.random_state(model, seed=2, batch=(4,))
    w = np.random.default_rng(1).normal(size=(3, 1, 3 if model.dim == 2 else 6))
    frame = model.frame_names[-1]
    forces = np.einsum("...ji,...j->...i", fb.jacobian(model, q, frame=frame), w)
    tau = fb.inverse_dynamics(model, q, qd, qdd, {frame: w})
    np.testing.assert_allclose(fb.inverse_dynamics(model, q, qd, qdd, forces=forces), tau)
    assert tau.shape == (3, 4, model.nv)
    both = fb.inverse_dynamics(model, q, qd, qdd, {frame: w}, forces=forces)
    np.testing.assert_allclose(
        fb.forward_dynamics(model, q, qd, both, {frame: w}, forces), [qdd] * 3
    )


@pytest.mark.parametrize("name", CLOSED)
def test_in_closed_chains_they_act_at_passive_joints_too(name):
    """As the same torques do where each joint has a drive, and as springs of the model do."""
    model, (q, qd), forces = loaded(name)
    tau = np.zeros(model.nv)
    driven = list(model.driven)
    tau[driven] = forces[::-1][driven]
    every = model.replace(actuated=[*model.joint_names])
    qdd = fb.forward_dynamics(model, q, qd, tau, forces=forces)
    np.testing.assert_allclose(qdd, fb.forward_dynamics(every, q, qd, tau + forces), rtol=1e-12)
    np.testing.assert_allclose(
        fb.inverse_dynamics(model, q, qd, qdd, forces=forces), tau, atol=1e-9 * abs(tau).max()
    )
    elastic, pull = springs(model), K * (0.3 - q)
    torques = [
        fb.inverse_dynamics(elastic, q, qd, qdd),
        fb.inverse_dynamics(model, q, qd, qdd, forces=pull),
        fb.inverse_dynamics(model, q, qd, qdd, forces=[pull, pull], actuated=model.driven_names)[1],
    ]
    np.testing.assert_allclose(torques, [torques[0]] * 3, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        fb.forward_dynamics(model, q, qd, tau, forces=pull),
        fb.forward_dynamics(elastic, q, qd, tau),
        rtol=1e-9,
    )


@pytest.mark.parametrize("name", ["2R", "four_bar", "five_bar"])
def test_springs_between_links_change_the_reactions_of_loops_as_the_models_own_do(name):
    if name == "2R":
        model, q, qd = fb.load(name), np.array([0.3, 0.4]), np.array([1.0, 2.0])
    else:
        model, (q, qd), _ = loaded(name)
    elastic, pull = springs(model), K * (0.3 - q)
    expected = fb.reactions(elastic, q, qd, tau=np.zeros(model.nv))
    given = {"tau": np.zeros(model.nv)}, {"qdd": expected.qdd}
    for found in (fb.reactions(model, q, qd, forces=pull, **way) for way in given):
        np.testing.assert_allclose(found.qdd, expected.qdd, atol=1e-10)
        np.testing.assert_allclose(found.wrenches, expected.wrenches, atol=1e-9)
        np.testing.assert_allclose(found.tau, 0.0, atol=1e-9)
        assert found.balance < 1e-12


def test_a_passive_joint_of_an_open_chain():
    """A spring that swings the pendulum back needed `actuated=` before."""
    cart = fb.load("cart_pole")
    q, qd, tau = [0.1, 0.4], [0.2, 0.3], [1.0, 0.0]
    expected = fb.forward_dynamics(springs(cart), q, qd, tau)
    forces = dict(zip(cart.velocity_names, K * (0.3 - np.array(q)), strict=True))
    found = fb.forward_dynamics(cart, q, qd, tau, forces=forces)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    with pytest.raises(PassiveJointError):
        fb.forward_dynamics(cart, q, qd, [0.0, 1.0], forces=forces)


def test_of_a_family():
    family = fb.load("2R").bind(m2=np.linspace(1.0, 3.0, 4))
    q, qd, qdd = fb.random_state(family[0], seed=2, batch=(5, 1))
    forces = np.random.default_rng(1).normal(size=(4, 2))
    tau = fb.inverse_dynamics(family, q, qd, qdd)
    found = fb.inverse_dynamics(family, q, qd, qdd, forces=forces)
    np.testing.assert_array_equal(found, tau - forces)
    back = fb.forward_dynamics(family, q, qd, found, forces=forces)
    np.testing.assert_allclose(back, np.broadcast_to(qdd, back.shape), rtol=1e-9)


@pytest.mark.parametrize("name", ["2R", "four_bar"])
def test_forces_that_do_not_fit_are_refused_by_their_name(name):
    model = fb.load(name)
    q = fb.assemble(model, fb.neutral(model)) if model.loops else np.zeros(2)
    zero = np.zeros(model.nv)
    for function in (fb.inverse_dynamics, fb.forward_dynamics):
        at = [q, zero, zero]
        says = rf"^{function.__name__}: forces"
        with pytest.raises(ShapeError, match=rf"{says} has shape \(1,\)"):
            function(model, *at, forces=[1.0])
        with pytest.raises(NotFiniteError, match=f"{says} is nan for {model.velocity_names[0]!r}"):
            function(model, *at, forces=np.nan * zero)
        with pytest.raises(FreebodyError, match=r"broadcast together: .*forces \(3,\)"):
            function(model, *[np.stack([x] * 2) for x in at], forces=np.zeros((3, model.nv)))
