"""Bounds that no choice of drives can beat: those of the joints that are still to be chosen
for, whatever masses in a range their drives have, and how much a choice could gain by them.

The torque of a joint is linear in the masses of the drives that it carries. So at each sample it
lies in an interval, of which the number nearest to 0 tells what gears and peaks of motors bear at
least; RMS torques of motors start from those of the lightest drives, and what heavier ones add is
estimated from below. Of choices as of bounds those are kept of which no other is better in
everything: the Pareto front of mass, price and margin.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.design.drive_loads import demand_of
from freebody.design.loads import CycleLoads, RestLoads
from freebody.design.pairs import (
    CONTINUOUS,
    PEAK,
    Demand,
    PairTable,
    continuous_use,
    ratio,
    uses,
)
from freebody.trees.position_rates import Index


def front(mass: Array, price: Array, margin: Array) -> Index:
    """Indices of those (k,) of which no other is at most as heavy, at most as dear and at least as
    safe, and better in one; of equal ones the first. Light ones first."""
    if len(margin) and (margin == margin[0]).all():
        return _stairs(mass, price)
    found: list[int] = []
    stairs: list[tuple[float, float]] = []
    # the safest first: what is found later is kept only where it is lighter or cheaper
    for k in np.lexsort((price, mass, -margin)):
        entry = float(mass[k]), float(price[k])
        at = bisect_right(stairs, (entry[0], np.inf))
        if at and stairs[at - 1][1] <= entry[1]:
            continue
        found.append(int(k))
        while at < len(stairs) and stairs[at][1] >= entry[1]:
            del stairs[at]
        insort(stairs, entry)
    chosen = np.array(found, dtype=np.intp)
    return chosen[np.lexsort((-margin[chosen], price[chosen], mass[chosen]))]


def _stairs(mass: Array, price: Array) -> Index:
    """The front of those that are equally safe."""
    order = np.lexsort((price, mass))
    cheapest = np.minimum.accumulate(price[order])
    return order[np.append(True, cheapest[1:] < cheapest[:-1])]


_MOST = 64
"""Points of a bound; more are joined to fewer, which are better than them."""
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Points:
    """Masses, prices and margins, each (k,), of choices or of what bounds them."""

    mass: Array
    price: Array
    margin: Array

    @staticmethod
    def nothing() -> Points:
        """The one point of no drive at all."""
        return Points(np.zeros(1), np.zeros(1), np.full(1, np.inf))

    def taken(self, at: Index) -> Points:
        """Some of the points."""
        return Points(self.mass[at], self.price[at], self.margin[at])

    def best(self) -> Points:
        """The points of which no other is better in everything."""
        return self.taken(front(self.mass, self.price, self.margin))

    def with_each(self, other: Points) -> Points:
        """Each of these points together with each of others, arrays (k, others)."""
        return Points(
            self.mass[:, None] + other.mass,
            self.price[:, None] + other.price,
            np.minimum(self.margin[:, None], other.margin),
        )

    def and_each(self, other: Points) -> Points:
        """The best of these points together with others, at most `_MOST` that bound them."""
        both = self.with_each(other)
        best = Points(both.mass.ravel(), both.price.ravel(), both.margin.ravel()).best()
        starts = np.unique(np.linspace(0, len(best.mass), _MOST + 1).astype(int)[:-1])
        return Points(
            np.minimum.reduceat(best.mass, starts),
            np.minimum.reduceat(best.price, starts),
            np.maximum.reduceat(best.margin, starts),
        )


@dataclass(frozen=True, eq=False)
class MassRange:
    """Masses of the drives of all joints, kg: at least and at most, (n,) each."""

    least: Array
    most: Array

    def added(self, loads: CycleLoads, k: int) -> list[Array]:
        """The torques that the whole range of each drive adds that joint k carries, (T,) each."""
        width = self.most - self.least
        carried = np.flatnonzero(width * loads.burdens[:, k])
        return [width[j] * loads.per_kg[k, j] for j in carried]


def least_uses(
    loads: CycleLoads,
    rest: RestLoads | None,
    k: int,
    pairs: PairTable,
    life: float,
    masses: MassRange,
    known: tuple[Index, Array],
) -> Array:
    """The share (M, G) of its limits that each pair of joint k uses at least, whatever drives in a
    range of masses the joint carries; known: samples (p,) at which peak torques are looked at, and
    what is allowed there."""
    load = demand_of(loads, k, masses.least, life, rest)
    added = masses.added(loads, k)
    low = load.torque + sum((np.minimum(x, 0.0) for x in added), 0.0 * load.torque)
    high = load.torque + sum((np.maximum(x, 0.0) for x in added), 0.0 * load.torque)
    nearest = replace(
        load,
        torque=np.clip(0.0, low, high),
        holding=0.0 if rest is None else rest.least_holding(k, masses.least, masses.most),
    )
    known_shares = {
        PEAK: _least_peak(load, (low, nearest.torque, high), pairs, *known),
        CONTINUOUS: continuous_use(load, pairs, _least_squares(load, added, pairs)),
    }
    return uses(nearest, pairs, known_shares).max(axis=0)


def _least_peak(
    load: Demand, torques: Sequence[Array], pairs: PairTable, at: Index, allowed: Array
) -> Array:
    """The share (M, G) of the peak torque that is used at least where the torque is between the
    first and the last of three, between which the second is the one nearest to 0, at which the
    losses of a gear change."""
    through = [pairs.through_gears(replace(load, torque=x), at) for x in torques]
    rotors = pairs.of_rotors(load, at)
    low, high = (x[:, None, :] + rotors for x in (np.minimum.reduce(through),
                                                  np.maximum.reduce(through)))  # fmt: skip
    distance = np.maximum(np.maximum(low, -high), 0.0)
    return ratio(distance, allowed).max(axis=0, initial=0.0)


def _least_squares(load: Demand, added: Sequence[Array], pairs: PairTable) -> Array:
    """Mean squares (C, M, G) of motors' torques that no part of what is added makes smaller.

    A motor feels of an added torque a share between those of its gear while it drives, while it is
    driven, and at rest: a ± c. So what it adds to the mean square is, by Cauchy's inequality, at
    least 2/N (a m - c R r), with the mean m of its product with the motor's torque and their RMS
    values r and R; its own square, which is positive, left out.
    """
    squares = pairs.mean_squares(load)
    shares = np.stack([1.0 / pairs.forward, pairs.back, np.ones_like(pairs.back)])
    a, c = (shares.max(axis=0) + shares.min(axis=0)) / 2.0, np.ptp(shares, axis=0) / 2.0
    root, found = np.sqrt(squares), squares
    for torque in added:
        size = np.sqrt(load.shares @ torque**2)[:, None, None]
        change = a * pairs.mean_products(load, torque) - c * root * size
        found = found + np.minimum(2.0 * change / pairs.factor, 0.0)
    return np.maximum(found, 0.0)


def gain(choices: Points, ahead: Points, known: Points) -> Array:
    """The factors less 1, (k,), by which the known points have to be improved, in the one of mass,
    price and margin where it takes most, to be as good as whatever becomes of choices with the
    points ahead: 0 where they are already."""
    found = choices.with_each(ahead)
    needed = np.full(found.mass.shape, np.inf)
    for mass, price, margin in zip(known.mass, known.price, known.margin, strict=True):
        times = np.maximum(_times(mass, found.mass), _times(price, found.price))
        np.minimum(needed, np.maximum(times, _times(found.margin, margin)), out=needed)
    most = needed.max(axis=1) - 1.0
    return np.where(most <= 4.0 * _ROUNDING, 0.0, most)


def _times(one: Array | float, other: Array | float) -> Array:
    """How many times one is larger than another, at least 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.less_equal(one, other), 1.0, np.divide(one, other))
