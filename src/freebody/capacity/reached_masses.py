"""The masses at which a robot reaches its limits, at states and along motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.capacity.loaded_case import CaseAtStates, LoadedCase, MotionStates
from freebody.capacity.payload_limits import limited_parts, reached
from freebody.motion.motion import Motion

_BETWEEN = 65
"""Instants that are looked at in the two intervals beside the one that limits."""
_BESIDE = 1e-6
"""Share of an interval: so far from a jump of the accelerations its two sides are looked at."""
_FEW = 8
"""Samples for each break of a motion with few breaks."""
_BLOCK = 65536
"""Samples at once."""


def reached_masses(case: LoadedCase, states: MotionStates) -> tuple[Array, np.ndarray]:
    """(masses (..., K) at which each of `limited_parts` reaches its limit, 0 of one that is beyond
    it without payload, infinite where a mass changes nothing; whether it is beyond it)."""
    shape, n = states[0].shape[:-1], len(limited_parts(case))
    flat = [x.reshape(-1, x.shape[-1]) for x in states]
    mass, over = np.empty((len(flat[0]), n)), np.empty((len(flat[0]), n), dtype=bool)
    for first in range(0, len(flat[0]), _BLOCK):
        some = slice(first, first + _BLOCK)
        q, qd, qdd = (x[some] for x in flat)
        mass[some], over[some] = reached(CaseAtStates(case, (q, qd, qdd)))
    return mass.reshape(*shape, n), over.reshape(*shape, n)


def along(case: LoadedCase, motions: Sequence[Motion]) -> tuple[Array, np.ndarray, Array]:
    """(masses (P, K), whether a part is beyond its limit without (P, K), when (P, K)) of
    motions."""
    samples = [_samples(one) for one in motions]
    mass, over, time = _least(case, samples)
    if case.model.loops:  # between samples its positions are not closed
        return mass, over, time
    least = np.take_along_axis(time, np.argmin(mass, axis=-1)[:, None], axis=-1)[:, 0]
    closer = [_beside(one, float(at)) for one, at in zip(motions, least, strict=True)]
    near, worse, when = _least(case, closer)
    return np.minimum(mass, near), over | worse, np.where(near < mass, when, time)


_TimedStates = tuple[Array, MotionStates]
"""Times and states of samples."""


def _least(case: LoadedCase, samples: Sequence[_TimedStates]) -> tuple[Array, np.ndarray, Array]:
    """The least masses among samples of each motion, whether a part is beyond its limit in one,
    and the times of the least."""
    q, qd, qdd = (np.concatenate(parts) for parts in zip(*(x[1] for x in samples), strict=True))
    every, loaded = reached_masses(case, (q, qd, qdd))
    found = []
    ends = np.cumsum([len(t) for t, _ in samples])
    for (t, _), end in zip(samples, ends, strict=True):
        part = slice(end - len(t), end)
        k = np.argmin(every[part], axis=0)
        found.append(
            (np.take_along_axis(every[part], k[None], axis=0)[0], loaded[part].any(axis=0), t[k])
        )
    mass, over, time = zip(*found, strict=True)
    return np.array(mass), np.array(over), np.array(time)


def _samples(motion: Motion) -> _TimedStates:
    """The samples of a motion, and both sides of each jump of its accelerations: of all breaks of
    its pieces where these are few, which takes less than to find the jumps."""
    own = (motion.q, motion.qd, motion.qdd)
    if motion.pieces is None:
        return motion.t, own
    breaks = motion.pieces.breaks
    jumps = breaks[1:-1] if _FEW * len(breaks) <= len(motion.t) else motion.jumps
    if not len(jumps):
        return motion.t, own
    step = _BESIDE * float(np.diff(breaks).min())
    twice = np.concatenate([jumps, jumps])
    sides = motion.at(twice, np.concatenate([jumps - step, jumps + step]))
    q, qd, qdd = (np.concatenate(pair) for pair in zip(own, sides, strict=True))
    return np.concatenate([motion.t, twice]), (q, qd, qdd)


def _beside(motion: Motion, time: float) -> _TimedStates:
    """Instants between the samples on either side of one."""
    k = int(np.argmin(np.abs(motion.t - time)))
    ends = motion.t[max(k - 1, 0)], motion.t[min(k + 1, len(motion.t) - 1)]
    t = np.linspace(*ends, _BETWEEN)
    return t, motion.at(t)
