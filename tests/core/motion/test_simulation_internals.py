"""Parts of simulations that a result does not show: which contacts hold, how smooth friction is,
what a step or a block is cut into.

No argument chooses these, so they are called or set by name.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.motion.simulation import side_by_side, step_sizes
from freebody.motion.simulation.contact_events import ContactEvents
from freebody.motion.simulation.dry_friction_and_stops import complementary
from support.robots import Joint, Link, Mimic, Robot, loaded


def test_two_joints_at_their_stops_do_not_set_each_other_moving_for_ever(monkeypatch):
    """One that comes to rest a rounding before its stop was held by friction alone, which the other
    overcame, came to rest a rounding before its own, and so on: millions of changes a second."""
    drives = [fb.Drive(coulomb=c, rotor=0.02) for c in (0.8, 0.52, 0.19)]
    body = {"l": [0.44, 0.44, 0.35], "lc": [0.22, 0.22, 0.175], "m": [0.93, 0.58, 1.08]}
    limits = [(-1, 1)] * 3
    model = fb.planar("RPR", **body, I=[0.03, 0.01, 0.01], drives=drives, limits=limits)
    sin, cos = fb.math.sin, fb.math.cos
    law = fb.compile(
        lambda t, q, qd: [
            sin(5 * t) - q[0] - 0.1 * qd[0], 1.5 * cos(7 * t) * q[1], -0.3 * q[2]
        ],
        {"t": (), "q": 3, "qd": 3}, {"tau": 3},
    )  # fmt: skip
    calls, whole = [0], ContactEvents.cut

    def counted(*given):
        calls[0] += 1
        assert calls[0] < 4000
        return whole(*given)

    monkeypatch.setattr(ContactEvents, "cut", counted)
    given = [-0.66, 0.03, -0.45], [-2.94, -1.45, 2.43], [0.0, 1.0], law
    others = {"friction": "dry", "restitution": [0.51, 0.13, 0.35], "record": ("q", "qd")}
    found, equal = (fb.simulate(model, *given, **others, **x) for x in ({}, {"step": 0.001}))
    assert found.q.values[-1] == pytest.approx(equal.q.values[-1], abs=1e-6)


def two_links(**friction: float) -> fb.Model:
    drives = [fb.Drive(**friction), fb.Drive()]
    lengths = {"l": [0.4, 0.3], "lc": [0.2, 0.15], "m": [2.0, 1.0], "I": [0.03, 0.01]}
    return fb.planar("RR", **lengths, drives=drives)


ARM = two_links(viscous=0.1, coulomb=0.2)


def law(t, q, qd, goal, gain):
    return [gain * (g - x) - 0.3 * v + t for x, v, g in zip(q, qd, goal, strict=True)]


LAW = fb.compile(law, {"t": (), "q": 2, "qd": 2, "goal": 2, "gain": ()}, {"tau": 2})


@pytest.mark.parametrize("seed", range(3))
def test_what_holds_is_the_one_solution(seed: int):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(40, 5, 5))
    M = half @ np.swapaxes(half, 1, 2) + 0.1 * np.eye(5)
    forces, c = rng.normal(size=(40, 5)) * 3, rng.uniform(0.1, 2, (40, 5))
    candidates = rng.random((40, 5)) < 0.8
    least, most = -c, np.where(rng.random((40, 5)) < 0.3, np.inf, c)
    found = complementary(M, forces, candidates, least, most)
    push = np.einsum("nij,nj->ni", M, found.qdd) - forces
    tiny = 1e-9
    assert (np.abs(push[~candidates]) < tiny).all()
    inside = ((push >= least - tiny) & (push <= most + tiny))[candidates]
    resists = np.where(
        found.qdd > tiny, push - least, np.where(found.qdd < -tiny, push - most, 0.0)
    )
    assert inside.all()
    assert (np.abs(resists[candidates]) < tiny).all()


def test_followers_feel_their_friction():
    """A follower of ratio r with friction c adds r c tanh(r q̇ / width) to its leader's torque."""
    from freebody.motion.smooth_friction import smooth_friction

    links = tuple(
        Link(f"l{k}", fb.Inertia(1.0, (0.1, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))) for k in range(3)
    )
    joints = (
        Joint("a", "revolute", "l0", "l1", axis=(0, 0, 1), drive=fb.Drive(coulomb=1.0)),
        Joint(
            "b",
            "revolute",
            "l1",
            "l2",
            axis=(0, 0, 1),
            drive=fb.Drive(coulomb=3.0),
            mimic=Mimic("a", -2.0, 0.1),
        ),
    )
    model = loaded(Robot("pair", 3, links, joints, 9.81))
    smooth, friction = smooth_friction(model, 0.1)
    rate = np.array([[0.03], [-0.5]])
    expected = np.tanh(rate / 0.1) + 2.0 * 3.0 * np.tanh(2.0 * rate / 0.1)
    np.testing.assert_allclose(friction.torque(0.0 * rate, rate), expected, rtol=1e-14)
    np.testing.assert_allclose(friction.steepest(np.zeros(model.nq)), [(1.0 + 4 * 3.0) / 0.1])
    fast = np.array([[7.0]])
    sharp = fb.bias(model, [[0.3]], fast) - fb.bias(smooth, [[0.3]], fast)
    np.testing.assert_allclose(friction.torque(0.0 * fast, fast), sharp, rtol=1e-12)


def test_results_do_not_depend_on_how_many_steps_a_call_takes(monkeypatch: pytest.MonkeyPatch):
    """Nor on blocks and threads. Internals are set: no argument chooses them."""
    lanes, t = 300, np.linspace(0, 0.02, 8)
    q, qd, tau = fb.random_state(ARM, 1, (lanes,))
    tables = np.random.default_rng(0).normal(size=(lanes, len(t), 2))
    given = {"torque_inputs": {"goal": q[::-1], "gain": 5.0}, "breakpoints": [0.0041]}
    cases = {
        "tables": (tables, {}),
        "a table": (tables[0], {}),
        "constant": (tau[:, None], {}),
        "compiled": (LAW, given),
        "sampled": (lambda t, q, qd: -5.0 * q, {"sample_time": 0.06 / 7}),
    }

    def run() -> dict[str, np.ndarray]:
        found = {}
        for name, (torque, more) in cases.items():
            for options in ({"every": 3}, {"step": 7e-4, "every": 2}, {"step": 7e-4}):
                result = fb.simulate(ARM, q, qd, t, torque, method="rk4", **options, **more)
                both = [result.q.values, result.qd.values]
                found[f"{name} {options}"] = np.concatenate(both, axis=-1)
        return found

    whole = run()
    settings = (
        (step_sizes, "_MOST_AT_ONCE", 3),
        (side_by_side, "STAYING", 32),
        (side_by_side, "_FEW_STEPS", 10**9),  # every step called from Python
    )
    for module, name, value in settings:
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            patch.setattr(side_by_side, "_FEWEST", 16)
            for case, found in run().items():
                np.testing.assert_array_equal(found, whole[case], err_msg=f"{name} {case}")


def test_instants_of_a_long_run_are_found_at_once():
    """Of a controller of 1 kHz in 200 s."""
    calls = 1e-3 * np.arange(200_000)
    found = step_sizes.step_times(np.array([0.0, 200.0]), 1, np.zeros(0), calls)
    assert found.calls == tuple(range(200_000))
