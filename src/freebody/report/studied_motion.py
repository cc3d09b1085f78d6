"""The motion that is studied: the given one, or a default one at a pace within the limits; smoothed
if it is measured and that is wished, and sampled at the peaks of loads too."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics, joint_wrenches
from freebody.arrays import Array
from freebody.capacity.time_scaling import at_pace, motion_pace
from freebody.capacity.torque_parts import torque_parts
from freebody.design.joint_loads import joint_loads
from freebody.errors import KindError
from freebody.model.model import Model
from freebody.model.shafts import untwisted
from freebody.motion.carried_twists import (
    SMOOTH,
    carried,
    links_alone,
    tells_links_alone,
    with_carried_twists,
)
from freebody.motion.default_motion import DURATION, SAMPLES, default_motion, swing
from freebody.motion.files.contradictions import GivenRates
from freebody.motion.files.csv_files import read_motion
from freebody.motion.files.measured_motions import recognised, smoothed
from freebody.motion.files.motion_tables import MotionTable, motion_from_table
from freebody.motion.motion import Motion, require_motion
from freebody.motion.ranges import Flags, angular, ranges, with_drive
from freebody.outputs.number_text import percent
from freebody.trees.position_rates import Index

Smooth = bool | float | None
"""False or None: as it is; True: at the cutoff that the noise asks for; a number: at that cutoff
(Hz)."""

_SLOWEST = 0.05
"""Pace; a default motion that must be slower yet hardly moves, and is studied as it is."""
_CLEARANCE = 0.95  # of the pace at which a limit is reached
_COARSE = 1e-9
"""Share of the time between samples by which neighbouring numbers may be apart there."""
_TOLD = 1e-4  # of the largest at the samples: what is higher between them is worth a sample
_EDGE = 1e-4  # of an interval: how far from its ends a jump is not felt
_TRIED = 3  # intervals for each quantity
_ROUNDS, _FAN = 6, 9
_BLOCK = 4096  # intervals at once
_TELL = 0.01  # of the largest peak: a change by less is not told
_MOST = 3  # joints, those whose peaks change most
_UNLIKELY = 0.05  # of the largest acceleration


def studied(
    model: Model,
    motion: Motion | MotionTable | str | os.PathLike[str] | None,
    smooth: Smooth,
    speed: float,
    wrenches: Mapping[str, Array],
) -> tuple[Motion, tuple[str, ...]]:
    """(the motion that `study` looks at, before samples are added at its peaks; sentences on its
    noise). Shafts of flexible joints twist by what they carry where nobody tells of their twists.
    """
    told = given(model, motion, wrenches)
    alone = motion is not None and tells_links_alone(model, told)
    found, measured = filtered(model, told, smooth, wrenches)
    found = at_speed(model, found, speed, wrenches, by_default=motion is None)
    if alone:
        noisy = bool(measured) and not smooth
        found = carried(model, found, wrenches, noisy)
    return found, measured


def given(
    model: Model,
    motion: Motion | MotionTable | str | os.PathLike[str] | None,
    wrenches: Mapping[str, Array] | None = None,
) -> Motion:
    """The motion that `study` was given, or the default one, at a pace that
    wrenches on the robot allow."""
    if motion is None:
        return _by_default(model, wrenches)
    return _from_zero(_found(model, motion))


def _by_default(model: Model, wrenches: Mapping[str, Array] | None) -> Motion:
    """The default motion at a pace that limits and wrenches allow; shafts of flexible joints twist
    by what they carry at that pace."""
    rigid = None if model.loops else untwisted(model)
    if rigid is None:
        return _unhurried(model, default_motion(model), wrenches)
    links = swing(rigid.model, np.linspace(0.0, DURATION, SAMPLES), SMOOTH)
    return with_carried_twists(model, rigid, _unhurried(rigid.model, links, wrenches), wrenches)


def at_speed(
    model: Model,
    motion: Motion,
    speed: float,
    wrenches: Mapping[str, Array] | None,
    by_default: bool,
) -> Motion:
    """A motion run `speed` times as fast; by_default: whether nobody has told it, so that shafts of
    flexible joints twist by what they carry at that speed."""
    if speed == 1.0:
        return motion
    rigid = None if model.loops or not by_default else untwisted(model)
    if rigid is None:
        return motion.faster(speed)
    links = links_alone(rigid, motion).faster(speed)
    return with_carried_twists(model, rigid, links, wrenches)


def _found(model: Model, motion: Motion | MotionTable | str | os.PathLike[str]) -> Motion:
    if isinstance(motion, Motion):
        return require_motion("study", model, motion)
    if isinstance(motion, str | os.PathLike):
        return read_motion(model, motion)
    if not hasattr(motion, "items"):
        raise KindError(
            "study",
            "motion",
            motion,
            "a Motion, a CSV file or a table by names",
            "From arrays t (T,) and q (T, nq): fb.Motion.of(model, t, q).",
        )
    return motion_from_table(model, motion)


def _from_zero(motion: Motion) -> Motion:
    """The motion with times counted from its first, where they are so large (as of a computer's
    clock) that floats hardly separate two samples."""
    start = motion.t[0]
    if np.spacing(np.abs(motion.t).max()) <= _COARSE * np.diff(motion.t).min():
        return motion
    pieces = motion.pieces
    said = (
        f"Times are counted from the first, {float(start)!r} s, at which numbers of 64 bits are "
        f"{np.spacing(start):.2g} s apart."
    )
    return replace(
        motion,
        t=motion.t - start,
        pieces=None if pieces is None else replace(pieces, breaks=pieces.breaks - start),
        notices=(*motion.notices, said),
    )


def _unhurried(model: Model, motion: Motion, wrenches: Mapping[str, Array] | None) -> Motion:
    """The default motion, slowed down where that brings it within limits of speed and torque."""
    factor = motion_pace(model, motion, torque_parts(model, motion, wrenches), wrenches).factor
    if factor >= 1.0 or factor < _SLOWEST:
        return motion
    factor *= _CLEARANCE
    words = f", slowed to {motion.duration / factor:.3g} s to keep the limits of speed and torque"
    return at_pace(motion, factor, words)


def filtered(
    model: Model, motion: Motion, smooth: Smooth, wrenches: Mapping[str, Array] | None = None
) -> tuple[Motion, tuple[str, ...]]:
    """(the motion to study, sentences on its noise and on the torques with and without it)."""
    if smooth is not None and smooth is not False:
        clean = smoothed(model, motion, None if smooth is True else smooth)
        peaks = _compared(model, clean, motion, "as it was measured", wrenches)
        return clean, (
            f"The motion was smoothed. {peaks or 'Peak torques are the same within 1 %.'}",
        )
    found = recognised(model, motion)
    if found is None:
        return motion, ()
    clean = smoothed(model, motion, found.cutoff)
    how = f"smoothed at {found.cutoff:.3g} Hz (--smooth auto, smooth=True)"
    peaks = _compared(model, motion, clean, how, wrenches)
    return motion, (f"{found.text} {peaks}",) if peaks else ()


def _compared(
    model: Model,
    studied: Motion,
    other: Motion,
    how: str,
    wrenches: Mapping[str, Array] | None,
) -> str:
    """A sentence on the peak torques of both motions where they differ, the most changed first;
    empty where none does."""
    peaks = (with_peaks(model, motion, wrenches) for motion in (studied, other))
    mine, theirs = (np.abs(torque_parts(model, m, wrenches)["tau"]).max(axis=0) for m in peaks)
    turns = angular(model)
    driven, largest = with_drive(model), np.maximum(mine, theirs)
    scale = np.array([largest[driven & (turns == kind)].max(initial=1e-300) for kind in turns])
    change = np.where(driven, np.abs(theirs - mine) / scale, 0.0)
    order = [int(k) for k in np.argsort(-change) if change[k] > _TELL]
    if not order:
        return ""
    told = [_peaks(model, k, mine, theirs) for k in order[:_MOST]]
    return f"Peak torques, and in brackets {how}: {'; '.join(told)}."


def _peaks(model: Model, k: int, mine: Array, theirs: Array) -> str:
    allowed = ranges(model)
    unit = "N m" if allowed.turns[k] else "N"
    limit = float(allowed.effort[k])

    def one(value: float) -> str:
        share = f", {percent(value / limit)} of its limit" if np.isfinite(limit) else ""
        return f"{value:.3g} {unit}{share}"

    return f"{model.velocity_names[k]} {one(float(mine[k]))} [{one(float(theirs[k]))}]"


def with_peaks(model: Model, motion: Motion, wrenches: Mapping[str, Array] | None = None) -> Motion:
    """The motion with further samples where a torque, power or reaction between samples is larger
    than at all of them by a ten-thousandth, or above its limit.

    Of a closed chain as it is: between samples its positions are not closed. Intervals in which the
    curve is faster accelerated than its samples explain, as between noisy ones, do not count.
    """
    if model.loops:
        return motion
    loads = _Loads(model, motion, wrenches)
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
    """The loads on drives and joints along a motion, as K magnitudes."""

    model: Model
    motion: Motion
    wrenches: Mapping[str, Array] | None

    def at(self, t: Array, around: Array) -> Array:
        """The loads (..., K) at times t (...), on the side of a jump where the times `around`
        are."""
        return self._of(*self.motion.at(t, around))

    def _of(self, q: Array, qd: Array, qdd: Array) -> Array:
        model, shape = self.model, q.shape[:-1]
        q, qd, qdd = (x.reshape(-1, x.shape[-1]) for x in (q, qd, qdd))
        tau = inverse_dynamics(model, q, qd, qdd, self.wrenches)
        power = np.where(with_drive(model), tau * qd, 0.0)
        carried = joint_wrenches(model, q, qd, qdd, self.wrenches, "child")
        force, moment = carried[..., : model.dim], carried[..., model.dim :]
        bearings = joint_loads(model, force, moment).values()
        found = [tau, power, power.sum(axis=-1, keepdims=True)]
        found += [np.linalg.norm(x, axis=-1) for x in (force, moment)]
        found += [np.nan_to_num(x) for x in bearings]
        return np.abs(np.concatenate(found, axis=-1)).reshape(*shape, -1)

    def limits(self, count: int) -> Array:
        """The limits (K,) of the loads, infinite where there is none."""
        allowed, nv = ranges(self.model), self.model.nv
        found = np.full(count, np.inf)
        found[:nv] = np.where(with_drive(self.model), allowed.effort, np.inf)
        found[nv : 2 * nv] = found[:nv] * allowed.velocity
        return found

    def higher(self) -> Iterator[float]:
        """The times of peaks of loads that lie above all samples."""
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
        """The largest loads (intervals, K) at three places in each interval of the knots."""
        knots = self.motion.knots
        start, step = knots[:-1, None], np.diff(knots)[:, None]
        times = start + step * np.array([_EDGE, 0.5, 1.0 - _EDGE])
        around = np.broadcast_to(start + 0.5 * step, times.shape)
        parts = np.array_split(np.arange(len(times)), -(-len(times) // _BLOCK))
        return np.concatenate([self.at(times[k], around[k]).max(axis=1) for k in parts])

    def _climbed(self, interval: Index, column: Index) -> tuple[Array, Array]:
        """(largest values (C,), their times) of given loads in given intervals of the knots."""
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
        """Flags (intervals,) of the intervals between knots in which the acceleration is plausible
        from its ends: looked at a quarter and three quarters of the way, since errors of positions
        do not show halfway."""
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
