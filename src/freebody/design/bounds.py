"""Bounds that no choice of drives can beat: those of the joints that are still to be chosen
for, whatever masses their drives have, and how much a choice could gain by them.

Every share that is used of a limit is a norm of what the motor or the gear gives, and the masses
of drives change it at most as much as the torques that they add would use by themselves. So the
shares at the middle of a range of masses, less those of what half the range adds, are too small
for no masses in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.design.drive_loads import demand_of
from freebody.design.front import front
from freebody.design.loads import CycleLoads, RestLoads
from freebody.design.pairs import Demand, PairTable, uses
from freebody.motion.ranges import Flags
from freebody.trees.position_rates import Index

_MOST = 32
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


def best_margins(
    loads: CycleLoads,
    rest: RestLoads | None,
    k: int,
    pairs: PairTable,
    life: float,
    least: Array,
    most: Array,
    known: tuple[Index, Array],
) -> Array:
    """Margins (M, G) that no pair of joint k exceeds, where drives have masses between `least` and
    `most` (n,); known: samples (p,) at which peak torques are looked at, and what is allowed."""
    at, allowed = known
    middle, half = (least + most) / 2.0, (most - least) / 2.0
    load = demand_of(loads, k, middle, life, rest)
    added = replace(
        load,
        torque=half @ np.abs(loads.per_kg[k]),
        friction=0.0 * load.friction,
        speed=np.abs(load.speed),
        acceleration=0.0 * load.acceleration,
        holding=0.0 if rest is None else float((half @ np.abs(rest.per_kg[k])).max()),
    )
    none = replace(added, torque=0.0 * load.torque, holding=0.0)

    def shares(demand: Demand) -> Array:
        return uses(demand, pairs, pairs.peak_use(demand, at, allowed))

    with np.errstate(invalid="ignore"):
        # limits of speeds, which no mass changes, are also those of no torque
        least_use = shares(load) - (shares(added) - shares(none))
    found = np.where(np.isnan(least_use), np.inf, least_use).max(axis=0)
    return (1.0 + _ROUNDING) / np.maximum(found, 1e-300)


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


def ranges(pairs: Sequence[PairTable], good: Sequence[Flags]) -> tuple[Array, Array]:
    """The least and the largest mass (n,) of the pairs of each joint that may suffice."""
    masses = [table.mass[at] for table, at in zip(pairs, good, strict=True)]
    return np.array([x.min() for x in masses]), np.array([x.max() for x in masses])
