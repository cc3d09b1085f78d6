"""A joint range of no width means that none was given, and what depends on structure is not decided
within limits."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Limits

ARM = {"l": [0.4, 0.3], "lc": [0.2, 0.15], "m": [2.0, 1.0], "I": [0.03, 0.01]}
POINTS = {"l": [1.0, 1.0], "lc": [1.0, 1.0], "m": [0.0, 1.0], "I": [0.0, 0.0]}
NARROW = [(0.0, 0.0), (np.pi, np.pi), (0.0, 1e-12), Limits(0.0, 0.0, 0.0, 0.0)]


@pytest.mark.parametrize("limits", NARROW)
def test_base_parameters_do_not_depend_on_the_ranges(limits):
    free = fb.base_parameters(fb.planar("RR", **ARM))
    held = fb.base_parameters(fb.planar("RR", **ARM, limits=[limits, limits]))
    assert len(free) == 6
    assert held.names == free.names
    np.testing.assert_allclose(held.values, free.values, rtol=1e-9)


@pytest.mark.parametrize("limits", NARROW)
def test_a_range_never_makes_a_joint_massless(limits):
    """A point mass at the tip of a massless arm: M is singular where the arm is straight, θ₂ = 0,
    and nowhere else."""
    model = fb.planar("RR", **POINTS, limits=[limits, limits])
    free = fb.planar("RR", **POINTS)
    state = [0.3, 1.0], [0.0, 0.0], [1.0, 2.0]
    np.testing.assert_array_equal(
        fb.forward_dynamics(model, *state), fb.forward_dynamics(free, *state)
    )


def test_random_states_take_a_range_of_no_width_as_not_given():
    free = fb.random_state(fb.planar("RP", **ARM), 3, 100)
    held = fb.random_state(fb.planar("RP", **ARM, limits=[(0, 0), (0.7, 0.7)]), 3, 100)
    for a, b in zip(free, held, strict=True):
        np.testing.assert_array_equal(a, b)
    kept = fb.random_state(fb.planar("RP", **ARM, limits=[(-0.1, 0.2), None]), 3, 100)[0]
    assert kept[:, 0].min() > -0.1
    assert kept[:, 0].max() < 0.2


def test_inverse_kinematics_takes_a_range_of_no_width_as_not_given():
    free = fb.planar("RR", **ARM)
    held = fb.planar("RR", **ARM, limits=[(0, 0), (0, 0)])
    target = fb.forward_kinematics(free, [0.3, 0.8])[:2, 2]
    found = [fb.inverse_kinematics(model, target) for model in (free, held)]
    np.testing.assert_array_equal(found[1].q, found[0].q)
    assert found[1].within_limits.all()
