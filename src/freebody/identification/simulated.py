"""A log that the model of a robot would have given, for trying identification without a robot."""

from __future__ import annotations

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.identification.logs.log import Log
from freebody.model.model import Model

_RATE, _DURATION, _PERIOD, _HARMONICS = 100.0, 30.0, 10.0, 5
"""Samples a second (Hz), length and period (s) of the motion, a Fourier series of so many terms."""
_REACH = {True: 0.8, False: 0.1}
"""Greatest distance from the middle of the range, of a joint that turns (rad) or slides (m)."""
_NOISE = 0.02
"""Noise of torques, over their RMS."""


def simulated_log(model: Model, seed: int = 0) -> Log:
    """A log (100 Hz, 30 s) of a random periodic motion of the robot as its model has it, with
    white noise on the torques; nothing is taken from a real robot."""
    rng, n = np.random.default_rng(seed), model.nv
    t = np.arange(0.0, _DURATION, 1.0 / _RATE)
    w = 2.0 * np.pi / _PERIOD * np.arange(1, _HARMONICS + 1)
    sines, cosines = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    a, b = rng.normal(size=(2, _HARMONICS, n))
    lower, upper = model.limits.lower, model.limits.upper
    bounded = np.isfinite(lower) & np.isfinite(upper)
    low, high = np.where(bounded, lower, 0.0), np.where(bounded, upper, 0.0)
    turns = {body.joint.name: body.kind.turns for body in model.bodies}
    reach = np.array([_REACH[turns[name]] for name in model.velocity_names])
    reach = np.where(bounded, np.minimum(reach, 0.45 * (high - low)), reach)
    shape = sines @ a + cosines @ b
    scale = reach / np.abs(shape).max(axis=0)
    a, b = a * scale, b * scale
    q = 0.5 * (low + high) + sines @ a + cosines @ b
    qd = cosines @ (w[:, None] * a) - sines @ (w[:, None] * b)
    qdd = -sines @ (w[:, None] ** 2 * a) - cosines @ (w[:, None] ** 2 * b)
    torque = inverse_dynamics(model, q, qd, qdd)
    noise = _NOISE * np.sqrt(np.mean(torque**2, axis=0))
    return Log(
        t,
        q,
        qd,
        torque + noise * rng.normal(size=torque.shape),
        None,
        model.velocity_names,
        np.ones(len(t), dtype=bool),
        source="simulated",
        notices=("This log is simulated from the model: no robot gave it.",),
    )
