"""The physical robot nearest to base values by linear matrix inequalities, beside the one that
Newton's method finds near a prior."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, exact_log, log, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb", "offset")
ARM = arm()
FLAT = fb.load("2R")


def solver() -> None:
    pytest.importorskip("clarabel", reason="Clarabel is not installed (extra lmi)")


def misfit(found):
    """What the model leaves of the logs beyond what the regression does, as part of that."""
    return sum((x.model / x.regression) ** 2 - 1.0 for x in found.joints)


@pytest.mark.parametrize("bare", [FLAT, ARM], ids=["plane", "space"])
def test_exact_data_of_a_robot_that_exists_are_kept(bare):
    solver()
    model = with_random_numbers(ARM, np.random.default_rng(5)) if bare is ARM else FLAT
    model = model if bare is ARM else driven(FLAT)
    made = exact_log(model, np.random.default_rng(3), duration=30.0)

    found = fb.identify(bare, made, friction=FRICTION[:2], smooth=0.0, lmi=True)

    assert max(abs(x.value - x.in_model) for x in found.parameters) < 1e-8
    assert found.prior_weight == 0.0


def driven(model):
    """The model with rotors and friction."""
    for joint in model.joint_names:
        model = model.with_drive(joint, rotor=0.1, viscous=0.5, coulomb=0.4)
    return model


@pytest.mark.parametrize("seed", range(3))
def test_no_physical_robot_is_nearer_and_the_prior_leads_there(seed):
    solver()
    rng = np.random.default_rng(seed)
    made = log(with_random_numbers(ARM, rng, FRICTION), rng, noise=0.05)

    nearest = fb.identify(ARM, made, friction=FRICTION, lmi=True)
    near_prior = fb.identify(ARM, made, friction=FRICTION)

    assert misfit(nearest) < misfit(near_prior)
    assert misfit(nearest) < 1e-3
    for body in nearest.model.bodies:
        assert body.inertias[0].inertia.fault() is None
        drive = body.joint.drive
        numbers = (drive.viscous, drive.coulomb, drive.rotor)
        assert all(float(x) >= 0.0 for x in numbers)  # type: ignore[arg-type]
    q = rng.uniform(-3.0, 3.0, (50, 3))
    assert np.all(np.linalg.eigvalsh(fb.mass_matrix(nearest.model, q)) > 0.0)
    assert any("nothing that was held beforehand chose them" in x for x in nearest.notices)
    assert "single masses are not told" in nearest.verdict


def test_without_the_solver_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "clarabel", None)
    rng = np.random.default_rng(0)
    made = log(with_random_numbers(ARM, rng), rng)

    with pytest.raises(fb.FreebodyError, match=r"clarabel is not installed; pip install 'freebody"):
        fb.identify(ARM, made, friction=FRICTION, lmi=True)
