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

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.intervals import Interval
from freebody.motion.motion import Motion
from freebody.motion.ranges import Ranges, with_drive
from freebody.motion.smooth_friction import (
    ChangingFriction,
    lost_parts,
    lost_torque,
    motor_springs,
    viscous_torque,
)
from freebody.report.results import CLOSE

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Pace:
    """The factor on a motion's speed at which it reaches its first limit, of those that depend on
    speed.

    Above 1 it may be sped up so far, and at every speed between; below 1 it must be slowed down,
    `factor` being the largest that is within all. 0: no slowing helps. Infinite: no limit is ever
    reached.
    """

    factor: float
    held: Array
    """(nv,) the largest |c| over the torque limit: what slowing down does not take away; NaN
    without a limit."""
    held_time: Array
    """Times (nv,) at which a limit holds each coordinate back, s."""


def pace(model: Model, motion: Motion, data: xr.Dataset, velocity: Array, effort: Array) -> Pace:
    """The pace at which a motion with `Study.data` may be run under limits (nv,), infinite where
    there are none."""
    fast = motion.peaks.velocity.size
    with np.errstate(divide="ignore"):
        each = np.where(fast > 0, velocity * (1 + CLOSE) / fast, np.inf)
    quickest = float(each.min(initial=np.inf))
    limited = np.isfinite(effort)
    bound = np.where(limited, effort * (1 + CLOSE), 0.0)
    torque_at = _torque_at(model, data)
    if ChangingFriction(model, data["q"].values, data["qd"].values).acts:

        def keeps(slow: float, fast: float) -> bool:
            sizes = torque_at(Interval(slow, fast)).size
            return bool((sizes[:, limited] <= bound[limited]).all())

        factor = _searched(keeps, quickest)
    else:
        ends = [
            _broken([x[:, limited] for x in torque], bound[limited], [x[:, limited] for x in sent])
            for torque, sent in _ways(model, data)
        ]
        low, high = (np.concatenate(side) for side in zip(*ends, strict=True))
        factor = _within(low, high, quickest)
    c = torque_at(0.0)
    share = np.where(limited, np.abs(c) / np.where(limited, effort, 1.0), np.nan)
    k = np.argmax(np.nan_to_num(share), axis=0)
    t = data["time"].values
    return Pace(factor, np.take_along_axis(share, k[None], axis=0)[0], t[k])


def _torque_at(model: Model, data: xr.Dataset) -> Callable[[Any], Any]:
    """k -> the torques (T, nv) at a pace, or those that occur at the paces of an interval; at 0
    those of slow motion."""
    (a, b, c), sent = parts(model, data), _transmitted(model, data)
    q, qd = data["q"].values, data["qd"].values
    changing = ChangingFriction(model, q, qd)
    constant = c - changing.at_pace(1.0)

    def torque(k: Any) -> Any:
        square, linear, held = sent
        lost = lost_torque(model, qd, (square * k + linear) * k + held)
        return (a * k + b) * k + constant + changing.at_pace(k) + lost

    return torque


def parts(model: Model, data: xr.Dataset) -> tuple[Array, Array, Array]:
    """The parts (a, b, c), arrays (T, nv), of the torques that grow with the square of the pace,
    with the pace, and not at all; without losses of the transmitted torque."""
    get = {name: data[f"tau_{name}"].values for name in _PARTS}
    square, linear, constant = _transmitted(model, data)
    lost = lost_torque(model, data["qd"].values, square + linear + constant)
    friction = get["friction"] - get["viscous"] - lost
    at_motor = motor_springs(model, data["q"].values, data["qd"].values)
    return square + get["rotors"], get["viscous"], constant + at_motor + friction


_PARTS = ("rotors", "viscous", "friction")


def _transmitted(model: Model, data: xr.Dataset) -> tuple[Array, Array, Array]:
    """The parts of the transmitted torque that grow with the square of the pace, with the pace (as
    the damping of struts does), and not at all."""
    get = {name: data[f"tau_{name}"].values for name in _SENT}
    q, qd = data["q"].values, data["qd"].values
    dampers = get["viscous"] - viscous_torque(model, q, qd)
    held = get["gravity"] + get["springs"] - motor_springs(model, q, qd)
    if "tau_wrenches" in data:
        held = held + data["tau_wrenches"].values
    return get["inertial"] + get["coriolis"], dampers, held


_SENT = ("inertial", "coriolis", "viscous", "gravity", "springs")


def _ways(model: Model, data: xr.Dataset) -> Iterator[tuple[list[Array], list[Array]]]:
    """Pairs of coefficients: (a, b, c) of the torque as a polynomial of the pace, and those of a
    polynomial that is positive where the first is valid; with losses two pairs, by the direction of
    power."""
    a, b, c = parts(model, data)
    if not lossy_joints(model.bodies):
        yield [a, b, c], [0.0 * a, 0.0 * b, 0.0 * c + 1.0]
        return
    (square, linear, constant), rate = _transmitted(model, data), data["qd"].values
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


def _searched(keeps: Callable[[float, float], bool], quickest: float) -> float:
    """The pace as of `_within`; keeps: whether all paces from one to another are surely within all
    limits of torque."""
    start = min(1.0, quickest)
    if keeps(start, start):
        return start if start < 1.0 else _reached(keeps, quickest)
    bad = start
    while bad > 1.0 / _FASTEST:
        good = bad / _STEP
        if keeps(good, good):
            return _edge(keeps, good, bad)
        bad = good
    return 0.0


def _reached(keeps: Callable[[float, float], bool], quickest: float) -> float:
    """The pace up to which all from 1 are surely within the limits, in steps as long as that can be
    told of: where they become very short, a limit is reached."""
    good, step = 1.0, _STEP - 1.0
    while good < quickest:
        if good > _FASTEST:
            return good
        k = min(good * (1.0 + step), quickest)
        if keeps(good, k):
            good, step = k, 2.0 * step
        elif step > _FINEST:
            step *= 0.25
        else:
            return good
    return quickest


_STEP = 1.005
_FINEST = 1e-10
_FASTEST = 1e4
"""A pace beyond which no motion is looked at; its inverse is one below which none is."""


def _edge(keeps: Callable[[float, float], bool], good: float, bad: float) -> float:
    """The largest pace found that is within all limits, between one that is and one that is not."""
    while bad - good > 1e-9 * good:
        k = 0.5 * (good + bad)
        good, bad = (k, bad) if keeps(k, k) else (good, k)
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
