"""`fb.detect_collisions` on simulated logs, with pushes planted and without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, log, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb", "offset")
ARM = arm()


def case(seed):
    """(identified model, a log of the arm, a push of up to one joint, its instant)."""
    rng = np.random.default_rng(seed)
    model = with_random_numbers(ARM, rng, FRICTION)
    clean = log(model, rng)
    found = fb.identify(ARM, log(model, rng), friction=FRICTION).model
    k = int(rng.integers(0, 3))
    push = np.zeros(3)
    size = np.sqrt(np.mean(clean.torque**2, axis=0))
    push[: k + 1] = 0.5 * size[: k + 1] * rng.choice([-1.0, 1.0], k + 1)
    return found, clean, push, rng.uniform(3.0, 17.0)


def pushed(clean, push, at, lasts=0.2):
    """The log with a push, whose torques the drives hold against."""
    meanwhile = (clean.time >= at) & (clean.time < at + lasts)
    return replace(clean, torque=clean.torque - meanwhile[:, None] * push)


def found_and_false(seeds):
    """How many planted pushes were found within 0.1 s, and how many alarms were false."""
    found = false = 0
    for seed in seeds:
        model, clean, push, at = case(seed)
        false += len(fb.detect_collisions(model, clean))
        events = fb.detect_collisions(model, pushed(clean, push, at)).collisions
        hits = [x for x in events if abs(x.start - at) < 0.1]
        found += bool(hits)
        false += len(events) - len(hits)
    return found, false


def test_pushes_are_found_with_their_instant_and_clean_logs_have_none():
    assert found_and_false(range(3)) == (3, 0)


@pytest.mark.long
def test_fifty_clean_logs_give_no_alarm():
    found, false = found_and_false(range(50))
    assert false == 0
    assert found >= 48


def test_a_push_is_told_with_its_joint_and_torque():
    model, clean, push, at = case(0)
    found = fb.detect_collisions(model, pushed(clean, push, at))
    (event,) = found.collisions
    joints = [x for x, tau in zip(ARM.joint_names, push, strict=True) if tau]
    assert event.joint == joints[-1]
    assert event.torque == pytest.approx(push, rel=0.1, abs=0.3)
    assert f"{event.start:.2f} s" in found.verdict


def test_a_clean_log_sets_the_thresholds():
    model, clean, push, at = case(1)
    other = case(2)[1]
    with pytest.raises(fb.FreebodyError, match="torque constants"):
        fb.detect_collisions(model, replace(clean, torque=None, current=clean.torque))
    found = fb.detect_collisions(model, pushed(clean, push, at), clean=clean)
    assert [abs(x.start - at) < 0.1 for x in found.collisions] == [True]
    wrong = fb.detect_collisions(model, clean, clean=other)
    assert np.all(wrong.threshold > found.threshold)


@pytest.mark.parametrize("by_clean", [False, True])
def test_a_joint_that_crawls_between_rests_is_not_pushed(by_clean):
    """What dry friction holds of a resting joint is no part of what the model lacks in motion, and
    motions that differ from those of a clean log give no alarms."""
    model = with_random_numbers(ARM, np.random.default_rng(7), FRICTION)
    false = 0
    for seed in range(6):
        clean = resting_log(model, seed + 100) if by_clean else None
        false += len(fb.detect_collisions(model, resting_log(model, seed), clean=clean))
    assert false == 0
    hit = pushed(resting_log(model, 0), np.array([15.0, 0.0, 0.0]), 5.2)
    assert [x.joint for x in fb.detect_collisions(model, hit).collisions] == ["joint1"]


def resting_log(model, seed):
    """A log of moves of 2 s and rests of 1 s, in which some joints crawl."""
    rng = np.random.default_rng(seed)
    t = np.arange(2001) / 100.0
    q = np.zeros((len(t), model.nv))
    for start in np.arange(0.5, 18.0, 3.0):
        s = np.clip(0.5 * (t - start), 0.0, 1.0)[:, None]
        step = rng.uniform(-1.0, 1.0, model.nv) * rng.choice([1.0, 0.06], model.nv)
        q += step * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    qd = np.gradient(q, t, axis=0)
    tau = fb.inverse_dynamics(model, q, qd, np.gradient(qd, t, axis=0))
    tau = tau + 0.02 * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
    rates = qd + 1e-3 * rng.normal(size=q.shape)
    names = model.velocity_names
    return fb.Log(t, q, rates, tau, None, names, np.ones(len(t), dtype=bool))


def test_a_model_that_lacks_much_is_told():
    model, clean, _, _ = case(0)
    found = fb.detect_collisions(model.without("friction"), clean)
    assert any("identify the robot first" in text for text in found.notices)
    with pytest.raises(fb.FreebodyError, match="4 s at least"):
        fb.detect_collisions(model, replace(clean, **first_seconds(clean, 3.0)))


def first_seconds(x, seconds):
    """The arrays of a log up to a time."""
    names = ("time", "position", "velocity", "torque", "measured")
    return {name: getattr(x, name)[x.time < seconds] for name in names}
