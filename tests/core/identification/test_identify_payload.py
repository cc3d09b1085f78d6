"""`fb.identify_payload` on simulated arms whose load is known."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, log, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb")
ARM = arm()


def warmed(model, factor):
    """The model with viscous and Coulomb friction times a factor."""
    for body in model.bodies:
        drive = body.joint.drive
        numbers = {"rotor": drive.rotor, "gear": drive.gear}
        numbers |= {x: factor * getattr(drive, x) for x in FRICTION}
        model = model.with_drive(body.joint.name, **numbers)
    return model


@cache
def case(seed):
    """(arm, load's numbers, log with it and less friction, log without it)."""
    rng = np.random.default_rng(seed)
    model = with_random_numbers(ARM, rng, FRICTION)
    sides, centre = rng.uniform(0.05, 0.3, 3), rng.uniform(-0.1, 0.1, 3)
    carrying = model.with_payload(rng.uniform(0.5, 4.0), com=centre, box=sides)
    inertia = carrying.bodies[-1].inertias[-1].inertia
    true = [inertia.mass, *inertia.com, *inertia.tensor]
    return model, true, log(warmed(carrying, 0.8), rng), log(model, rng)


def test_a_payload_is_told_though_friction_drifts():
    for seed in range(4):
        _, true, loaded, empty = case(seed)
        found = fb.identify_payload(ARM, loaded, empty, friction=FRICTION)
        assert found.outcome == "told"
        assert found.mass.value == pytest.approx(true[0], rel=0.02)
        assert found.mass.in_model == pytest.approx(true[0], rel=0.02)
        for x in found.friction:
            assert x.significant
            assert x.factor == pytest.approx(0.8, abs=0.02)
        assert any(text.startswith("Friction changed") for text in found.notices)
        carried = found.model.bodies[-1].inertias[-1].inertia
        assert carried.mass == found.mass.in_model
        assert carried.fault() is None


@pytest.mark.long
def test_intervals_of_payloads_hold():
    hits = []
    for seed in range(60):
        _, true, loaded, empty = case(seed)
        found = fb.identify_payload(ARM, loaded, empty, friction=FRICTION)
        assert abs(found.mass.value / true[0] - 1.0) < 0.02
        hits += [x.lower <= t <= x.upper for x, t in zip(found.numbers, true, strict=True)]
    assert 0.92 < np.mean(hits) < 0.985


def test_one_log_and_the_arm_s_model_do_as_well():
    model, true, loaded, _ = case(0)
    found = fb.identify_payload(model, loaded, friction=FRICTION)
    assert found.outcome == "told"
    assert found.mass.lower < true[0] < found.mass.upper
    assert any("count as known" in text for text in found.notices)


def test_a_model_of_another_arm_is_no_evidence_of_a_load():
    _, _, loaded, _ = case(0)
    other = with_random_numbers(ARM, np.random.default_rng(99), FRICTION)
    found = fb.identify_payload(other, loaded, friction=FRICTION)
    assert found.outcome != "told"
    assert found.unexplained > 10.0
    assert any("the model's masses are not the arm's" in text for text in found.notices)


def test_no_load_is_not_told_as_one():
    rng = np.random.default_rng(3)
    model = with_random_numbers(ARM, rng, FRICTION)
    found = fb.identify_payload(ARM, log(model, rng), log(model, rng), friction=FRICTION)
    assert found.outcome == "not told"
    assert found.mass.lower < 0.0 < found.mass.upper
    assert "tell no load" in found.verdict


def test_what_an_upright_arm_does_not_tell_has_no_interval():
    scara, rng = fb.load("scara"), np.random.default_rng(4)
    carrying = scara.with_payload(2.0, com=[0.03, 0.01, -0.02])
    found = fb.identify_payload(scara, log(carrying, rng), log(scara, rng))
    assert found["mass"].value == pytest.approx(2.0, rel=0.02)
    assert found["com.x"].value == pytest.approx(0.03, abs=1e-3)
    assert np.isnan(found["com.z"].value)
    assert not found["com.z"].told
    assert "com.z" in found.notices[-1]


def test_currents_need_gains():
    rng = np.random.default_rng(0)
    model = with_random_numbers(ARM, rng, FRICTION)
    gains = np.array([9.0, 8.0, 7.0])
    loaded = log(model.with_payload(1.0), rng, gains=gains)
    empty = log(model, rng, gains=gains)
    with pytest.raises(fb.FreebodyError, match="give gains="):
        fb.identify_payload(ARM, loaded, empty)
    found = fb.identify_payload(ARM, loaded, empty, friction=FRICTION, gains=gains)
    assert found.mass.lower < 1.0 < found.mass.upper


def test_what_tells_no_load_is_refused():
    _, _, loaded, _ = case(0)
    with pytest.raises(fb.FreebodyError, match="has no masses; give empty="):
        fb.identify_payload(ARM, loaded)
    with pytest.raises(fb.FreebodyError, match="no joint moves the frame 'base'"):
        fb.identify_payload(ARM, loaded, loaded, frame="base")
    short = log(arm(np.random.default_rng(0)), np.random.default_rng(1), duration=2.5)
    with pytest.raises(fb.FreebodyError, match=r"^identify_payload: joint 'joint1' moves faster"):
        fb.identify_payload(ARM, short, loaded)
    with pytest.raises(fb.UnknownNameError, match="identify_payload: friction="):
        fb.identify_payload(ARM, loaded, loaded, friction=["viscos"])
    with pytest.raises(fb.FreebodyError, match="at least one log"):
        fb.identify_payload(ARM, [], loaded)
