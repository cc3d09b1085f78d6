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
Friction that is neither constant nor proportional to the rate is evaluated at each pace, and the
pace then found by a search in small steps, between which a limit that is exceeded and kept again is
not seen. Speeds are looked at between the samples of the motion too, torques at them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import CLOSE, Ranges, angular, with_drive
from freebody.motion.smooth_friction import (
    ChangingFriction,
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
    reached.
    """

    factor: float
    coordinate: str
    """The one that reaches its limit at the factor, or cannot be slowed into it; empty without
    one."""
    quantity: str
    """speed, torque or force: what then is at the limit."""
    time: float
    """Time in the motion as it is given at which that is so (s)."""
    held: Array
    """(nv,) the largest |c| over the torque limit: what slowing down does not take away; NaN
    without a limit."""
    held_time: Array
    """Times (nv,) at which a limit holds each coordinate back, s."""


def pace(model: Model, motion: Motion, data: MotionTorques, velocity: Array, effort: Array) -> Pace:
    """The pace at which a motion with `torque_parts` may be run under limits (nv,), infinite where
    there are none."""
    peaks = motion.peaks.velocity
    fast = peaks.size
    with np.errstate(divide="ignore"):
        each = np.where(fast > 0, velocity * (1 + CLOSE) / fast, np.inf)
    quickest = float(each.min(initial=np.inf))
    limited = np.isfinite(effort)
    bound = np.where(limited, effort * (1 + CLOSE), 0.0)
    torque_at = _torque_at(model, data)
    if ChangingFriction(model, _array(data, "q"), _array(data, "qd")).acts:
        factor = _searched(
            lambda k: bool((np.abs(torque_at(k))[:, limited] <= bound[limited]).all()), quickest
        )
    else:
        ends = [
            _broken([x[:, limited] for x in torque], bound[limited], [x[:, limited] for x in sent])
            for torque, sent in _ways(model, data)
        ]
        low, high = (np.concatenate(side) for side in zip(*ends, strict=True))
        factor = _within(low, high, quickest)
    held, held_time = _used(torque_at(0.0), effort, _array(data, "time"))
    if not np.isfinite(factor):
        return Pace(factor, "", "", np.nan, held, held_time)
    share, time = _used(torque_at(factor), effort, _array(data, "time"))
    j = int(np.argmax(np.nan_to_num(share)))
    what, when = "torque" if angular(model)[j] else "force", float(time[j])
    if factor > 0.0:
        speed = factor / each
        i = int(np.argmax(speed))
        if speed[i] >= np.nan_to_num(share[j]):
            j, what, when = i, "speed", float(peaks.size_at[i])
    return Pace(factor, model.velocity_names[j], what, when, held, held_time)


def _used(torque: Array, effort: Array, t: Array) -> tuple[Array, Array]:
    """(the largest share (nv,) of limits that torques (T, nv) use, NaN without a limit; when)."""
    limited = np.isfinite(effort)
    share = np.where(limited, np.abs(torque) / np.where(limited, effort, 1.0), np.nan)
    k = np.argmax(np.nan_to_num(share), axis=0)
    return np.take_along_axis(share, k[None], axis=0)[0], t[k]


def _array(data: MotionTorques, name: str) -> Array:
    return np.asarray(data[name])


def _torque_at(model: Model, data: MotionTorques) -> Callable[[float], Array]:
    """k -> the torques (T, nv) at a pace; at 0 those of slow motion."""
    (a, b, c), sent = parts(model, data), _transmitted(model, data)
    q, qd = _array(data, "q"), _array(data, "qd")
    changing = ChangingFriction(model, q, qd)
    constant = c - changing.at_pace(1.0)

    def torque(k: float) -> Array:
        square, linear, held = sent
        lost = lost_torque(model, qd, (square * k + linear) * k + held)
        return (a * k + b) * k + constant + changing.at_pace(k) + lost

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


def effort_limits(model: Model, allowed: Ranges) -> np.ndarray:
    """Limits of torque (nv,), infinite for coordinates that nothing drives."""
    return np.where(with_drive(model), allowed.effort, np.inf)


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


def _searched(keeps: Callable[[float], bool], quickest: float) -> float:
    """The pace as of `_within`, by steps: `keeps` tells whether a pace is within all limits of
    torque."""
    start = min(1.0, quickest)
    if start == 1.0 and keeps(start):
        good = start
        while good < quickest:
            k = min(good * _STEP, quickest)
            if not keeps(k):
                return _edge(keeps, good, k)
            if k > _FASTEST:
                return np.inf
            good = k
        return quickest
    if keeps(start):
        return start
    bad = start
    while bad > 1.0 / _FASTEST:
        if keeps(bad / _STEP):
            return _edge(keeps, bad / _STEP, bad)
        bad /= _STEP
    return 0.0


_STEP = 1.005
_FASTEST = 1e4
"""A pace beyond which no motion is looked at; its inverse is one below which none is."""


def _edge(keeps: Callable[[float], bool], good: float, bad: float) -> float:
    """The largest pace found that is within all limits, between one that is and one that is not."""
    while bad - good > 1e-9 * good:
        k = 0.5 * (good + bad)
        good, bad = (k, bad) if keeps(k) else (good, k)
    return good


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
