"""The masses at which the torques of a robot reach their limits, at states and along motions.

At given positions, rates and accelerations the torque that a joint transmits is affine in the mass
of a load of given shape and place, t = t₀ + m t₁: t₁ is what a kilogram adds. The drive gives in
addition what friction and rotor take, which no mass changes, and what the gear loses of t, a part
that depends on the way of the power alone. So the torque of the drive rises or falls with m all the
way, and the mass at which it reaches its limit has a closed form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.any_chain.effort_limits import Followers, followers
from freebody.arrays import Array
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import CLOSE
from freebody.motion.smooth_friction import lost_torque, motor_springs, rotor_torque
from freebody.reach.payload_map import NO_SLOPE

_ROUNDING = 1e-13
"""Change of a torque, as a part of it, that is none."""
_BETWEEN = 65
"""Instants that are looked at in the two intervals beside the one that limits."""
_BESIDE = 1e-6
"""Share of an interval: so far from a jump of the accelerations its two sides are looked at."""
_FEW = 8
"""Samples for each break of a motion with few breaks."""
_BLOCK = 65536
"""Samples at once."""

_MotionStates = tuple[Array, Array, Array]
"""Positions, rates and accelerations of samples."""


@dataclass(frozen=True)
class LoadedCase:
    """A robot without and with a kilogram, the limits of its drives (nv,), wrenches on it, and its
    followers that have limits, without and with the kilogram."""

    model: Model
    carrying: Model
    effort: Array
    wrenches: Mapping[str, Array] | None
    followers: tuple[Followers, Followers] | None

    @staticmethod
    def of(
        model: Model,
        kilogram: Mapping[str, Any],
        frame: str,
        effort: Array,
        wrenches: Mapping[str, Array] | None,
    ) -> LoadedCase:
        """The case of a robot that carries a load, of which `kilogram` tells a kilogram as
        arguments of `Model.with_payload`, at a frame."""
        carrying = _carrying(model, kilogram, frame)
        bare, loaded = followers(model), followers(carrying)
        both = None if bare is None or loaded is None else (bare, loaded)
        return LoadedCase(model, carrying, effort, wrenches, both)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all that may have a limit: the coordinates, then followers (K in all)."""
        more = () if self.followers is None else self.followers[0].names
        return (*self.model.velocity_names, *more)

    def masses(self, states: _MotionStates) -> tuple[Array, np.ndarray]:
        """(masses (..., K) at which each joint reaches its limit, 0 of one that is overloaded
        without, infinite where a mass changes nothing; whether it is overloaded)."""
        shape, n = states[0].shape[:-1], len(self.names)
        flat = [x.reshape(-1, x.shape[-1]) for x in states]
        mass, over = np.empty((len(flat[0]), n)), np.empty((len(flat[0]), n), dtype=bool)
        for first in range(0, len(flat[0]), _BLOCK):
            some = slice(first, first + _BLOCK)
            mass[some], over[some] = self._masses(*(x[some] for x in flat))
        return mass.reshape(*shape, n), over.reshape(*shape, n)

    def _masses(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, np.ndarray]:
        model, at, loads = self.model, (q, qd, qdd), self.wrenches
        tau = inverse_dynamics(model, *at, loads)
        lossy = bool(lossy_joints(model.bodies))
        sent, rest = tau, np.zeros_like(tau)
        carrying = self.carrying
        if lossy:
            bare, carrying = model.without("friction"), carrying.without("friction")
            whole = inverse_dynamics(bare, *at, loads)
            sent = whole - rotor_torque(model, q, qd, qdd) - motor_springs(model, q, qd)
            rest = tau - sent - lost_torque(model, qd, sent)
            slope = inverse_dynamics(carrying, *at, loads) - whole
        else:
            whole = tau
            slope = inverse_dynamics(carrying, *at, loads) - tau
        _without_rounding(slope, whole)
        bound = np.where(np.isfinite(self.effort), self.effort, 0.0)
        most = np.sign(slope) * bound - rest
        if lossy:  # of what is transmitted at the limit, by the way of its power
            lost = lost_torque(model, qd, most)
            most = most / (1.0 + lost / np.where(most == 0.0, 1.0, most))
        mass, over = _reached(most - sent, slope, tau, self.effort)
        if self.followers is None:
            return mass, over
        bare, loaded = self.followers
        tau = bare.torques(*at, loads)
        slope = loaded.torques(*at, loads) - tau
        _without_rounding(slope, tau)
        more, worse = _reached(np.sign(slope) * bare.limits - tau, slope, tau, bare.limits)
        return np.concatenate([mass, more], -1), np.concatenate([over, worse], -1)


def _without_rounding(slope: Array, whole: Array) -> None:
    """Set what a kilogram adds (T, n) to 0 where it is what rounding leaves of the torques."""
    rounding = _ROUNDING * np.abs(whole).max(axis=-1, keepdims=True)
    slope[np.abs(slope) <= np.maximum(rounding, NO_SLOPE)] = 0.0


def _reached(left: Array, slope: Array, tau: Array, limits: Array) -> tuple[Array, np.ndarray]:
    """(masses (T, n) that use up what is left to limits (n,), whether torques exceed them)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        mass = np.where(slope == 0.0, np.inf, left / slope)
    over = np.isfinite(limits) & (np.abs(tau) > limits * (1.0 + CLOSE))
    mass = np.where(np.isfinite(limits), np.maximum(mass, 0.0), np.inf)
    return np.where(over, 0.0, mass), over


def along(case: LoadedCase, motions: Sequence[Motion]) -> tuple[Array, np.ndarray, Array]:
    """(masses (P, nv), whether a drive is overloaded without (P, nv), when (P, nv)) of motions."""
    samples = [_samples(one) for one in motions]
    mass, over, time = _least(case, samples)
    if case.model.loops:  # between samples its positions are not closed
        return mass, over, time
    least = np.take_along_axis(time, np.argmin(mass, axis=-1)[:, None], axis=-1)[:, 0]
    closer = [_beside(one, float(at)) for one, at in zip(motions, least, strict=True)]
    near, worse, when = _least(case, closer)
    return np.minimum(mass, near), over | worse, np.where(near < mass, when, time)


_TimedStates = tuple[Array, _MotionStates]
"""Times and states of samples."""


def _least(case: LoadedCase, samples: Sequence[_TimedStates]) -> tuple[Array, np.ndarray, Array]:
    """The least masses among samples of each motion, whether a drive is overloaded in one, and the
    times of the least."""
    q, qd, qdd = (np.concatenate(parts) for parts in zip(*(x[1] for x in samples), strict=True))
    every, loaded = case.masses((q, qd, qdd))
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


def _carrying(model: Model, kilogram: Mapping[str, Any], frame: str) -> Model:
    name = "carried"
    taken = {part.link for body in model.bodies for part in body.inertias}
    while name in taken:
        name += "_"
    return model.with_payload(**kilogram, frame=frame, name=name)
