"""Poses that an instrument would have seen of a robot slightly off its model, for trying
calibration without a robot."""

from __future__ import annotations

import numpy as np

from freebody.identification.calibration.chain import chain_to, turned
from freebody.identification.calibration.instrument import FittedPose
from freebody.identification.calibration.poses import Poses
from freebody.model.model import Model
from freebody.trees.positions import random_state

_COUNT, _OFF = 60, 1e-3
"""Number of poses, and standard deviation (m, rad) of what is off."""
_ROBOT = 33
"""Seed of what is off."""
_NOISE = 5e-5
"""Standard deviation (m, rad) of each measured coordinate."""


def simulated_poses(model: Model, frame: str | None = None, seed: int = 0) -> Poses:
    """Sixty random poses of the robot with each joint's frame and zero off by about 1 mm and 1
    mrad, seen from 2 m away with noise of 0.05 mm and mrad; nothing is taken from a real robot.
    seed: of the poses and of the noise; the robot is always the same."""
    rng = np.random.default_rng(_ROBOT)
    chain = chain_to(model, frame, gears=False)
    q, _, _ = random_state(model, seed, _COUNT)
    x = _OFF * rng.normal(size=len(chain.names))
    instrument = FittedPose(turned(rng.normal(size=3)), np.array([0.0, 0.0, 2.0]))
    marker = FittedPose(turned(0.1 * rng.normal(size=3)), 0.05 * rng.normal(size=3))
    seen = chain.marker_poses(q, x, instrument, marker)
    rng = np.random.default_rng(seed)
    return Poses(
        q,
        seen.position + _NOISE * rng.normal(size=seen.position.shape),
        seen.rotation @ turned(_NOISE * rng.normal(size=seen.position.shape)),
        "simulated",
        ("These poses are simulated from the model: no robot gave them.",),
    )
