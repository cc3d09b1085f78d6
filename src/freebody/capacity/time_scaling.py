"""The pace at which a motion may be run: its torques and speeds under uniform scaling of time,
exactly.

Run k times as fast, the same path has rates k q̇ and accelerations k² q̈, and each torque is

    τ(k) = a k² + b k + c,   a = M q̈ + C q̇ + rotors,   b = viscous friction,
                             c = gravity + springs + wrenches + dry friction,

a, b, c being the parts at k = 1 (Hollerbach 1984, "Dynamic scaling of manipulator trajectories",
with friction added). Of closed chains too: what the drives feel of each part depends on the
position alone. What gears lose is a part of the torque t(k) = (M q̈ + C q̇) k² + gravity + springs
that they transmit, one where its power flows to the joint, another where it flows back, so that τ
is one of two such polynomials, by the sign of t(k). Friction at rest (k = 0) is not asked about.
Friction that is neither constant nor proportional to the rate is evaluated over intervals of the
pace: up to the pace then found no limit is exceeded anywhere, be it between paces that keep all.
Speeds are looked at between the samples of the motion too, torques at them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress, product
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.any_chain.effort_limits import Followers, effort_limits, followers
from freebody.arrays import Array
from freebody.capacity.limited_loads import LimitedLoads, constant, efforts_named
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.intervals import for_each
from freebody.motion.motion import Motion
from freebody.motion.ranges import CLOSE, Flags, angular, ranges
from freebody.motion.smooth_friction import (
    ChangingFriction,
    friction_torque,
    lost_parts,
    lost_torque,
    motor_springs,
    viscous_torque,
)

MotionTorques = Mapping[Any, Any]
"""Times, states and parts of torques by name, as `torque_parts` gives them; or a study's data."""


@dataclass(frozen=True)
class Pace:
    """The factor on a motion's speed at which it reaches its first limit, of those that depend on
    speed.

    Above 1 it may be sped up so far, and at every speed between; below 1 it must be slowed down,
    `factor` being the largest that is within all. 0: no slowing helps. Infinite: no limit is ever
    reached. NaN: it is not known what a load is at other speeds.
    """

    factor: float
    joint: str = ""
    """The coordinate, or joint that follows one, that reaches its limit at the factor, or cannot be
    slowed into it; empty without one."""
    quantity: str = ""
    """The quantity that then is at the limit: speed, torque or force; of a brake brake torque or
    brake force, of a bearing static load or tilting moment."""
    time: float = float("nan")
    """Time in the motion as it is given at which that is so (s)."""
    share: float = float("nan")
    """The share that is then used of the limit."""
    segment: int = 0
    """The segment of a duty cycle, from 1; 0 where there is none."""


def motion_pace(
    model: Model,
    motion: Motion,
    data: MotionTorques,
    wrenches: Mapping[str, Array] | None = None,
    effort: Array | None = None,
    fitted: Sequence[LimitedLoads] = (),
) -> Pace:
    """The pace at which a motion with `torque_parts` may be run under the limits of a model;
    effort: (nv,), others than its own, infinite where there are none; fitted: loads of further
    parts, as of `part_loads`."""
    return pace([limited(model, motion, data, wrenches, effort, fitted=fitted)])


@dataclass(frozen=True, eq=False)
class LimitedMotion:
    """A motion under limits: of speeds, and of loads in groups."""

    names: tuple[str, ...]
    speed: Array
    """(nv,) the pace at which each coordinate alone is at its limit of speed."""
    speed_time: Array
    loads: tuple[LimitedLoads, ...]
    segment: int = 0


def limited(
    model: Model,
    motion: Motion,
    data: MotionTorques,
    wrenches: Mapping[str, Array] | None = None,
    effort: Array | None = None,
    segment: int = 0,
    fitted: Sequence[LimitedLoads] = (),
) -> LimitedMotion:
    """A motion with `torque_parts` under the limits of a model, as `motion_pace` takes them;
    segment: of a duty cycle, from 1."""
    peaks = motion.peaks.velocity
    with np.errstate(divide="ignore"):
        alone = np.where(peaks.size > 0, ranges(model).velocity * (1 + CLOSE) / peaks.size, np.inf)
    torques = [_own_torques(model, data, effort_limits(model) if effort is None else effort)]
    if (following := followers(model)) is not None:
        torques.append(_followers_torques(following, data, wrenches))
    loads = (*torques, *fitted)
    return LimitedMotion(model.velocity_names, alone, peaks.size_at, loads, segment)


@dataclass(frozen=True, eq=False)
class HeldStill:
    """Efforts (K,) that hold a robot still at a posture: of its coordinates, then of followers that
    have limits of their own; and all limits, infinite where there is none."""

    names: tuple[str, ...]
    turns: Flags
    efforts: Array
    limits: Array


def held_still(model: Model, q: Array, wrenches: Mapping[str, Array] | None = None) -> HeldStill:
    """The efforts that hold a robot still at q (nq,), under constant wrenches on it by frame."""
    rest = np.zeros(model.nv)
    names, turns = model.velocity_names, angular(model)
    efforts, limits = inverse_dynamics(model, q, rest, rest, wrenches), effort_limits(model)
    if (following := followers(model)) is not None:
        names = (*names, *following.names)
        turns = np.append(turns, angular(following.freed)[following.columns])
        efforts = np.append(efforts, following.torques(q, rest, rest, wrenches))
        limits = np.append(limits, following.limits)
    return HeldStill(names, turns, efforts, limits)


def resting(
    held: HeldStill, time: float, segment: int, fitted: Sequence[LimitedLoads] = ()
) -> LimitedMotion:
    """A rest at the end of a segment, which is the same at any pace; fitted: loads of further
    parts."""
    some = np.isfinite(held.limits)
    efforts = held.efforts[None, some]
    group = LimitedLoads(
        tuple(compress(held.names, some)),
        *efforts_named(held.turns[some]),
        held.limits[some],
        np.array([time]),
        lambda k: efforts,
        constant(efforts),
    )
    return LimitedMotion((), np.zeros(0), np.zeros(0), (group, *fitted), segment)


def _own_torques(model: Model, data: MotionTorques, effort: Array) -> LimitedLoads:
    some = np.isfinite(effort)
    torque = _torque_at(model, data)
    changing = ChangingFriction(model, _array(data, "q"), _array(data, "qd")).acts
    ways = [
        ([x[:, some] for x in torque], [x[:, some] for x in sent])
        for torque, sent in _ways(model, data)
    ]
    return LimitedLoads(
        tuple(compress(model.velocity_names, some)),
        *efforts_named(angular(model)[some]),
        effort[some],
        _array(data, "time"),
        lambda k: torque(k)[..., some],
        None if changing else ways,
    )


def _followers_torques(
    following: Followers, data: MotionTorques, wrenches: Mapping[str, Array] | None
) -> LimitedLoads:
    """The torques that reach followers. What does not rub is a polynomial of the pace, which three
    of its values tell; a pace of -1 turns the rates round."""
    q, qd, qdd = (_array(data, name) for name in ("q", "qd", "qdd"))
    freed, columns = following.freed.opened, following.columns

    def torque(k: float) -> Array:
        return following.torques(q, k * qd, k**2 * qdd, wrenches)

    def rubbing(k: float) -> Array:
        return friction_torque(freed, *following.states(q, k * qd, qdd)[:2])[:, columns]

    forth, back, still = (torque(k) - rubbing(k) for k in (1.0, -1.0, 0.0))
    own, own_rates, _ = following.states(q, qd, qdd)
    changing = ChangingFriction(freed, own, own_rates)
    viscous = viscous_torque(freed, own, own_rates)[:, columns]
    a, b = 0.5 * (forth + back) - still, 0.5 * (forth - back) + viscous
    c = still + rubbing(1.0) - viscous - changing.at_pace(1.0)[..., columns]
    return LimitedLoads(
        following.names,
        *efforts_named(angular(freed)[columns]),
        following.limits,
        _array(data, "time"),
        lambda k: (a * (pace := for_each(k, 2)) + b) * pace + c + changing.at_pace(k)[..., columns],
        None if changing.acts else [([a, b, c], [0.0 * a, 0.0 * a, 0.0 * a + 1.0])],
    )


def pace(runs: Sequence[LimitedMotion]) -> Pace:
    """The pace at which motions may be run, all at the same."""
    quickest = min(float(run.speed.min(initial=np.inf)) for run in runs)
    loads = [part for run in runs for part in run.loads]
    if not all(part.known for part in loads):
        return Pace(np.nan)
    if all(part.ways is not None for part in loads):
        ends = [_broken(load, part.bound, sent) for part in loads for load, sent in part.ways or ()]
        low, high = (np.concatenate(side) for side in zip(*ends, strict=True))
        factor = _within(low, high, quickest)
    else:
        numbers = max(part.time.size * part.limits.size for part in loads)
        together = int(np.clip(_NUMBERS / max(numbers, 1), *_TOGETHER))

        def keeps(slow: Array, fast: Array) -> Flags:
            return np.logical_and.reduce([part.kept(slow, fast) for part in loads])

        factor = _searched(keeps, quickest, together)
    if not np.isfinite(factor):
        return Pace(factor)
    found = [x for run in runs for x in _used(run, factor)]
    return max(found, key=lambda x: x.share)


def _used(run: LimitedMotion, factor: float) -> Iterator[Pace]:
    """The limits of which a motion uses most at a pace: of speed, and of each group of loads."""
    if factor > 0.0 and len(run.speed):
        j = int(np.argmin(run.speed))
        when, share = float(run.speed_time[j]), factor / float(run.speed[j])
        yield Pace(factor, run.names[j], "speed", when, share, run.segment)
    for part in run.loads:
        share = part.shares(factor)
        if share.size:
            k, j = np.unravel_index(np.argmax(share), share.shape)
            what, when = part.quantities[j], float(part.time[k])
            yield Pace(factor, part.names[j], what, when, float(share[k, j]), run.segment)


def _array(data: MotionTorques, name: str) -> Array:
    return np.asarray(data[name])


def _torque_at(model: Model, data: MotionTorques) -> Callable[[Any], Any]:
    """k -> the torques (T, nv) at a pace, or those that occur at the paces of an interval, (K, T,
    nv) at K of them; at 0 those of slow motion."""
    (a, b, c), sent = parts(model, data), _transmitted(model, data)
    q, qd = _array(data, "q"), _array(data, "qd")
    changing = ChangingFriction(model, q, qd)
    constant = c - changing.at_pace(1.0)

    def torque(k: Any) -> Any:
        (square, linear, held), pace = sent, for_each(k, 2)
        lost = lost_torque(model, qd, (square * pace + linear) * pace + held)
        return (a * pace + b) * pace + constant + changing.at_pace(k) + lost

    return torque


def parts(model: Model, data: MotionTorques) -> tuple[Array, Array, Array]:
    """The parts (a, b, c), arrays (T, nv), of the torques that grow with the square of the pace,
    with the pace, and not at all; without losses of the transmitted torque."""
    get = {name: _array(data, f"tau_{name}") for name in _PARTS}
    square, linear, constant = _transmitted(model, data)
    lost = lost_torque(model, _array(data, "qd"), square + linear + constant)
    friction = get["friction"] - get["viscous"] - lost
    at_motor = motor_springs(model, _array(data, "q"), _array(data, "qd"))
    return square + get["rotors"], get["viscous"], constant + at_motor + friction


_PARTS = ("rotors", "viscous", "friction")


def _transmitted(model: Model, data: MotionTorques) -> tuple[Array, Array, Array]:
    """The parts of the transmitted torque that grow with the square of the pace, with the pace (as
    the damping of struts does), and not at all."""
    get = {name: _array(data, f"tau_{name}") for name in _SENT}
    q, qd = _array(data, "q"), _array(data, "qd")
    dampers = get["viscous"] - viscous_torque(model, q, qd)
    held = get["gravity"] + get["springs"] - motor_springs(model, q, qd)
    if "tau_wrenches" in data:
        held = held + _array(data, "tau_wrenches")
    return get["inertial"] + get["coriolis"], dampers, held


_SENT = ("inertial", "coriolis", "viscous", "gravity", "springs")


def _ways(model: Model, data: MotionTorques) -> Iterator[tuple[list[Array], list[Array]]]:
    """Pairs of coefficients: (a, b, c) of the torque as a polynomial of the pace, and those of a
    polynomial that is positive where the first is valid; with losses two pairs, by the direction of
    power."""
    a, b, c = parts(model, data)
    if not lossy_joints(model.bodies):
        yield [a, b, c], [0.0 * a, 0.0 * b, 0.0 * c + 1.0]
        return
    (square, linear, constant), rate = _transmitted(model, data), _array(data, "qd")
    driving, driven = lost_parts(model)
    sense = np.where(rate < 0.0, -1.0, 1.0)
    for way, lost in ((sense, driving), (-sense, -driven)):
        lost = np.where(rate == 0.0, 0.0, lost)
        yield (
            [a + lost * square, b + lost * linear, c + lost * constant],
            [way * square, way * linear, way * constant],
        )


def at_pace(motion: Motion, factor: float, words: str) -> Motion:
    """The motion on the same path run `factor` times as fast, from the same start; `words` are
    added to its source."""
    return replace(motion.faster(factor), source=f"{motion.source}{words}")


def _broken(torque: Sequence[Array], bound: Array, there: Sequence[Array]) -> tuple[Array, Array]:
    """Open intervals of the pace k > 0, arrays (n,) of their ends, in which |a k² + b k + c|
    exceeds its bound somewhere and the polynomial `there` is positive."""
    a, b, c = torque
    ends: list[tuple[Array, Array]] = []
    for sign in (1.0, -1.0):
        for (low, high), (first, last) in product(
            _positive(sign * a, sign * b, sign * c - bound), _positive(*there)
        ):
            ends.append((np.maximum(low, first), np.minimum(high, last)))
    low, high = (np.concatenate([pair[i].ravel() for pair in ends]) for i in (0, 1))
    low = np.maximum(low, 0.0)
    some = high > low
    return low[some], high[some]


def _positive(a: Array, b: Array, c: Array) -> list[tuple[Array, Array]]:
    """The intervals in which a k² + b k + c > 0, two for each entry; an empty one ends before it
    starts."""
    b, c = np.broadcast_arrays(b, c)
    straight = np.abs(a) <= 1e-14 * (np.abs(b) + np.abs(c))
    with np.errstate(all="ignore"):
        root = np.sqrt(b**2 - 4 * a * c)  # NaN: no root, one sign throughout
        far = -0.5 * (b + np.where(b >= 0, 1.0, -1.0) * root)
        roots = np.sort(np.stack([far / a, np.where(far == 0, 0.0, c / far)]), axis=0)
        single = -c / b
    real = ~np.isnan(root)
    # parabola: outside its roots where it opens upwards, between them where it opens downwards
    up, down = ~straight & (a > 0), ~straight & (a < 0) & real
    rising, falling = straight & (b > 0), straight & (b < 0)
    level = straight & (b == 0) & (c > 0)
    first_low = np.select(
        [up, down, rising, falling, level], [-np.inf, roots[0], single, -np.inf, -np.inf], np.inf
    )
    first_high = np.select(
        [up & real, up, down, rising, falling, level],
        [roots[0], np.inf, roots[1], np.inf, single, np.inf],
        -np.inf,
    )
    second_low = np.where(up & real, roots[1], np.inf)
    second_high = np.where(up & real, np.inf, -np.inf)
    return [(first_low, first_high), (second_low, second_high)]


def _searched(keeps: Callable[[Array, Array], Flags], quickest: float, together: int) -> float:
    """The pace as of `_within`; keeps: whether all paces from one to another are surely within all
    limits of torque, asked of `together` pairs of paces at a time."""
    start = min(1.0, quickest)
    if keeps(np.array([start]), np.array([start]))[0]:
        return start if start < 1.0 else _reached(keeps, quickest, together)
    bad = start
    while bad > 1.0 / _FASTEST:
        slower = bad / _STEP ** np.arange(1.0, together + 1)
        kept = keeps(slower, slower)
        if kept.any():
            first = int(np.argmax(kept))
            return _edge(keeps, slower[first], slower[first - 1] if first else bad, together)
        bad = float(slower[-1])
    return 0.0


def _reached(keeps: Callable[[Array, Array], Flags], quickest: float, together: int) -> float:
    """The pace up to which all from 1 are surely within the limits. A piece of which that cannot be
    told is cut into smaller ones; where they become very short, a limit is reached."""
    last = min(quickest, _FASTEST)
    ends = np.geomspace(1.0, last, together + 1)
    left = [(ends, keeps(ends[:-1], ends[1:]))]  # pieces of which it is known; the slowest last
    while left:
        ends, kept = left.pop()
        if kept.all():
            continue
        first = int(np.argmin(kept))
        slow, fast = ends[first], ends[first + 1]
        if fast - slow <= _FINEST * slow:
            return float(slow)
        left.append((ends[first + 1 :], kept[first + 1 :]))
        pieces = np.linspace(slow, fast, together + 1)
        left.append((pieces, keeps(pieces[:-1], pieces[1:])))
    return float(last)


_STEP = 1.005
_FINEST = 1e-10
_FASTEST = 1e4
"""A pace beyond which no motion is looked at; its inverse is one below which none is."""

_TOGETHER = (4, 64)
"""Pieces at a time, at least and at most: the fewer calls, the more work for nothing."""

_NUMBERS = 2e5
"""Torques that are computed at a time; they stay in the processor's caches."""


def _edge(keeps: Callable[[Array, Array], Flags], good: float, bad: float, together: int) -> float:
    """The largest pace found that is within all limits, between one that is and one that is not."""
    while bad - good > 1e-9 * good:
        between = np.linspace(good, bad, together + 2)[1:-1]
        kept = keeps(between, between)
        last = int(np.max(np.flatnonzero(kept), initial=-1))
        good, bad = (
            between[last] if last >= 0 else good,
            between[last + 1] if last + 1 < together else bad,
        )
    return float(good)


def _within(low: Array, high: Array, quickest: float) -> float:
    """The pace up to which k may rise from 1 without entering an interval or exceeding `quickest`;
    where 1 is in an interval or above `quickest`, the largest k below that is not."""
    order = np.argsort(low)
    low, high = low[order], np.maximum.accumulate(high[order]) if len(high) else high
    inside = bool(np.any((low < 1.0) & (high > 1.0)))
    if not inside and quickest >= 1.0:
        return float(min(quickest, low[low >= 1.0].min(initial=np.inf)))
    # largest k <= 1 (and <= quickest) outside all intervals: go down from interval to interval
    k = min(1.0, quickest)
    for lower, upper in zip(low[::-1], high[::-1], strict=True):
        if lower < k < upper:
            k = float(lower)
    return k
