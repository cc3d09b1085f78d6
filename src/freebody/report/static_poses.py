"""The poses in which gravity loads the joints most."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.ranges import angular, ranges
from freebody.report.results import StaticPose
from freebody.trees import dynamics
from freebody.trees.states import integrate, random_state

SAMPLES = 4096
_ROUNDS, _TRIES = 24, 128


def worst_poses(model: Model) -> tuple[StaticPose, ...]:
    """For each coordinate the pose, within the limits, of the largest gravity torque found.

    4096 random poses (the same every time); the best of each coordinate is then improved by random
    steps of shrinking size. Coordinates that gravity never loads are left out.
    """
    q, _, _ = random_state(model, seed=0, batch=SAMPLES)
    load = np.abs(dynamics.gravity_torque(model, q))
    best = q[np.argmax(load, axis=0)]  # (nv, nq): a pose for each coordinate
    best = _improved(model, best)
    torques = np.diagonal(dynamics.gravity_torque(model, best))
    allowed, turns = ranges(model), angular(model)
    floor = 1e-9 * max(float(np.abs(torques).max(initial=0.0)), 1e-12)
    shares = np.where(np.isfinite(allowed.effort), np.abs(torques) / allowed.effort, np.nan)
    return tuple(
        StaticPose(name, best[k], float(torque), "N m" if turns[k] else "N", float(shares[k]))
        for k, (name, torque) in enumerate(zip(model.velocity_names, torques, strict=True))
        if abs(torque) > floor
    )


def _improved(model: Model, poses: Array) -> Array:
    """Poses (nv, nq), each moved towards a larger gravity torque of its own coordinate."""
    rng = np.random.default_rng(0)
    allowed = ranges(model)
    each = np.arange(model.nv)
    for k in range(_ROUNDS):
        step = 0.5 * 0.75**k * np.minimum(allowed.width, np.pi)
        steps = rng.normal(size=(model.nv, _TRIES, model.nv)) * step
        steps[:, 0] = 0.0
        tried = clipped(model, integrate(model, np.repeat(poses[:, None], _TRIES, axis=1), steps))
        load = np.abs(dynamics.gravity_torque(model, tried)[each, :, each])
        poses = tried[each, np.argmax(load, axis=1)]
    return poses


def clipped(model: Model, q: Array) -> Array:
    """q brought within the limits."""
    from freebody.motion.ranges import position_columns

    allowed = ranges(model)
    iq, iv = position_columns(model)
    q = q.copy()
    q[..., iq] = np.clip(q[..., iq], allowed.lower[iv], allowed.upper[iv])
    return q
