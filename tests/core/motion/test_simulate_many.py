"""Many motions at once: the same as one after another, orders of the methods, exact impulses, what
is recorded, refused and told."""

from __future__ import annotations

import re
import signal
import threading
from functools import partial
from unittest.mock import Mock

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, FreebodyWarning, ShapeError, UnknownNameError
from freebody.math import less
from support import generate
from support.robots import Joint, Link, Placement, Robot, Shift, loaded

T = np.linspace(0.0, 0.1, 6)
ROD = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.75], g=0)  # 1 kg m² about its pin
STEPS = ("rk4", "semi-implicit", "implicit")


def arm(**friction: float) -> fb.Model:
    drives = [fb.Drive(**friction), fb.Drive()]
    lengths = {"l": [0.4, 0.3], "lc": [0.2, 0.15], "m": [2.0, 1.0], "I": [0.03, 0.01]}
    return fb.planar("RR", **lengths, drives=drives)


ARM = arm(viscous=0.1, coulomb=0.2)
WIDE = {"friction_width": 0.5}  # so that nothing is stiff
Q, QD, TAU = fb.random_state(ARM, 3, (4,))


def law(t, q, qd, goal, gain):
    return [gain * (g - x) - 0.3 * v + t for x, v, g in zip(q, qd, goal, strict=True)]


LAW = fb.compile(law, {"t": (), "q": 2, "qd": 2, "goal": 2, "gain": ()}, {"tau": 2})
GOAL = Q[::-1]


def python(k: int):
    """The same for one motion."""
    return lambda t, q, qd: 5.0 * (GOAL[k] - q) - 0.3 * qd + t


def alone(k: int, torque=None, **options) -> np.ndarray:
    """Oracle: the states of one motion under error control."""
    found = fb.simulate(ARM, Q[k], QD[k], T, torque, method="DOP853", **WIDE, **options)
    return np.concatenate([found.q.values, found.qd.values], axis=-1)


def together(torque=None, **options) -> np.ndarray:
    found = fb.simulate(ARM, Q, QD, T, torque, **(WIDE | options))
    return np.concatenate([found.q.values, found.qd.values], axis=-1)


# ---------------------------------------------------------------- the same as one after another
def test_many_motions_are_those_of_each():
    rows = np.random.default_rng(0).normal(size=(4, len(T), 2))
    cases = {
        "nothing": (None, lambda k: None, {}),
        "table": (rows, lambda k: rows[k], {}),
        "constant": (TAU[:, None], lambda k: TAU[k], {}),
        "compiled": (LAW, python, {"torque_inputs": {"goal": GOAL, "gain": 5.0}}),
        "function": (lambda t, q, qd: 5.0 * (GOAL - q) - 0.3 * qd + t, python, {}),
    }
    for name, (torque, each, more) in cases.items():
        expected = np.stack([alone(k, each(k)) for k in range(4)])
        for method in ("auto", "rk4", "DOP853"):
            if (name, method) == ("function", "DOP853"):
                continue
            fine = {"step": 5e-4} if method == "rk4" else {}
            found = together(torque, method=method, **fine, **more)
            np.testing.assert_allclose(found, expected, rtol=0, atol=2e-9, err_msg=name)


def test_a_result_does_not_depend_on_what_is_beside_it_or_on_threads(monkeypatch):
    model = fb.load("2R")
    q, qd, tau = fb.random_state(model, 1, (600,))

    def run(some: slice, **more) -> np.ndarray:
        start = q[some], qd[some], [0, 0.02], tau[some, None]
        return fb.simulate(model, *start, record="q", **more).q.values

    for more in ({"step": 1e-3}, {}):
        whole = run(slice(None), threads=1, **more)
        np.testing.assert_array_equal(run(slice(None), threads=3, **more), whole)
        np.testing.assert_array_equal(run(slice(5, 18), **more), whole[5:18])
        with monkeypatch.context() as browser:
            browser.setattr(threading.Thread, "start", Mock(side_effect=RuntimeError("no thread")))
            np.testing.assert_array_equal(run(slice(None), threads=3, **more), whole)


def test_batches_broadcast_and_a_family_has_its_own_dimension():
    family = ARM.bind({"link2.mass": [1.0, 1.5, 2.0]})
    found = fb.simulate(family, Q[:, None], QD[:, None], T, step=1e-3, **WIDE)
    assert found.q.dims == ("sample", "member", "time", "position")
    assert found.sizes["sample"] == 4
    assert found.sizes["member"] == 3
    for k, i in ((0, 0), (3, 2)):
        one = fb.simulate(family[i], Q[k], QD[k], T, step=1e-3, **WIDE)
        assert one.q.dims == ("time", "position")
        for name in one.data_vars:
            np.testing.assert_allclose(found[name].values[k, i], one[name], rtol=1e-12, atol=1e-12)
    for method in ("auto", "DOP853"):
        other = fb.simulate(family, Q[:, None], QD[:, None], T, method=method, **WIDE)
        np.testing.assert_allclose(other.q, found.q, atol=1e-8)
    load = np.zeros((4, 3))
    load[:, 1] = [0, 1, 2, 3]
    pushed = fb.simulate(ARM, Q[0], QD[0], T, None, {"tip": load}, step=1e-3, **WIDE)
    one = fb.simulate(ARM, Q[0], QD[0], T, None, {"tip": load[2]}, **WIDE)
    np.testing.assert_allclose(pushed.q[2], one.q, atol=1e-8)


def test_none_at_all():
    for options in ({}, {"step": 1e-3}, {"method": "Radau"}):
        for torque in (None, lambda t, q, qd: -q):
            found = fb.simulate(ARM, np.zeros((0, 2)), [0.0, 0.0], T, torque, **options)
            assert found.qdd.shape == (0, 6, 2)


def test_a_sampled_controller_of_many():
    calls = []

    def controller(t, q, qd):
        calls.append(t)
        return -4.0 * q - 0.5 * qd

    compiled = fb.compile(
        lambda q, qd: [-4.0 * x - 0.5 * v for x, v in zip(q, qd, strict=True)],
        {"q": 2, "qd": 2},
        {"tau": 2},
    )
    options = {"sample_time": 0.015, **WIDE}
    expected = [fb.simulate(ARM, Q[k], QD[k], T, controller, **options) for k in range(4)]
    calls.clear()
    for torque in (controller, compiled):
        for method in ({"step": 1e-3}, {}, {"method": "implicit", "step": 1e-4}):
            found = fb.simulate(ARM, Q, QD, T, torque, **options, **method)
            for k, one in enumerate(expected):
                off = 1e-3 if "method" in method else 1e-9  # another smooth friction
                np.testing.assert_allclose(found.q[k], one.q, atol=off)
                np.testing.assert_allclose(found.tau[k], one.tau, atol=10 * off)
    np.testing.assert_allclose(calls[:7], 0.015 * np.arange(7), atol=1e-15)
    assert len(calls) == 21


# ---------------------------------------------------------------- accuracy
@pytest.mark.sample(2)
@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi-implicit", 1), ("implicit", 2)])
@pytest.mark.parametrize("seed", [24, 1])
def test_orders(seed: int, method: str, order: int):
    """Of any joints, under a compiled law of time and state."""
    model = generate.model(seed, 3 if seed == 24 else 2).without("friction")
    q, qd, tau = fb.random_state(model, seed)
    control = fb.compile(
        lambda t, qd: [a * (1.0 + 3.0 * t) - 0.5 * v for a, v in zip(tau, qd, strict=True)],
        {"t": (), "qd": model.nv},
        {"tau": model.nv},
    )
    exact = fb.simulate(model, q, qd, [0, 0.1], control, tolerance=1e-13)
    errors = []
    for steps in (16, 32):
        found = fb.simulate(model, q, qd, [0, 0.1], control, method=method, step=0.1 / steps)
        ends = ((x.q.values[-1], x.qd.values[-1]) for x in (found, exact))
        (q1, v1), (q2, v2) = ends
        errors.append(max(np.abs(fb.difference(model, q1, q2)).max(), np.abs(v1 - v2).max()))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("method", [*STEPS, "auto"])
def test_a_single_sample_of_a_table_gives_its_exact_impulse(method: str):
    """50 N m at one of 201 times, straight lines to its neighbours: 0.5 N m s, on 1 kg m², however
    long the steps may be."""
    t = np.linspace(0, 2, 201)
    rows = np.zeros((3, 201, 1))
    rows[range(3), [37, 100, 199]] = 50.0
    step = {} if method == "auto" else {"step": 0.5}
    found = fb.simulate(ROD, np.zeros((3, 1)), [0.0], t, rows, method=method, every=200, **step)
    np.testing.assert_allclose(found.qd.values[:, -1, 0], 0.5, rtol=1e-12)


@pytest.mark.parametrize("method", ["rk4", "auto"])
def test_jumps_at_breakpoints(method: str):
    """A pulse of 1 ms in 10 s, by either convention of what the value at a jump is."""
    compiled = fb.compile(
        lambda t: [500.0 * (less(4.001, t) * less(t, 4.002))], {"t": ()}, {"tau": 1}
    )
    closed = lambda t, q, qd: np.full((2, 1), 500.0 * (4.001 <= t <= 4.002))
    step = {"step": 0.1} if method == "rk4" else {}
    for torque in (compiled, closed):
        found = fb.simulate(
            ROD, np.zeros((2, 1)), [0.0], [0, 10], torque, breakpoints=[4.002, 4.001], **step
        )
        np.testing.assert_allclose(found.qd.values[:, -1, 0], 0.5, rtol=1e-10)


@pytest.mark.parametrize("method", ["rk4", "auto"])
@pytest.mark.parametrize("t", [np.linspace(-0.3, 0.7, 11) + 0.3, np.linspace(-1.0, 1.0, 21)])
def test_a_jump_at_a_time_of_the_result_but_for_rounding(method: str, t: np.ndarray):
    """0.3 is not the fourth of these times, but 6e-17 off; a sum of steps from -1 passes 0."""
    at = 0.3 if t[0] == 0.0 else 0.0
    push = fb.compile(lambda t: [100.0 * less(t, at)], {"t": ()}, {"tau": 1})
    step = {"step": 0.1} if method == "rk4" else {}
    for breaks in ([at], [at, np.nextafter(at, 1.0), at + 1e-16]):
        found = fb.simulate(ROD, np.zeros((2, 1)), [0.0], t, push, breakpoints=breaks, **step)
        np.testing.assert_allclose(found.qd.values[:, -1, 0], 100.0 * (at - t[0]), rtol=1e-13)


def test_a_double_pendulum_for_100_s_keeps_its_energy():
    model = fb.planar("RR", l=[1, 1], lc=[1, 1], m=[1, 1], I=[0, 0])
    t = np.linspace(0, 100, 11)
    q = np.array([[1.0, 0.5], [1.2, 0.5], [0.5, 1.0]]) - [np.pi / 2, 0.0]
    found = fb.simulate(
        model, q, np.zeros(2), t, step=2e-3, record=["kinetic_energy", "potential_energy"]
    )
    energy = (found.kinetic_energy + found.potential_energy).values
    assert np.ptp(energy, axis=1).max() < 1e-6
    assert set(found.data_vars) == {"kinetic_energy", "potential_energy"}


def test_implicit_steps_take_the_slopes_of_a_compiled_law():
    """A gain that explicit steps of this length do not survive."""
    stiff = fb.compile(lambda q, qd: [-1e6 * q[0] - 1e4 * qd[0]], {"q": 1, "qd": 1}, {"tau": 1})
    start = np.array([[0.1], [0.2]])
    found = fb.simulate(ROD, start, [0.0], [0, 1.0], stiff, method="implicit", step=0.01)
    assert np.abs(found.q.values[:, -1]).max() < 1e-6
    with pytest.warns(FreebodyWarning) as told:
        lost = fb.simulate(ROD, start, [0.0], [0, 1.0], stiff, method="rk4", step=0.01)
    assert "is stiff: a part of it changes within 0.0001 s, and steps of 'rk4' are" in str(
        told[0].message
    )
    assert "2 of 2 motions could not go on and are NaN" in str(told[1].message)
    assert {w.filename for w in told} == {__file__}
    assert np.isnan(lost.q.values[:, -1]).all()
    spring = fb.compile(lambda q: [-1e8 * q[0]], {"q": 1}, {"tau": 1})  # without any damping
    found = fb.simulate(ROD, start, [0.0], [0, 0.5], spring, method="implicit", step=0.01)
    assert np.abs(found.q.values[:, -1]).max() < 1e-3


@pytest.mark.parametrize("law", ["coulomb", "cube_root"])
def test_equal_steps_too_long_for_friction_at_rest_are_told_of_though_the_motion_starts_fast(law):
    """Steps of the length that the warning allows stop the rod; those that it warns of do not."""
    rod = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.75], g=0, drives=[fb.Drive(**{law: 200.0})])
    run = partial(fb.simulate, rod, [1.0], [1.0], [0.0, 0.02], method="rk4")
    said = r"friction is stiff where joints of the motion come to rest: .* stable up to (\S+) s"
    with pytest.warns(FreebodyWarning, match=said) as told:
        lost = run(step=4e-4)
    longest = float(re.search(said, str(told[0].message))[1])
    assert abs(lost.qd.values[-1, 0]) > 1e-3
    assert abs(run(step=longest).qd.values[-1, 0]) < 1e-6
    assert np.isfinite(run(step=4e-4, friction_width=0.5).qd.values).all()


def test_motions_that_diverge_leave_the_others_alone():
    """ẍ = x³ has the solution √2 / (1 - t), which is gone at t = 1 s."""
    cubic = fb.compile(lambda q: [q[0] ** 3], {"q": 1}, {"tau": 1})
    start = np.array([[2.0**0.5], [0.0], [0.1]])
    rates = 2.0**0.5 * np.array([[1.0], [0.0], [0.0]])
    with pytest.warns(FreebodyWarning, match=r"1 of 3 motions could .*sample 0 after t = 0\.9 s"):
        found = fb.simulate(ROD, start, rates, [0, 0.5, 0.9, 1.1], cubic, tolerance=1e-6)
    np.testing.assert_allclose(found.q[0, :3, 0], 2.0**0.5 / np.array([1, 0.5, 0.1]), rtol=1e-5)
    assert np.isnan(found.q.values[0, 3]).all()
    assert np.isfinite(found.q.values[1:]).all()


def test_closed_chains_that_diverge_leave_the_others_alone():
    bars = fb.load("four_bar")
    q, torque = fb.assemble(bars, [0.8, 0, 0]), np.zeros((2, 1, bars.nv))
    torque[0, 0, bars.driven[0]] = 1e6
    options = {"t": [0, 0.05, 0.1], "step": 1e-2}
    with pytest.warns(FreebodyWarning, match=r"1 of 2 motions could not go on"):
        found = fb.simulate(bars, q, np.zeros(3), torque=torque, **options)
    one = fb.simulate(bars, q[None], np.zeros(3), **options)
    for name in ("q", "qdd", "loop_gap", "power"):
        np.testing.assert_array_equal(found[name][1], one[name][0])
        assert np.isnan(found[name].values[0, -1]).all()


def test_coulomb_friction_is_smooth_in_all_methods():
    found = [
        fb.simulate(ARM, [0.1, 0.2], [1.0, 0.0], T, friction_width=0.05, **options)
        for options in ({}, {"step": 1e-3}, {"method": "implicit", "step": 2e-4})
    ]
    np.testing.assert_allclose(found[1].q, found[0].q, atol=1e-8)
    np.testing.assert_allclose(found[2].q, found[0].q, atol=2e-3)  # another smooth function
    assert found[1].attrs["dry_friction"] == "c tanh(q̇ / 0.05)"
    assert found[2].attrs["dry_friction"] == "c q̇ / √(q̇² + 0.05²)"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "gain", "words"),
    [
        (arm(coulomb=2.0), 0.0, "smooth dry friction keeps the steps .* friction_width = 0.0001"),
        (arm(), 3000.0, "motions are stiff: .* decays within .* method='implicit'"),
    ],
)
def test_steps_that_friction_or_stiffness_keeps_short_are_told(model, gain, words):
    law = fb.compile(lambda qd, gain: [-gain * x for x in qd], {"qd": 2, "gain": ()}, {"tau": 2})
    options = {"torque_inputs": {"gain": gain}, "tolerance": 1e-8}
    if not gain:
        options["friction_width"] = 1e-4
    with pytest.warns(FreebodyWarning, match=words) as told:
        fb.simulate(model.replace(gravity=0), Q[:2], 0.01 * QD[:2], [0, 0.1], law, **options)
    assert len(told) == 1
    assert told[0].filename == __file__


def test_a_free_body_and_a_closed_chain():
    bars = fb.load("four_bar")
    free = generate.model(24, 3).without("friction")
    assert free.nq > free.nv
    crank = bars.position_names[0]
    for model, q in (
        (bars, np.stack([fb.assemble(bars, {crank: x}) for x in (0.8, 1.0)])),
        (free, fb.random_state(free, 1, (2,))[0]),
    ):
        still = np.zeros(model.nv)
        for options in ({"step": 1e-3}, {}):
            found = fb.simulate(model, q, still, [0, 0.05, 0.1], **options)
            for k in range(2):
                one = fb.simulate(model, q[k], still, [0, 0.05, 0.1])
                np.testing.assert_allclose(found.q[k], one.q, atol=1e-7)
                np.testing.assert_allclose(found.kinetic_energy[k], one.kinetic_energy, rtol=1e-6)
        if model is bars:
            assert float(abs(found.loop_gap).max()) < 1e-10


# ---------------------------------------------------------------- what is returned
def test_what_is_recorded():
    whole = fb.simulate(ARM, Q, QD, T, TAU[:, None], step=1e-3, **WIDE)
    some = fb.simulate(
        ARM, Q, QD, T, TAU[:, None], step=1e-3, record=["qd", "power"], every=2, **WIDE
    )
    assert set(some.data_vars) == {"qd", "power"}
    np.testing.assert_array_equal(some.time, T[::2])
    for name in some.data_vars:
        np.testing.assert_array_equal(some[name], whole[name][:, ::2])
        assert some[name].attrs == whole[name].attrs
    expected = fb.forward_dynamics(ARM.without("friction"), Q, QD, TAU)
    friction = np.stack([0.2 * np.tanh(QD[:, 0] / 0.5) + 0.1 * QD[:, 0], 0 * QD[:, 0]], axis=-1)
    M = fb.mass_matrix(ARM, Q)
    expected -= np.linalg.solve(M, friction[..., None])[..., 0]
    np.testing.assert_allclose(whole.qdd[:, 0], expected, rtol=1e-9)
    one = fb.simulate(ARM, Q[0], QD[0], T, every=5, record="q", **WIDE)
    full = fb.simulate(ARM, Q[0], QD[0], T, record="q", **WIDE)
    np.testing.assert_array_equal(one.q, full.q[::5])
    assert whole.attrs["step"] == pytest.approx(1e-3)


@pytest.fixture
def interrupts():
    """As in a shell's foreground; a job in the background ignores SIGINT, and Python with it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interrupts")
def test_an_interrupt_keeps_what_was_computed():
    """Of one motion the times until then; of many those that were reached."""

    def torque(t, q, qd):
        if t > 0.05:
            signal.raise_signal(signal.SIGINT)
        return np.zeros(2)

    for q, options in ((Q[0], {}), (Q, {"step": 1e-3}), (Q, {})):
        with pytest.raises(
            KeyboardInterrupt, match=r"interrupted; what was computed, up to t = 0\.04"
        ) as kept:
            fb.simulate(ARM, q, np.zeros(2), T, torque, **WIDE, **options)
        part = kept.value.result
        assert part.time.values.tolist() == T[:3].tolist()
        whole = fb.simulate(ARM, q, np.zeros(2), T, **WIDE, **options)
        np.testing.assert_allclose(part.q, whole.q[..., :3, :], atol=1e-10)


@pytest.mark.usefixtures("interrupts")
def test_an_interrupt_after_the_last_step_keeps_all():
    """While powers and energies are computed."""
    left = [T[-1], 0.0]  # once the last time was reached, and the first one is asked for again

    def torque(t, q, qd):
        if t in left[:1]:
            left.pop(0)
            if not left:
                signal.raise_signal(signal.SIGINT)
        return np.zeros(2)

    whole = fb.simulate(ARM, Q, QD, T, step=1e-3, **WIDE)
    with pytest.raises(KeyboardInterrupt, match=r"up to t = 0\.1 s") as kept:
        fb.simulate(ARM, Q, QD, T, torque, step=1e-3, **WIDE)
    np.testing.assert_allclose(kept.value.result.power, whole.power, atol=1e-10)


@pytest.mark.usefixtures("interrupts")
def test_an_interrupt_before_the_first_step_keeps_the_start():
    def torque(t, q, qd):
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as kept:
        fb.simulate(ARM, Q, QD, T, torque, sample_time=0.01, record=["q", "qd"], **WIDE)
    np.testing.assert_array_equal(kept.value.result.q[:, 0], Q)


@pytest.mark.usefixtures("interrupts")
def test_an_interrupt_ends_threads():
    model = fb.load("2R")
    q, qd, _ = fb.random_state(model, 1, (2000,))
    t = np.linspace(0, 50, 501)

    def soon(text, part):
        if part > 0.01:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as kept:
        fb.simulate(model, q, qd, t, step=1e-4, threads=2, record="q", progress=soon)
    assert 1 < kept.value.result.sizes["time"] < 501


def test_a_table_that_may_be_meant_as_one_torque_for_each_is_told():
    q = np.zeros((len(T), 2))
    with pytest.warns(FreebodyWarning, match=r"is taken as a table over the 6 times") as told:
        found = fb.simulate(ARM, q, q, T, q + 1.0, step=0.01, **WIDE)
    assert told[0].filename == __file__
    assert found.tau.shape == (6, 6, 2)
    # one row for each, and a table, of such a shape that nothing else can be meant
    for given in ((q + 1.0)[:, None], (q + 1.0)[None]):
        same = fb.simulate(ARM, q, q, T, given, step=0.01, **WIDE)
        np.testing.assert_array_equal(same.q, found.q)


def test_a_law_that_divides_is_as_stiff_as_one_that_multiplies():
    stiff, soft = 3e4, 1.0 / 3e4
    laws = (lambda q: [-stiff * q[0]], lambda q: [-q[0] / soft])
    one, other = (
        fb.simulate(
            ROD, [0.3], [0.0], [0, 0.1],
            fb.compile(law, {"q": (1,)}, {"tau": 1}), method="implicit", step=0.01,
        ).q.values
        for law in laws
    )  # fmt: skip
    assert abs(one[-1, 0]) < 0.3
    np.testing.assert_allclose(other, one, rtol=1e-9)


# ---------------------------------------------------------------- what is refused
EQUAL = {"step": 1e-3}
GIVEN = {"torque": LAW, "torque_inputs": {"goal": [1.0], "gain": 1.0}}
REFUSED = [
    ({"step": 0.0}, FreebodyError, "step is 0, expected a number of seconds above 0"),
    ({"step": 1e-300}, FreebodyError, "step is 1e-300 s, 1e+299 steps in this run; 1e+12 are"),
    ({"step": "1 ms"}, FreebodyError, "step is '1 ms', expected real"),
    ({"tolerance": -1.0}, FreebodyError, "tolerance is -1, expected a number above 0"),
    ({"max_step": np.nan}, FreebodyError, "max_step is nan, expected a number of"),
    ({"friction_width": 0}, FreebodyError, "friction_width is 0, expected a number above 0"),
    ({"record": 3}, FreebodyError, "record= is int 3, expected a name or a list of names"),
    ({"method": "DOP853", **EQUAL}, FreebodyError, "step= is of the methods of equal steps, rk4"),
    ({**EQUAL, "tolerance": 1e-6}, FreebodyError, "tolerance= is of methods that choose"),
    ({**EQUAL, "max_step": 1.0}, FreebodyError, "max_step= is of methods that choose"),
    ({"method": "rk5"}, UnknownNameError, "no method 'rk5' in simulate. Did you mean 'rk4'?"),
    ({"record": "speed"}, UnknownNameError, "no quantity 'speed' in record="),
    ({"record": []}, FreebodyError, "record= names at least one quantity"),
    ({"every": 0}, FreebodyError, "every is 0, expected a whole number above 0"),
    ({"threads": 0}, FreebodyError, "threads is 0, expected a whole number above 0"),
    ({"threads": 1.5}, FreebodyError, "threads is 1.5, expected a whole number above 0"),
    ({"torque": np.zeros((4, 2))}, FreebodyError, "it is (..., 6, 2), or (..., 1, 2) where"),
    ({"torque": np.zeros((3, 1, 2))}, FreebodyError, "together: q (4,), qd (4,), torque (3,)"),
    ({"torque_inputs": {"a": 1.0}}, FreebodyError, "torque_inputs= is about a torque from fb.comp"),
    (
        {"torque": LAW},
        FreebodyError,
        "goal and gain besides t, q and qd: give torque_inputs={'goal",
    ),
    ({**GIVEN, "torque_inputs": {"aim": 1}}, UnknownNameError, "no input 'aim' in torque_inputs="),
    ({**GIVEN, "torque_inputs": [1]}, FreebodyError, "torque_inputs is list [1], expected a dict"),
    ({"torque": lambda t, q, qd: "x"}, FreebodyError, "what torque(t, q, qd) returns is 'x', "),
    (GIVEN, ShapeError, "torque_inputs['goal'] has shape (1,)"),
    ({"torque": lambda t, q, qd: q[:3]}, ShapeError, "has shape (3, 2), expected (4, 2): it is"),
    (
        {"torque": lambda t, q, qd: -q, "method": "implicit"},
        FreebodyError,
        "needs the derivatives of the torque",
    ),
    ({"torque": lambda t, q, qd: -q, "method": "Radau"}, FreebodyError, "integrates one state aft"),
]


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_is_refused(case: int):
    options, error, problem = REFUSED[case]
    with pytest.raises(error, match=re.escape(problem)):
        fb.simulate(ARM, Q, QD, T, **(WIDE | options))


def test_a_compiled_torque_at_a_passive_joint_is_refused():
    model = ARM.replace(actuated=["joint1"])
    push = fb.compile(lambda qd: [0.0, -qd[1]], {"qd": 2}, {"tau": 2})
    for options in ({"step": 1e-3}, {}, {"method": "DOP853"}):
        with pytest.raises(fb.FreebodyError, match=r"the torque of 'joint2' is .* passive"):
            fb.simulate(model, Q, QD, T, push, **WIDE, **options)


def test_progress_is_told():
    for torque, options in ((None, {"step": 1e-5}), (None, {"threads": 1}), (python(0), {})):
        parts: list[float] = []
        q = Q if torque is None else Q[0]
        t = np.linspace(0, 0.5, 200)
        fb.simulate(
            ARM,
            q,
            np.zeros(2),
            t,
            torque,
            progress=lambda text, x, p=parts: p.append(x),
            **WIDE,
            **options,
        )
        assert parts
        assert parts == sorted(parts)
        assert 0.0 < parts[0] <= parts[-1] <= 1.0


def test_progress_of_many_steps_between_two_times_is_that_of_the_steps():
    parts: list[float] = []
    options = {"step": 1e-4, "threads": 1, "progress": lambda text, x: parts.append(x)}
    fb.simulate(ARM, Q, np.zeros(2), [0.0, 10.0], **WIDE, **options)
    assert 0.0 < parts[0] < 0.5


# ---------------------------------------------------------------- printed results of others
def baby_boot() -> fb.Model:
    """A plate that turns about a pendulum's rod (Kane 1974)."""
    moments = (5e-6, 5e-6, 5e-6), (2.5e-4, 5e-5, 2e-4)
    rod, plate = (
        Link(name, fb.Inertia(mass, (0, 0, z), (xx, 0.0, 0.0, yy, 0.0, zz)))
        for name, mass, z, (xx, yy, zz) in zip(
            ("rod", "plate"), (0.01, 0.1), (-0.075, 0.0), moments, strict=True
        )
    )
    joints = (
        Joint("pin", "revolute", "world", "rod", axis=(1, 0, 0)),
        Joint(
            "shaft",
            "revolute",
            "rod",
            "plate",
            Placement((Shift((0.0, 0.0, -0.2)),)),
            axis=(0, 0, 1),
        ),
    )
    links = (Link("world"), rod, plate)
    return loaded(Robot("baby boot", 3, links, joints, 9.81))


@pytest.mark.sample(1)
@pytest.mark.parametrize("options", [{"tolerance": 1e-12}, {"step": 2e-4}])
def test_the_baby_boot_after_10_s(options: dict):
    """Drake, multibody/benchmarks/chaotic_babyboot: from three integrations, which agree to 7
    digits in the angles and 6 in the rates. The start is an unstable one."""
    q = np.deg2rad([[90.0, 1.0], [90.0, 1.0], [90.0, 0.5]])
    found = fb.simulate(baby_boot(), q, [0.0, 0.0], [0.0, 10.0], record=["q", "qd"], **options)
    for k in range(2):
        np.testing.assert_allclose(
            np.rad2deg(found.q[k, 1]), [-61.3129833, -929.477897], rtol=0, atol=5e-6
        )
        np.testing.assert_allclose(found.qd[k, 1], [-6.7440081, -2.779569], rtol=0, atol=2e-6)
    alone = fb.simulate(baby_boot(), q[0], [0.0, 0.0], [0.0, 10.0], tolerance=1e-12)
    np.testing.assert_allclose(alone.q[1], found.q[0, 1], rtol=0, atol=5e-8)
