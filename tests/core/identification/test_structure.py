"""What `fb.identify` takes as known is judged by the logs: geometry, zeros, clocks, and whether
parts of them agree; where they do not, nothing is stated that does not hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, log, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb", "offset")
ARM = arm()
ROWS = [
    {"a": 0.0, "alpha": np.pi / 2, "d": 0.3},
    {"a": 0.6, "alpha": 0.0, "d": 0.0},
    {"a": 0.35, "alpha": 0.0, "d": 0.1},
]
LONGER = fb.dh(ROWS, convention="standard", name="arm")
"""The arm with its second link 0.2 m too long."""


def logs(seed, change=lambda x: x, bare=ARM):
    """A robot, and two logs of it that a change has spoilt alike."""
    rng = np.random.default_rng(seed)
    model = with_random_numbers(bare, rng, FRICTION)
    return model, change(log(model, rng)), change(log(model, rng))


def late(seconds):
    """A change of logs at 100 Hz that delays their torques."""
    return lambda x: replace(x, torque=np.roll(x.torque, round(100.0 * seconds), axis=0))


def zero(x):
    """The log of an arm whose second encoder says 0.3 rad too much."""
    return replace(x, position=x.position + [0.0, 0.3, 0.0])


def of_bodies(found):
    return [x for x in found.parameters if x.kind == "inertial"]


def holding(found, model):
    """The share of the base parameters whose stated intervals hold."""
    pi = fb.inertial_parameters(model)
    true = found.combinations @ [pi[name] for name in found.inertial_names]
    return np.mean([x.lower <= y <= x.upper for x, y in zip(of_bodies(found), true, strict=True)])


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("model", "change", "joint", "said", "size"),
    [
        (LONGER, lambda x: x, "joint3", "joint3 by -0.2", -0.2),
        (ARM, zero, "joint2", "the zero of joint2 by -0.", -0.3),
    ],
    ids=["length", "zero"],
)
def test_another_geometry_is_told_and_its_intervals_are_withdrawn(
    seed, model, change, joint, said, size
):
    _, used, unseen = logs(seed, change)
    found = fb.identify(model, used, validate=unseen, friction=FRICTION)
    wrong = found.structure.misplaced
    assert wrong.displacement.joint == joint
    assert wrong.size == pytest.approx(size, rel=0.2)
    assert not found.trusted
    assert all(np.isnan(x.lower) and "not where the model" in x.withdrawn for x in of_bodies(found))
    assert "what it takes as known is wrong" in found.verdict
    assert any("another geometry" in x and said in x for x in found.notices)
    assert not any("hold" in x for x in found.notices)
    assert any("fb.calibrate" in x for x in found.next)


def test_a_plane_robot_with_a_wrong_length_is_told():
    true, longer = (
        fb.planar("RR", l=[a, 0.8], lc=[0.5, 0.4], m=[3.0, 2.0], I=[0.2, 0.1]) for a in (1.0, 1.1)
    )
    found = fb.identify(longer, log(true, np.random.default_rng(4)), friction=FRICTION)
    wrong = found.structure.misplaced
    assert wrong.text().startswith("joint2 by -0.1 m along x of its frame")
    assert wrong.size == pytest.approx(-0.1, abs=0.02)


@pytest.mark.sample(2)
@pytest.mark.parametrize(("seconds", "seed"), [(0.05, 0), (0.05, 1), (-0.02, 2)])
def test_torques_that_are_late_are_put_in_time(seconds, seed):
    model, used, unseen = logs(seed, late(seconds))
    found = fb.identify(ARM, used, validate=unseen, friction=FRICTION)
    delay = found.structure.delay
    assert delay.corrected
    assert delay.seconds == pytest.approx(seconds, abs=1.5 * delay.half)
    assert found.trusted
    assert holding(found, model) > 0.85
    word = "later" if seconds > 0.0 else "earlier"
    assert any(f"ms {word} than positions" in x for x in found.notices)
    straight = fb.identify(ARM, *logs(seed)[1:2], friction=FRICTION)
    values = [[x.value for x in of_bodies(each)] for each in (found, straight)]
    halves = [x.upper - x.lower for x in of_bodies(straight)]
    assert np.all(np.abs(np.subtract(*values)) < halves)


def test_torques_that_are_far_too_early_are_told_and_not_put_in_time():
    """Found in steps, each of which is short."""
    _, used, _ = logs(0, late(-0.4))
    found = fb.identify(ARM, used, friction=FRICTION)
    delay = found.structure.delay
    assert not delay.corrected
    assert delay.seconds == pytest.approx(-0.4, abs=0.15)
    assert not found.trusted
    assert all(
        np.isnan(x.lower) and "not of the same time" in x.withdrawn for x in of_bodies(found)
    )
    assert any("too much to be put right" in x for x in found.notices)


def test_logs_that_disagree_are_told_and_intervals_are_wider():
    rng = np.random.default_rng(5)
    model = with_random_numbers(ARM, rng, FRICTION)
    both = [log(model, rng), log(model.with_payload(0.5), rng)]
    found = fb.identify(ARM, both, validate=log(model, rng), friction=FRICTION)
    other = found.structure.disagreement
    assert other.parts.startswith("the log")
    assert other.factor > 1.5
    assert not found.trusted
    assert any("Parts of the logs disagree" in x for x in found.notices)
    assert any("Log the parts that disagree" in x for x in found.next)
    assert "times as wide" in found.verdict


def test_a_zero_that_turns_the_last_link_alone_is_no_fault():
    """Bodies behind it are turned with it: torques are the same, and no log tells it."""
    _, used, unseen = logs(3, lambda x: replace(x, position=x.position + [0.0, 0.0, 0.3]))
    found = fb.identify(ARM, used, validate=unseen, friction=FRICTION)
    assert found.trusted
