"""Instants between the samples of a motion at which a torque, a power or a reaction has its
peak."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics, joint_wrenches
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.files.contradictions import GivenRates
from freebody.motion.motion import Motion
from freebody.motion.ranges import Flags, ranges, with_drive
from freebody.report.bearings import bearing_loads
from freebody.trees.position_rates import Index

_TOLD = 1e-4  # of the largest at the samples: what is higher between them is worth a sample
_EDGE = 1e-4  # of an interval: how far from its ends a jump is not felt
_TRIED = 3  # intervals for each quantity
_ROUNDS, _FAN = 6, 9
_BLOCK = 4096  # intervals at once
_UNLIKELY = 0.05  # of the largest acceleration


def with_peaks(model: Model, motion: Motion) -> Motion:
    """The motion with samples also where a torque, a power or a reaction is largest between those
    that it has, by more than a ten-thousandth, or above its limit.

    Of a closed chain as it is: between samples its positions are not closed. Intervals in which the
    curve is faster accelerated than its samples explain, as between noisy ones, do not count.
    """
    if model.loops:
        return motion
    loads = _Loads(model, motion)
    t = np.array(sorted(set(loads.higher())))
    if not len(t):
        return motion
    every = np.union1d(motion.t, t)
    states = motion.at(every)
    own = np.isin(every, motion.t)
    for found, given in zip(states, (motion.q, motion.qd, motion.qdd), strict=True):
        found[own] = given
    q, qd, qdd = states
    return replace(motion, t=every, q=q, qd=qd, qdd=qdd)


@dataclass(frozen=True)
class _Loads:
    """What drives and joints bear along a motion, K quantities as sizes."""

    model: Model
    motion: Motion

    def at(self, t: Array, around: Array) -> Array:
        """(..., K) at times t (...), on the side of the times `around`."""
        return self._of(*self.motion.at(t, around))

    def _of(self, q: Array, qd: Array, qdd: Array) -> Array:
        model, shape = self.model, q.shape[:-1]
        q, qd, qdd = (x.reshape(-1, x.shape[-1]) for x in (q, qd, qdd))
        tau = inverse_dynamics(model, q, qd, qdd)
        power = np.where(with_drive(model), tau * qd, 0.0)
        wrenches = joint_wrenches(model, q, qd, qdd, reference="child")
        force, moment = wrenches[..., : model.dim], wrenches[..., model.dim :]
        bearings = bearing_loads(model, force, moment).values()
        found = [tau, power, power.sum(axis=-1, keepdims=True)]
        found += [np.linalg.norm(x, axis=-1) for x in (force, moment)]
        found += [np.nan_to_num(x) for x in bearings]
        return np.abs(np.concatenate(found, axis=-1)).reshape(*shape, -1)

    def limits(self, count: int) -> Array:
        """(K,) of the quantities, infinite where there is none."""
        allowed, nv = ranges(self.model), self.model.nv
        found = np.full(count, np.inf)
        found[:nv] = np.where(with_drive(self.model), allowed.effort, np.inf)
        found[nv : 2 * nv] = found[:nv] * allowed.velocity
        return found

    def higher(self) -> Iterator[float]:
        """Times of peaks that the samples miss."""
        motion = self.motion
        known = self._of(motion.q, motion.qd, motion.qdd).max(axis=0)
        likely = self._likely()
        seen = np.where(likely[:, None], self._seen(), 0.0)
        limits = self.limits(seen.shape[-1])
        first = np.argsort(-seen, axis=0)[:_TRIED].T
        column = np.repeat(np.arange(seen.shape[-1]), first.shape[1])
        best, where = self._climbed(first.ravel(), column)
        for k in range(seen.shape[-1]):
            tried = np.flatnonzero((column == k) & likely[first.ravel()])
            if not len(tried):
                continue
            top = tried[np.argmax(best[tried])]
            crosses = best[top] > limits[k] >= known[k]
            if best[top] > known[k] * (1.0 + _TOLD) or crosses:
                yield float(where[top])

    def _seen(self) -> Array:
        """(intervals, K) the largest of three places in each interval of the knots."""
        knots = self.motion.knots
        start, step = knots[:-1, None], np.diff(knots)[:, None]
        times = start + step * np.array([_EDGE, 0.5, 1.0 - _EDGE])
        around = np.broadcast_to(start + 0.5 * step, times.shape)
        parts = np.array_split(np.arange(len(times)), -(-len(times) // _BLOCK))
        return np.concatenate([self.at(times[k], around[k]).max(axis=1) for k in parts])

    def _climbed(self, interval: Index, column: Index) -> tuple[Array, Array]:
        """(largest values (C,), their times) of quantities in intervals of the knots."""
        knots = self.motion.knots
        start, step = knots[interval], np.diff(knots)[interval]
        around = np.repeat((start + 0.5 * step)[:, None], _FAN, axis=1)
        low, high = np.full(len(start), _EDGE), np.full(len(start), 1.0 - _EDGE)
        for _ in range(_ROUNDS):
            part = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _FAN)
            values = self.at(start[:, None] + step[:, None] * part, around)
            values = np.take_along_axis(values, column[:, None, None], axis=2)[..., 0]
            k = np.argmax(values, axis=1)
            pick = np.arange(len(k))
            low, high = part[pick, np.maximum(k - 1, 0)], part[pick, np.minimum(k + 1, _FAN - 1)]
        return values[pick, k], start + step * part[pick, k]

    def _likely(self) -> Flags:
        """(intervals,) of the knots, in which the acceleration is as its ends say: a quarter and
        three quarters of the way, as halfway nothing is seen of an error of the positions."""
        motion, knots = self.motion, self.motion.knots
        start, step = knots[:-1], np.diff(knots)
        middle = start + 0.5 * step
        first, last = (motion.at(knots[a], middle)[2] for a in (slice(None, -1), slice(1, None)))
        likely = np.ones(len(step), dtype=bool)
        for part in (0.25, 0.75):
            inside = motion.at(start + part * step, middle)[2]
            found = GivenRates(inside, first, last, np.zeros(1))
            likely &= (found.contradicted <= _UNLIKELY).all(axis=1)
        return likely
