"""Runs of a model that is driven by the torques of a motion, in steps that are known beforehand:
the stretches on which the motion is smooth, or equal parts of them.

So the torques of all stages come in one batch, and a step costs no more than its thirteen
accelerations. The method is that of scipy's DOP853 (Hairer, Nørsett and Wanner 1993), whose own
estimate tells whether the steps are short enough.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from freebody.arrays import Array
from freebody.motion.motion import Motion
from freebody.motion.simulation.first_order_system import System

PARTS = (1, 3, 9)
"""Into how many steps a stretch is divided, one after the other where the method asks for more."""
_ERROR = 1e-12
"""Of a step, relative to 1 + the state."""
_MOST = 300_000
"""Evaluations, of all lanes together."""
_AT_ONCE = 4096
"""Steps whose torques are computed together."""
_BESIDE = 1e-6
"""Of a step: there a jump at its beginning is over, and one at its end is not yet."""
_SAME = 1e-9
"""Of the motion: times as near as that are one."""
_NODES = np.append(DOP853.C, 1.0)


class TooLong(Exception):
    """Steps are too long for the method, or too many."""


@dataclass(frozen=True)
class Reference:
    """The torque that the motion needs at any time, and the system under it."""

    system: System
    motion: Motion

    def torque(self, t: Array, around: Array | None = None) -> Array:
        """The torque at times t; `around`: times on the side of a jump on which t is meant."""
        return self.system.torque(t, *self.motion.at(t, around))

    def state(self, t: Array) -> Array:
        """(q, q̇) at times t."""
        q, qd, _ = self.motion.at(t)
        return np.concatenate([q, qd], axis=-1)


def edges(motion: Motion, start: Array, end: Array, parts: int) -> Array:
    """Times (k + 1, lanes) from each start (lanes,) to its end, between which the motion is smooth,
    each such stretch in equal parts; lanes of fewer steps stand still at their end."""
    pieces = motion.t if motion.pieces is None else motion.pieces.breaks
    every = np.unique(np.concatenate([motion.t, pieces, motion.jumps]))
    near = _SAME * motion.duration

    def lane(begin: float, last: float) -> Array:
        inside = every[(every > begin + near) & (every < last - near)]
        apart = inside[np.diff(inside, prepend=begin) > near]
        whole = np.concatenate([[begin], apart, [last]])
        within = np.arange(parts * (len(whole) - 1) + 1) / parts
        return np.interp(within, np.arange(len(whole)), whole)

    lanes = [lane(*ends) for ends in zip(start.tolist(), end.tolist(), strict=True)]
    count = max(map(len, lanes))
    return np.stack([np.pad(x, (0, count - len(x)), mode="edge") for x in lanes], axis=-1)


def steps(reference: Reference, times: Array) -> Iterator[Array]:
    """The states (lanes, n) at times (k + 1, lanes) behind the first, at which they are on the
    motion, as they are reached. Raises TooLong."""
    system, y = reference.system, reference.state(times[0])
    if times.size * len(_NODES) > _MOST:
        raise TooLong
    at_once = max(1, _AT_ONCE // times.shape[1])
    for first in range(0, len(times) - 1, at_once):
        some = times[first : first + at_once + 1]
        begin, h = some[:-1, None], np.diff(some, axis=0)[:, None]
        at = begin + h * _NODES[:, None]
        tau = reference.torque(at, begin + h * np.clip(_NODES, _BESIDE, 1.0 - _BESIDE)[:, None])
        for now, torque, length in zip(at, tau, h[:, 0, :, None], strict=True):
            y = _step(system, now, torque, length, y)
            yield y


def _step(system: System, t: Array, tau: Array, h: Array, y: Array) -> Array:
    """The states (lanes, n) one step h (lanes, 1) on; t (13, lanes) and tau (13, lanes, nv) of the
    stages, the last at the end."""
    slopes = np.empty((len(_NODES), *y.shape))
    now = y
    for k, weights in enumerate(_WEIGHTS):
        if k:
            now = y + h * (weights @ slopes[:k].reshape(k, -1)).reshape(y.shape)
        slopes[k] = system.rate(t[k], now, tau[k])
    fifth, third = (
        (weights @ slopes.reshape(len(slopes), -1)).reshape(y.shape) / (1.0 + np.abs(y))
        for weights in (DOP853.E5, DOP853.E3)
    )
    size = np.linalg.norm(fifth, axis=-1) ** 2
    whole = size + 0.01 * np.linalg.norm(third, axis=-1) ** 2
    error = np.abs(h[:, 0]) * size / np.sqrt(np.where(whole > 0.0, whole, 1.0) * y.shape[-1])
    if not (error <= _ERROR).all():  # what is no number, too
        raise TooLong
    return system.normalised(now)


_WEIGHTS = [*(row[:k] for k, row in enumerate(DOP853.A)), DOP853.B]
"""Of the slopes before each stage; the last leads to the end of the step."""
