"""Friction that changes from log to log is told, and one that does not is not."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, log, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb")
ARM = arm()


def logs(factor):
    """Two logs of an arm, in the second of which the second joint has another friction."""
    rng = np.random.default_rng(7)
    model = with_random_numbers(ARM, rng, FRICTION)
    drive = model.bodies[1].joint.drive
    changed = {x: factor * getattr(drive, x) for x in FRICTION}
    warm = model.with_drive(model.joint_names[1], rotor=drive.rotor, gear=drive.gear, **changed)
    return log(model, rng), log(warm, rng)


def test_friction_that_drifts_is_told():
    cold, warm = logs(0.8)
    found = fb.identify(ARM, [cold, warm], friction=FRICTION)
    (told,) = [x for x in found.drift if x.significant]
    assert told.joint == ARM.joint_names[1]
    ratio = told.factor[told.log == 1].mean() / told.factor[told.log == 0].mean()
    assert ratio == pytest.approx(0.8, abs=0.03)
    assert any(text.startswith(f"Friction drifts: {told.joint}") for text in found.notices)
    assert any("as warm as at work" in text for text in found.next)


def test_friction_that_stays_is_not_told_to_drift():
    found = fb.identify(ARM, logs(1.0), friction=FRICTION)
    assert not any(x.significant for x in found.drift)
    assert all(np.all(np.abs(x.factor - 1.0) < 3.0 * x.half) for x in found.drift)
