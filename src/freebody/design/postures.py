"""Postures at which gravity loads each joint most."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.shafts import untwisted
from freebody.motion.ranges import position_columns, ranges
from freebody.trees import dynamics
from freebody.trees.positions import integrate, random_state

_SAMPLES = 4096
_ROUNDS, _TRIES = 24, 128


def heaviest_postures(model: Model) -> Array:
    """For each coordinate of an open chain the posture (nv, nq), within the limits, of the largest
    gravity torque found.

    4096 random ones (the same every time); the best of each coordinate is then improved by random
    steps of shrinking size. Shafts of flexible joints are untwisted, and carry what their joints
    do.
    """
    rigid = untwisted(model)
    if rigid is not None:
        whole, found = rigid.at(heaviest_postures(rigid.model)), np.empty((model.nv, model.nq))
        found[rigid.rates] = whole
        for _, at, _, to in rigid.twists:
            found[at] = whole[to]
        return found
    q, _, _ = random_state(model, seed=0, batch=_SAMPLES)
    load = np.abs(dynamics.gravity_torque(model, q))
    return _improved(model, q[np.argmax(load, axis=0)])


def _improved(model: Model, poses: Array) -> Array:
    """Poses (nv, nq), each moved towards a larger gravity torque of its own coordinate."""
    rng = np.random.default_rng(0)
    allowed = ranges(model)
    each = np.arange(model.nv)
    for k in range(_ROUNDS):
        step = 0.5 * 0.75**k * np.minimum(allowed.width, np.pi)
        steps = rng.normal(size=(model.nv, _TRIES, model.nv)) * step
        steps[:, 0] = 0.0
        tried = _clipped(model, integrate(model, np.repeat(poses[:, None], _TRIES, axis=1), steps))
        load = np.abs(dynamics.gravity_torque(model, tried)[each, :, each])
        poses = tried[each, np.argmax(load, axis=1)]
    return poses


def _clipped(model: Model, q: Array) -> Array:
    """q brought within the limits."""
    allowed = ranges(model)
    iq, iv = position_columns(model)
    q = q.copy()
    q[..., iq] = np.clip(q[..., iq], allowed.lower[iv], allowed.upper[iv])
    return q
