"""Simulations that would not end are given up within seconds, with the reason and what there was;
arguments without effect are refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, FreebodyWarning

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.1], m=[2, 1], I=[0.1, 0.1])
STILL = np.zeros(2)
T = np.linspace(0.0, 1.0, 11)
HEAVY = ARM.replace(gravity=0.0)
GAIN = 40.0
DAMPER = fb.compile(lambda qd: [-GAIN * v for v in qd], {"qd": 2}, {"tau": 2})


def damper(t, q, qd):
    return -GAIN * qd


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["auto", "Radau", "rk4"])
def test_a_sampled_torque_that_makes_the_motion_grow(method):
    """The least inertia m that the torque meets would take -GAIN v T / m = -2 v in a sample."""
    step = 1e-3 if method == "rk4" else None
    says = (
        "joint2' grow .* times from one instant to the next; linearised at the start, it is stable"
    )
    start = [0.1, 0.1]
    with pytest.raises(FreebodyError, match=says) as told:
        fb.simulate(HEAVY, [0, 0.3], start, T, damper, method=method, step=step, sample_time=0.02)
    kept = told.value.result
    assert (kept.qd.values[0] == start).all()
    assert np.isfinite(kept.q.values).all()
    least = np.linalg.eigvalsh(fb.mass_matrix(HEAVY, [0, 0.3])).min()
    longest = float(re.search(r"sample_time = ([0-9.e-]+) s\. Sample", str(told.value))[1])
    assert 0.7 < longest / (2.0 * least / GAIN) < 1.1
    found = fb.simulate(HEAVY, [0, 0.3], start, T, damper, sample_time=0.7 * longest)
    assert abs(found.qd.values[-1]).max() < 1e-3


def test_the_arm_of_the_issue_and_many_of_it():
    arm, q = fb.load("ur5e"), [0.0, -1.0, 1.0, 0.0, 0.5, 0.0]
    says = "sample_time = 0.01 s, it makes the motion of 'wrist_3_joint' grow 19. times"
    with pytest.raises(FreebodyError, match=says):
        fb.simulate(arm, q, np.full(6, 0.1), T, lambda t, q, v: -5 * v, sample_time=0.01)
    law = fb.compile(lambda qd, k: [-k * x for x in qd], {"qd": 6, "k": ()}, {"tau": 6})
    gains = {"k": [0.0, 5.0, 0.0]}
    with pytest.warns(FreebodyWarning, match=f"1 of 3 motions could not go on.*sample 1.*{says}"):
        found = fb.simulate(
            arm, q, np.full(6, 0.1), T, law, torque_inputs=gains, sample_time=0.01, tolerance=1e-6
        )
    assert np.isfinite(found.q.values).all(axis=(1, 2)).tolist() == [True, False, True]


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"t": [0, 1e300]}, "more to the end: this run would not end. The times reach to 1e.300 s"),
        ({"t": [0, 1e300], "method": "RK45"}, "The times reach to 1e.300 s"),
        ({"t": [1e15, 1e15 + 1]}, r"At t = 1e\+15 s numbers are 0.1 s apart"),
        ({"torque": lambda t, q, v: 200 * v + 1}, "'joint2' moves at .* the motion diverges"),
        (
            {"torque": lambda t, q, v: -9 * np.sign(v), "method": "DOP853"},
            "a function that jumps, or that returns",
        ),
    ],
)
def test_what_would_not_end_is_given_up(given, says):
    options = {"t": T, **given}
    for many in (False, True) if "method" not in given else (False,):
        q = np.full((2, 2), 0.3) if many else np.full(2, 0.3)
        with (
            pytest.warns(FreebodyWarning, match=says)
            if many
            else pytest.raises(FreebodyError, match=says) as told
        ):
            fb.simulate(ARM, q, STILL, **options)
        if not many:
            assert (told.value.result.q.values[0] == 0.3).all()


RUBBING = ARM.with_drive("joint1", coulomb=1.0)


@pytest.mark.parametrize(
    ("model", "given", "says"),
    [
        (ARM, {"tolerance": 1e-20}, "finer than the rounding of numbers"),
        (ARM, {"tolerance": np.nan}, "tolerance is nan, expected a number above 0"),
        (ARM, {"max_step": 1e-300}, r"max_step is 1e-300 s, 1e\+300 steps in this run"),
        (ARM, {"max_step": 1e-9}, r"1e\+09 steps in this run; 1e\+08 are the most where Python"),
        (ARM, {"step": 1e-9, "torque": lambda t, q, v: 0 * v}, "are the most where Python makes"),
        (ARM, {"step": 1e-13}, r"1e\+13 steps in this run; 1e\+12 are the most\."),
        (ARM, {"every": 11}, "every is 11, beyond the 11 times of t"),
        (ARM, {"friction_width": 0.1}, "is of dry friction, and no joint of 'RR' has any"),
        (RUBBING, {"friction_width": 0.1, "friction": "dry"}, "dry friction has no width"),
        (ARM, {"restitution": 0.5}, "is of stops at the limits of joints, and no joint of 'RR'"),
    ],
)
def test_arguments_that_cannot_be_used_are_refused(model, given, says):
    with pytest.raises(FreebodyError, match=says):
        fb.simulate(model, STILL, STILL, T, **given)


def test_what_is_asked_of_a_search_is_refused_where_a_closed_form_answers():
    arm, linkage = fb.load("ur5e"), fb.load("five_bar")
    target = fb.forward_kinematics(arm, [0.1, -1.0, 1.0, 0.3, 0.5, 0.2])
    tip = fb.forward_kinematics(linkage, fb.assemble(linkage))[:2, 2]
    says = "starts= and seed= are of the numeric search; for '{}' .* a closed form finds all"
    for given in ({"starts": 5}, {"seed": 0}):
        with pytest.raises(FreebodyError, match=says.format("ur5e")):
            fb.inverse_kinematics(arm, target, **given)
        with pytest.raises(FreebodyError, match=says.format("five_bar")):
            fb.inverse_kinematics(linkage, tip, **given)
    with pytest.raises(FreebodyError, match="starts= is of the numeric search; 'five_bar' with"):
        fb.assembly_modes(linkage, fb.assemble(linkage), linkage.passive_names, starts=5)
