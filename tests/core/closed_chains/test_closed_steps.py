"""Step kernels of closed chains: orders, loops that stay closed, printed numbers, lanes that cannot
go on."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from support.double_four_bar import TIP, cranks
from support.stepping import METHODS, State, apart, walk


def swing(name: str) -> tuple[Model, State, np.ndarray]:
    """A mechanism without Coulomb friction on its way, and a torque of its drives."""
    model = fb.load(name).without("friction")
    motion = fb.default_motion(model, samples=33)
    torque = np.where(np.isin(model.velocity_names, model.driven_names), 0.3, 0.0)
    return model, (motion.q[8], motion.qd[8]), torque


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["four_bar", "five_bar", "bricard"])
def test_order(name: str):
    model, start, tau = swing(name)
    true = fb.simulate(model, *start, [0, 0.2], tau, tolerance=1e-13)
    end = true["q"].values[-1], true["qd"].values[-1]
    for method, order in METHODS.items():
        rough, fine = (apart(model, walk(model, method, start, tau, 0.2, n), end) for n in (20, 40))
        assert np.log2(rough / fine) == pytest.approx(order, abs=0.25), method


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name",
    [
        "four_bar",
        "five_bar",
        "bricard",
        "slider_crank",
        pytest.param("stewart", marks=pytest.mark.long),
    ],
)
def test_ten_thousand_steps(name: str):
    """Swinging freely for 10 s: loops stay closed, and of order 4 the energy stays too."""
    model, state, _ = swing(name)
    still = np.zeros(model.nv)
    loops = fb.kernel(model, ["constraint", "constraint_rate"])
    step = fb.kernel(model, "rk4_step")
    energy = fb.kernel(model, ["kinetic_energy", "potential_energy"])
    before, gaps, moving = sum(energy(*state)), [], 0.0
    for k in range(10_000):
        state = step(*state, still, 1e-3)
        if k % 100 == 0:
            gaps.append([np.abs(x).max() for x in loops(*state)])
            moving = max(moving, float(energy(*state)[0]))
    assert np.max(gaps, axis=0)[0] < 1e-12
    assert np.max(gaps, axis=0)[1] < 1e-10
    # the motion is chaotic: starts that differ by 1e-13 end with 6e-7 to 1.1e-6
    assert abs(sum(energy(*state)) - before) < 3e-6 * moving


def test_double_four_bar_to_its_tenth_second():
    """IFToMM library: ten times through the stretched position, where the loops lose rank by
    two."""
    model = fb.load("double_four_bar")
    state, still = cranks(np.pi / 2, -1.0), np.zeros(5)
    for start, (end, tip) in zip((0.0, 4.0), TIP.items(), strict=True):
        state = walk(model, "rk4_step", state, still, end - start, round(1000 * (end - start)))
        theta = state[0][0]
        assert np.abs(np.array([np.cos(theta), np.sin(theta)]) - tip).max() < 1e-10


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", METHODS)
def test_dependent_equations_are_left_out(method: str):
    plane = fb.load("double_four_bar")
    state, tau = cranks(1.0, 0.4), np.array([1.0, 0, 0, 0, 0])
    there = walk(plane, method, state, tau, 0.3, 30)
    in_space = walk(plane.to_space(), method, state, tau, 0.3, 30)  # 10 equations of rank 4
    assert apart(plane, there, in_space) < 1e-11


def test_a_lane_that_cannot_go_on_is_nan_alone():
    """Stretched, or nearly so, other equations would have to count; and a loop that is wide open
    does not close."""
    model = fb.load("double_four_bar")
    states = [cranks(theta, 0.5) for theta in (1.0, 1e-3, 0.0, 1e-7, 1.0)]
    q, qd = (np.stack(x) for x in zip(*states, strict=True))
    q[4, 3] += 0.1
    for method in METHODS:
        step = fb.kernel(model, method)
        q1, qd1 = step(q, qd, np.zeros(5), 1e-9)
        assert np.isnan(q1[2:]).all()
        assert np.isnan(qd1[2:]).all()
        for k in (0, 1):
            np.testing.assert_array_equal(q1[k], step(q[k], qd[k], np.zeros(5), 1e-9)[0])
            assert apart(model, (q1[k], qd1[k]), (q[k], qd[k])) < 1e-7


def test_a_slightly_open_loop_is_closed_at_rest():
    model = fb.load("five_bar")
    q = fb.assemble(model) + [1e-6, 0, 0, 0]
    q1, _ = fb.kernel(model, "rk4_step")(q, np.zeros(4), np.zeros(4), 1e-12)
    gap = fb.kernel(model, "constraint")
    assert np.abs(gap(q)).max() > 1e-7
    assert np.abs(gap(q1)).max() < 1e-11


def test_stiff_feedback_of_the_drives():
    """A five-bar held by its two drives, however stiff; what sags is what static torques ask
    for."""
    model = fb.load("five_bar")
    q = fb.assemble(model)
    driven = np.isin(model.velocity_names, model.driven_names)
    step, still = fb.kernel(model, "implicit_feedback_step"), np.zeros(model.nv)
    for kp in (1e4, 1e8, 1e12):
        state = q, still
        for _ in range(300):
            state = step(*state, still, 0.01, q, still, kp * driven, 1e-2 * kp * driven)
        sag = fb.difference(model, q, state[0])[driven]
        np.testing.assert_allclose(-kp * sag, fb.static_torque(model, state[0])[driven], rtol=1e-3)
        assert np.abs(state[1]).max() < 1e-6
