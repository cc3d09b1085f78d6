"""Simulations under generalized forces that no drive gives, besides all kinds of torques."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError
from support.springs import K, loaded, springs

ARM = fb.load("2R")
T = np.linspace(0.0, 0.5, 11)
STARTS = np.array([[0.1, 0.2], [0.3, -0.4], [0.0, 1.0]])
TABLE = np.stack([np.sin(9 * T), 1.0 - T], axis=-1)


def pull(t, q, qd):
    return [-30.0 * q[0] - 2.0 * qd[1], 5.0 - 3.0 * qd[1]]


def function(t, q, qd):
    return np.stack(pull(t, np.moveaxis(q, -1, 0), np.moveaxis(qd, -1, 0)), axis=-1)


LAW = fb.compile(pull, {"t": (), "q": 2, "qd": 2}, {"tau": 2})
GIVEN = {"constant": np.array([0.3, -0.2]), "table": TABLE, "function": function, "law": LAW}
SHORT = [("table", "law"), ("law", "law"), ("constant", "function")]
STEPS = {"rk4": 5e-3, "semi-implicit": 5e-3, "implicit": 5e-3}


def whole(*parts):
    """The sum of them, as a function of one state."""

    def one(part, t, q, qd):
        if callable(part):
            return function(t, q, qd)
        return part if part.ndim == 1 else [np.interp(t, T, column) for column in part.T]

    return lambda t, q, qd: np.sum([one(part, t, q, qd) for part in parts], axis=0)


@pytest.fixture(scope="module")
def alone():
    """By the names of torque and forces the motions of each start under their sum."""
    found = {}

    def of(torque, forces):
        key = tuple(sorted((torque, forces)))
        if key not in found:
            law = whole(GIVEN[torque], GIVEN[forces])
            runs = [
                fb.simulate(ARM, q, [0, 0], T, law, breakpoints=T[1:-1], record=["q", "qdd"])
                for q in STARTS
            ]
            found[key] = [np.stack([run[name].values for run in runs]) for name in ("q", "qdd")]
        return found[key]

    return of


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("torque", "forces"),
    [
        pytest.param(*pair, marks=[] if pair in SHORT else pytest.mark.long)
        for pair in product(GIVEN, GIVEN)
    ],
)
def test_motions_are_those_of_torque_and_forces_together(torque, forces, alone):
    q, qdd = alone(torque, forces)
    for method in ("auto", "rk4", "implicit", "Radau"):
        for many in (False, True):
            functions = "function" in (torque, forces)
            start = STARTS if many else STARTS[1]
            given = {"forces": GIVEN[forces], "method": method, "step": STEPS.get(method)}

            def run(start=start, given=given):
                return fb.simulate(ARM, start, [0, 0], T, GIVEN[torque], **given)

            if functions and (method == "implicit" or (many and method == "Radau")):
                with pytest.raises(FreebodyError, match="compile"):
                    run()
                continue
            found, error = run(), {"implicit": 2e-2, "rk4": 1e-6}.get(method, 1e-8)
            np.testing.assert_allclose(found.q, q if many else q[1], atol=error)
            np.testing.assert_allclose(found.qdd, qdd if many else qdd[1], atol=1e3 * error)
            if isinstance(GIVEN[torque], np.ndarray):
                np.testing.assert_array_equal(*np.broadcast_arrays(found.tau, GIVEN[torque]))


@pytest.mark.parametrize("forces", GIVEN)
def test_forces_act_between_the_instants_of_a_sampled_controller(forces):
    """Which is called once an instant, and whose torque alone is held."""
    ran = []
    for method, step in (("auto", None), ("rk4", 1e-3), ("DOP853", None)):
        calls = []

        def control(t, q, qd, calls=calls):
            calls.append(t)
            return function(t, q, qd)

        given = {"sample_time": 0.1, "method": method, "step": step, "forces": GIVEN[forces]}
        ran.append(fb.simulate(ARM, STARTS[1], [0, 0], T, control, **given))
        np.testing.assert_allclose(calls, 0.1 * np.arange(5))
    many = fb.simulate(ARM, STARTS, 0 * STARTS, T, control, sample_time=0.1, forces=GIVEN[forces])
    for found in (*ran, many.isel(sample=1)):
        np.testing.assert_allclose(found.q, ran[0].q, atol=1e-8)
        np.testing.assert_allclose(found.qdd, ran[0].qdd, atol=1e-5)
        np.testing.assert_allclose(found.tau, ran[0].tau, atol=1e-6)


def test_in_a_simulation_they_act_at_passive_joints_and_in_closed_chains():
    """As springs of the model do."""
    linkage, (q, qd), _ = loaded("four_bar")
    cart = fb.load("cart_pole")
    for model, at, rates in ((cart, np.array([0.1, 0.4]), np.zeros(2)), (linkage, q, qd)):
        spring = fb.compile(
            lambda q: [K * (0.3 - x) for x in q], {"q": model.nq}, {"tau": model.nv}
        )
        expected = fb.simulate(springs(model), at, rates, T)
        assert abs(expected.q - fb.simulate(model, at, rates, T).q).max() > 1e-2
        found = fb.simulate(model, at, rates, T, forces=lambda t, q, qd: K * (0.3 - q))
        np.testing.assert_allclose(found.q, expected.q, atol=1e-8)
        np.testing.assert_allclose(found.qdd, expected.qdd, atol=1e-5)
        found = fb.simulate(model, at, rates, T, forces=spring, step=1e-3)
        np.testing.assert_allclose(found.q, expected.q, atol=1e-7)
    with pytest.raises(FreebodyError, match="compile the forces with"):
        fb.simulate(linkage, q, qd, T, forces=lambda t, q, qd: 0 * q, step=1e-3)


def test_dry_friction_feels_forces():
    """Which hold a joint, or make it slide."""
    arm = ARM.replace(gravity=0.0).with_drive("joint1", coulomb=1.0)
    ramp = np.stack([4.0 * T, 0.0 * T], axis=-1)
    every = {}
    for given in ({"torque": ramp}, {"forces": ramp}, {"forces": lambda t, q, qd: [4.0 * t, 0.0]}):
        run = fb.simulate(arm, [0, 0], [0, 0], T, friction="dry", **given)
        every.setdefault("q", run.q.values)
        np.testing.assert_allclose(run.q, every["q"], atol=1e-8)
    assert (every["q"][T <= 0.25, 0] == 0.0).all()
    assert abs(every["q"][-1, 0]) > 1e-3


@pytest.mark.parametrize(
    ("forces", "says"),
    [
        (np.zeros(3), r"simulate: forces has shape \(3,\)"),
        (np.zeros((4, 2)), r"simulate: forces has shape \(4, 2\), expected \(2,\), \(11, 2\)"),
        (np.full(2, np.nan), "simulate: forces is nan for 'joint1'"),
        (lambda t, q, qd: [1.0], r"simulate: what forces\(t, q, qd\) returns has shape"),
        (
            fb.compile(lambda q, k: [k * q[0], 0.0], {"q": 2, "k": ()}, {"tau": 2}),
            r"the compiled forces takes k besides t, q and qd: compile it with these numbers",
        ),
    ],
)
def test_forces_of_a_simulation_that_do_not_fit_are_refused(forces, says):
    with pytest.raises(FreebodyError, match=says):
        fb.simulate(ARM, [0, 0], [0, 0], T, forces=forces)
