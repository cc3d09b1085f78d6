"""Dry friction that sticks, and stops: times and heights in closed form, energy, momentum, the
limit of smooth friction, and what holds when several things change at once."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import freebody as fb
from freebody import FreebodyError, UnknownNameError
from support import generate

G = 9.81
T = np.linspace(0.0, 3.0, 31)


def sledge(coulomb: float, slope: float) -> fb.Model:
    """2 kg on an incline; gravity along and across its way."""
    drives = [fb.Drive(coulomb=coulomb)]
    model = fb.planar("P", l=[0], lc=[0], m=[2.0], I=[0], drives=drives)
    return model.replace(gravity=(-G * np.sin(slope), -G * np.cos(slope)))


def arm(coulomb: tuple[float, float] = (0.0, 0.0), **others) -> fb.Model:
    drives = [fb.Drive(coulomb=c) for c in coulomb]
    lengths = {"l": [0.4, 0.3], "lc": [0.2, 0.15], "m": [2.0, 1.0], "I": [0.03, 0.01]}
    return fb.planar("RR", **lengths, drives=drives, **others)


STOPPED = arm((0.6, 0.3), limits=[(-2.5, 1.0), (-1.5, 1.5)])


@pytest.mark.parametrize("options", [{}, {"step": 0.05}])
def test_a_block_slides_up_an_incline_stops_at_the_exact_time_and_sticks_or_slides_back(options):
    slope, speed = 0.3, 2.0
    for mu in (0.5, 0.2):
        pull, rub = G * np.sin(slope), mu * G * np.cos(slope)
        stop, top = speed / (pull + rub), 0.5 * speed**2 / (pull + rub)
        t = [0.0, stop - 1e-11, stop + 1e-11, 1.0]
        run = fb.simulate(sledge(2.0 * rub, slope), [0], [speed], t, friction="dry", **options)
        back = max(0.0, pull - rub)  # what is left when friction turns round
        assert run.q.values[2, 0] == pytest.approx(top, abs=1e-13)
        assert run.qd.values[1, 0] == pytest.approx(1e-11 * (pull + rub), rel=1e-3)
        assert abs(run.qd.values[2, 0]) <= (1e-11 * back) * 1.01
        assert run.q.values[3, 0] == pytest.approx(top - 0.5 * back * (1.0 - stop) ** 2, abs=1e-12)
        assert run.qdd.values[[0, 3], 0] == pytest.approx([-pull - rub, -back], abs=1e-12)
        assert (run.qd.values[3, 0] == 0.0) == (rub > pull)
    assert run.attrs["dry_friction"] == "c sign(q̇), sticking at rest"


def test_a_pendulum_loses_what_friction_takes_of_each_half_swing_and_comes_to_rest():
    load, c = 1.5 * G * 0.8, 0.7
    pendulum = fb.planar("R", l=[0.8], lc=[0.8], m=[1.5], I=[0], drives=[fb.Drive(coulomb=c)])
    ends, at = [1.2], 1.2
    while load * np.sin(at) > c:
        at = brentq(
            lambda x, at=at: load * (np.cos(x) - np.cos(at)) - c * (at + x),
            1e-7 - at,
            at,
            xtol=1e-15,
        )
        ends.append(at)
    run = fb.simulate(pendulum, [1.2 - np.pi / 2], [0], [0, 9, 12], friction="dry")
    # the last swing ends on the side of the first for an even number of them
    assert run.q.values[1:, 0] + np.pi / 2 == pytest.approx(
        (-1.0) ** (len(ends) - 1) * at, abs=1e-9
    )
    assert len(ends) > 8
    assert (run.qd.values[1:] == 0.0).all()
    assert (run.qdd.values[1:] == 0.0).all()


def test_a_ball_rebounds_to_e_to_the_2n_of_its_height_and_lies_still_at_last():
    e, fall = 0.7, np.sqrt(2.0 / G)
    ball = fb.planar("P", l=[0], lc=[0], m=[2], I=[0], limits=[(0, 9)]).replace(gravity=(-G, 0))
    tops = [fall * (1 + 2 * sum(e**k for k in range(1, n)) + e**n) for n in range(1, 8)]
    t = [0.0, *tops, 4.0]
    run = fb.simulate(ball, [1.0], [0.0], t, restitution=e)
    assert run.q.values[1:-1, 0] == pytest.approx([e ** (2 * n) for n in range(1, 8)], abs=1e-12)
    last = [run[name].values[-1, 0] for name in ("q", "qd", "qdd")]
    assert last == [0.0, 0.0, 0.0]
    assert "stops" in run.attrs
    soft = fb.simulate(ball, [[1.0], [2.0]], [0.0], t, restitution=[[0.0], [1.0]])
    assert soft.q.values[0, 2:, 0] == pytest.approx(0.0, abs=0)
    energy = (soft.kinetic_energy + soft.potential_energy).values[1]
    assert energy == pytest.approx(energy[0], rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_that_is_passed_and_left_again_within_one_step_is_seen(side):
    limits = sorted([-9.0 * side, 0.05 * side])
    ball = fb.planar("P", l=[0], lc=[0], m=[2], I=[0], limits=[limits])
    thrown = fb.simulate(
        ball.replace(gravity=(-G * side, 0)), [0], [side], [0, 0.3], step=0.3, restitution=0.5
    )
    speed = np.sqrt(1.0 - 2.0 * G * 0.05)
    left = 0.3 - (1.0 - speed) / G
    expected = 0.05 - 0.5 * speed * left - 0.5 * G * left**2
    assert thrown.q.values[-1, 0] == pytest.approx(side * expected, abs=1e-12)


def test_dry_friction_is_the_limit_of_smooth_friction():
    model, state = arm((0.6, 0.3)), ([0.5, 0.3], [0.0, 0.0])
    dry = fb.simulate(model, *state, T, friction="dry")
    apart = []
    for width in (1e-2, 1e-3):
        smooth = fb.simulate(model, *state, T, friction_width=width, tolerance=1e-7)
        apart.append(np.abs(smooth.q.values - dry.q.values).max())
    assert apart[1] < 1e-3
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=0.3)


def test_what_rests_is_let_go_by_each_swing_of_a_torque():
    """Nothing moves while it sticks, so that the error of its state lets steps grow without end."""
    a, c, w = 1.2, 1.0, 40.0
    begun = np.arcsin(c / a) / w
    end = brentq(lambda t: a / w * (np.cos(w * begun) - np.cos(w * t)) - c * (t - begun), 0.05, 0.1)
    assert end < np.pi / w
    way = a / w * np.cos(w * begun) * (end - begun) - 0.5 * c * (end - begun) ** 2
    way -= a / w**2 * (np.sin(w * end) - np.sin(w * begun))
    law = fb.compile(lambda t: [a * fb.math.sin(w * t)], {"t": ()}, {"tau": 1})
    block = fb.planar("P", l=[0], lc=[0], m=[1], I=[0], drives=[fb.Drive(coulomb=c)])
    block = block.replace(gravity=0.0)
    for torque in (law, lambda t, q, qd: np.array([a * np.sin(w * t)])):
        run = fb.simulate(
            block, [0], [0], [0, 4 * np.pi / w, 9 * np.pi / w], torque, friction="dry"
        )
        assert run.q.values[:, 0] == pytest.approx([0.0, 0.0, way], abs=1e-12)
        assert (run.qd.values == 0.0).all()
    # a stop that presses holds just as little
    floor = fb.planar("P", l=[0], lc=[0], m=[1], I=[0], limits=[(0, 9)]).replace(gravity=0.0)
    law = fb.compile(lambda t: [-fb.math.cos(w * t)], {"t": ()}, {"tau": 1})
    run = fb.simulate(floor, [0], [0], [0, 0.5], law, restitution=0.0)
    left = 0.5 * np.pi / w  # goes when the push is over; ever after what it gained carries it
    gone = (0.5 - left) / w + (np.cos(w * 0.5) - np.cos(w * left)) / w**2
    assert run.q.values[-1, 0] == pytest.approx(gone, abs=1e-10)
    # a torque that jumps while it holds stops nothing
    law = fb.compile(lambda t: [0.5 * fb.math.sign(fb.math.sin(9.0 * t))], {"t": ()}, {"tau": 1})
    run = fb.simulate(block, [0], [0], [0, 2.0], law, friction="dry")
    assert run.q.values[-1] == run.qd.values[-1] == 0.0


def test_what_slides_rests_between_two_steps_that_both_find_it_sliding():
    """q̇ = (t - 0.5)² - 0.01 up to its rest at 0.4 s; let go at 0.5 s: (t - 0.5)² from there."""
    law = fb.compile(lambda t: [1.0 + 2.0 * (t - 0.5)], {"t": ()}, {"tau": 1})
    block = fb.planar("P", l=[0], lc=[0], m=[1], I=[0], drives=[fb.Drive(coulomb=1.0)])
    block = block.replace(gravity=0.0)
    for options in ({}, {"step": 1.0}):
        run = fb.simulate(block, [0], [0.24], [0.0, 1.0], law, friction="dry", **options)
        way = (0.5**3 - 0.1**3) / 3 - 0.004 + 0.5**3 / 3
        assert [run.qd.values[-1, 0], run.q.values[-1, 0]] == pytest.approx([0.25, way], abs=1e-12)
        back = fb.simulate(  # the same the other way round, among others that nothing cuts
            block, [[0.0], [0.0]], [[-0.24], [9.0]], [0.0, 1.0],
            np.array([[[0.0], [-2.0]], [[0.0], [-2.0]]]), friction="dry", **options,
        )  # fmt: skip
        assert back.qd.values[0, -1] == pytest.approx(-0.25, abs=1e-12)


def test_an_impact_changes_no_momentum_but_that_of_the_joint_that_is_stopped():
    model = arm(limits=[(-9, 9), (-0.5, 0.5)]).replace(gravity=0)
    q, qd = np.array([0.3, 0.5]), np.array([0.7, 2.0])  # moving into the stop
    M = fb.mass_matrix(model, q)
    for e in (0.0, 0.5, 1.0):
        run = fb.simulate(model, q, qd, [0, 1e-9], restitution=e, record=("q", "qd"))
        after = run.qd.values[1]
        assert after[1] == pytest.approx(-2.0 * e, abs=1e-7)
        assert M[0] @ after == pytest.approx(M[0] @ qd, abs=1e-7)
        lost = 0.5 * (qd @ M @ qd - after @ M @ after)
        assert lost == pytest.approx(0.5 * (1 - e**2) * 2.0**2 / np.linalg.inv(M)[1, 1], abs=1e-7)
    run = fb.simulate(model, [0.3, 0.0], qd, T, restitution=1.0)
    spin = np.einsum("ti,ti->t", fb.mass_matrix(model, run.q.values)[:, 0], run.qd.values)
    assert spin == pytest.approx(spin[0], abs=1e-8)
    assert run.kinetic_energy.values == pytest.approx(run.kinetic_energy.values[0], rel=1e-8)


def test_a_joint_that_sticks_is_let_go_when_the_torque_reaches_its_friction():
    model = arm((0.6, 0.3)).replace(gravity=0)
    t = np.linspace(0.0, 1.0, 11)
    ramp = t[:, None] * [
        1.2,
        0.0,
    ]  # the first joint goes at 0.5 s, the second sticks a while longer
    run = fb.simulate(model, [0.0, 1.0], [0, 0], t, ramp, friction="dry")
    M = fb.mass_matrix(model, [0.0, 1.0])
    assert (run.qd.values[:6] == 0.0).all()
    assert run.qd.values[6, 0] > 0.0
    together = 1.2 * 0.1 / M[0, 0]  # the second joint is carried along as a rigid part
    assert run.qdd.values[6] == pytest.approx([together, 0.0], rel=1e-3)
    assert run.qd.values[6, 0] == pytest.approx(0.5 * together * 0.1, rel=1e-3)
    taken = run.tau.values - fb.inverse_dynamics(
        model.without("friction"), run.q.values, run.qd.values, run.qdd.values
    )
    assert (np.abs(taken) <= np.array([0.6, 0.3]) + 1e-9).all()  # what friction took of the torque
    moving = run.qd.values != 0.0
    friction = np.broadcast_to([0.6, 0.3], moving.shape) * np.sign(run.qd.values)
    assert taken[moving] == pytest.approx(friction[moving], abs=1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize("options", [{}, {"step": 0.01}, {"method": "semi-implicit", "step": 0.01}])
def test_many_are_those_of_each_and_none_leaves_its_range(options):
    q, qd, _ = fb.random_state(STOPPED, 3, (8,))
    low, high = STOPPED.limits.lower, STOPPED.limits.upper
    q = np.clip(q, low, high)
    options = {"friction": "dry", "restitution": 0.3, **options}
    many = fb.simulate(STOPPED, q, qd, T[:11], **options)
    shared = fb.simulate(STOPPED, q, qd, T[:11], threads=2, **options)
    for name in ("q", "qd", "qdd"):
        assert np.array_equal(many[name].values, shared[name].values)
        one = fb.simulate(STOPPED, q[5], qd[5], T[:11], **options)
        assert np.array_equal(many[name].values[5], one[name].values)
    assert ((many.q.values >= low) & (many.q.values <= high)).all()
    assert (many.qd.values == 0.0).any()


def test_a_function_a_law_and_a_sampled_controller():
    q, qd, push = [0.5, 0.3], [0.0, 0.0], np.array([0.4, -0.2])
    options = {"friction": "dry", "restitution": 0.5}
    whole = fb.simulate(STOPPED, q, qd, T[:11], push, **options)
    law = fb.compile(lambda qd: [0.4 + 0.0 * x for x in qd[:1]] + [-0.2], {"qd": 2}, {"tau": 2})
    sampled = options | {"sample_time": 0.1, "tolerance": 1e-9}
    for torque, more in (
        (lambda t, q, qd: push, options),
        (law, options),
        (lambda *_: push, sampled),
    ):
        run = fb.simulate(STOPPED, q, qd, T[:11], torque, **more)
        assert np.abs(run.q.values - whole.q.values).max() < 1e-8


def test_a_family_has_its_own_friction_and_stops():
    names = {"joint1.friction.coulomb": [0.6, 0.9], "joint2.limits.lower": [-1.5, -0.2]}
    names = {k: np.array(v) for k, v in names.items() if k in fb.parameters(STOPPED)}
    assert names
    family = STOPPED.bind(names)
    options = {"friction": "dry", "restitution": 0.2}
    both = fb.simulate(family, [0.5, 0.3], [0, 0], T[:11], **options)
    for k in range(2):
        one = fb.simulate(family[k], [0.5, 0.3], [0, 0], T[:11], **options)
        assert np.abs(one.q.values - both.q.values[k]).max() < 1e-12


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [7, 13])
def test_stops_of_any_joints_and_followers_keep_energy_or_take_it(seed: int):
    model = generate.model(seed, 2).without("friction")
    low, high = model.limits.lower, model.limits.upper
    assert model.nq == model.nv == len(low)  # in the plane each position has its range
    q, qd, _ = fb.random_state(model, seed)
    q = np.clip(q, low, high)
    both = fb.simulate(model, q, qd, T[:11], restitution=[[1.0] * model.nv, [0.4] * model.nv])
    energy = (both.kinetic_energy + both.potential_energy).values
    assert np.ptp(energy[0]) < 1e-8
    assert np.diff(energy[1]).max() < 1e-9
    assert energy[1, -1] < energy[1, 0] - 0.1  # there were impacts
    assert ((both.q.values >= low) & (both.q.values <= high)).all()


REFUSED = [
    ({"friction": "sticky"}, UnknownNameError, "no model of friction 'sticky'"),
    ({"restitution": 1.5}, FreebodyError, r"restitution is 1\.5, expected from 0 .* to 1"),
    ({"restitution": np.nan}, FreebodyError, "restitution is nan"),
    ({"friction": "dry", "method": "Radau"}, FreebodyError, "method 'Radau' has none"),
    ({"friction": "dry", "method": "implicit"}, FreebodyError, "method 'implicit' has none"),
]


@pytest.mark.parametrize(("options", "kind", "words"), REFUSED)
def test_what_is_refused(options, kind, words):
    with pytest.raises(kind, match=words):
        fb.simulate(STOPPED, [0.0, 0.0], [0, 0], T, **options)


def test_starts_behind_a_stop_closed_chains_and_functions_of_many_are_refused():
    with pytest.raises(FreebodyError, match=re.escape("q is 1.7 for 'joint2' at sample 1, above")):
        fb.simulate(STOPPED, [[0, 0], [0, 1.7]], [0, 0], T, restitution=0.0)
    linkage = fb.load("five_bar")
    with pytest.raises(FreebodyError, match="several joints hold one motion"):
        fb.simulate(linkage, fb.assemble(linkage), np.zeros(4), T, friction="dry")
    with pytest.raises(FreebodyError, match=r"compile the torque with fb\.compile"):
        fb.simulate(STOPPED, np.zeros((2, 2)), [0, 0], T, lambda t, q, qd: 0 * q, friction="dry")
