"""Linearisation about a state, in continuous and discrete time, and the regulator made of it."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


@pytest.mark.parametrize("name", ["2R", "cart_pole"])
def test_a_and_b_are_the_slopes_of_the_motion(name):
    model = fb.load(name)
    q, qd, _ = fb.random_state(model, seed=2)
    tau, drives, n = np.zeros(model.nv), list(model.driven), model.nv
    tau[drives] = 0.7
    A, B = fb.linearize(model, q, qd, tau)

    def rates(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        torque = tau.copy()
        torque[drives] += u
        qdd = fb.forward_dynamics(model, q + x[:n], qd + x[n:], torque)
        return np.concatenate([qd + x[n:], qdd])

    e, none = 1e-6, np.zeros(len(drives))
    along = [(rates(e * x, none) - rates(-e * x, none)) / (2 * e) for x in np.eye(2 * n)]
    np.testing.assert_allclose(A, np.transpose(along), rtol=1e-6, atol=1e-6)
    still = np.zeros(2 * n)
    by_u = [(rates(still, e * u) - rates(still, -e * u)) / (2 * e) for u in np.eye(len(drives))]
    np.testing.assert_allclose(B, np.transpose(by_u), rtol=1e-6, atol=1e-6)


def test_discrete_time_is_a_step_of_the_simulation():
    model, h, e = fb.load("2R"), 0.02, 1e-6
    q = np.array([0.4, -0.6])
    tau = fb.gravity_torque(model, q)
    A, B = fb.linearize(model, q, np.zeros(2), tau, h)
    step = fb.kernel(model, "rk4_step")
    for k, x in enumerate(e * np.eye(4)):
        ends = [np.concatenate(step(q + s * x[:2], s * x[2:], tau, h)) for s in (1, -1)]
        np.testing.assert_allclose((ends[0] - ends[1]) / (2 * e), A[:, k], atol=2e-6)
    for k, u in enumerate(e * np.eye(2)):
        ends = [np.concatenate(step(q, np.zeros(2), tau + s * u, h)) for s in (1, -1)]
        np.testing.assert_allclose((ends[0] - ends[1]) / (2 * e), B[:, k], atol=2e-6)
    many = fb.linearize(model, np.stack([q, 2 * q]), np.zeros(2), tau, h)
    np.testing.assert_allclose(many[0][0], A, rtol=1e-13, atol=1e-15)
    assert many[1].shape == (2, 4, 2)


def test_the_regulator_balances_a_pole_and_no_other_gain_costs_less():
    model, h = fb.load("cart_pole"), 0.01
    q = upright(model)
    A, B = fb.linearize(model, q, np.zeros(2), np.zeros(2), h)
    assert np.abs(np.linalg.eigvals(A)).max() > 1.0  # it falls
    Q, R = np.diag([1.0, 10.0, 1.0, 1.0]), np.array([[0.1]])
    K = fb.discrete_lqr(A, B, Q, R)
    assert K.shape == (1, 4)

    def cost(gain: np.ndarray) -> float:
        x, total = np.array([0.1, 0.05, 0.0, -0.1]), 0.0
        for _ in range(3000):
            u = -gain @ x
            total += float(x @ Q @ x + u @ R @ u)
            x = A @ x + B @ u
        return total

    best = cost(K)
    rng = np.random.default_rng(0)
    assert all(cost(K * (1.0 + 0.05 * rng.normal(size=4))) > best for _ in range(8))

    def hold(t: float, at: np.ndarray, qd: np.ndarray) -> np.ndarray:
        tau = np.zeros(2)
        tau[list(model.driven)] = -K @ np.concatenate([at - q, qd])
        return tau

    start = q + np.array([0.1, 0.15])
    run = fb.simulate(
        model, start, np.zeros(2), [0.0, 8.0], hold, sample_time=h, tolerance=1e-6, record="q"
    )
    assert np.abs(run.q.values[-1] - q).max() < 1e-2


def upright(model: fb.Model) -> np.ndarray:
    """Where the pole's potential energy is highest, at rest."""
    turns = np.linspace(-np.pi, np.pi, 5)
    heights = [float(fb.potential_energy(model, [0.0, a])) for a in turns]
    return np.array([0.0, turns[int(np.argmax(heights))]])


def test_what_has_no_answer_is_refused():
    model, one = fb.load("2R"), np.eye(2)
    with pytest.raises(fb.FreebodyError, match="linearised at rest alone"):
        fb.linearize(fb.load("quadrotor"), *fb.random_state(fb.load("quadrotor"), 0))
    with pytest.raises(fb.FreebodyError, match="step is -1, expected a number of seconds above 0"):
        fb.linearize(model, [0, 0], [0, 0], [0, 0], -1)
    with pytest.raises(fb.FreebodyError, match=r"least eigenvalue of R is -1.*above 0"):
        fb.discrete_lqr(one, one, one, -one)
    with pytest.raises(fb.FreebodyError, match="Q is not symmetric"):
        fb.discrete_lqr(one, one, [[1, 1], [0, 1]], one)
    with pytest.raises(fb.FreebodyError, match="no feedback stabilises this"):
        fb.discrete_lqr(2.0 * one, [[1.0], [0.0]], one, [[1.0]])
    for Q in (np.zeros((2, 2)), np.diag([0.0, 1.0])):  # a position without weight drifts
        with pytest.raises(fb.FreebodyError, match="no feedback stabilises this"):
            fb.discrete_lqr([[1.0, 0.01], [0.0, 1.0]], [[0.0], [0.01]], Q, [[1.0]])
    with pytest.raises(fb.FreebodyError, match="discrete_lqr"):
        fb.discrete_lqr(one, np.ones((3, 1)), one, [[1.0]])
