"""How near choices of drives are to the best, by levels of their margin; and better ones where they
are not near.

A choice with a margin between two levels has at each joint a pair whose margin is no lower, behind
drives that are at least as heavy as the lightest of theirs that reach the level. The sums of masses
and prices of such pairs are bounds of what any choice can be. Where what is known is furthest from
them, the level is parted in two, from the tip to the base, and the upper one searched.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.design.bounds import MassRange, Points, gain
from freebody.design.choices import PartialChoice, best, nothing, points
from freebody.design.pair_margins import PairMargins
from freebody.design.partial_choices import Aims
from freebody.motion.ranges import Flags

_WORK = 250_000
"""Pairs that are looked at, over all parts."""
_MOST_PARTS = 48
_MIXTURES = (1.0, 0.5, 0.0)
"""Shares of mass, the others of price, that choices at a new level are searched for."""
_NARROW = 1.002
"""Ratio of the ends of a level that is not parted any more."""


@dataclass(frozen=True, eq=False)
class Level:
    """Choices with margins between two: the pairs of each joint that can be in one, and points of
    which none of them is better in mass and price."""

    low: float
    high: float
    good: tuple[Flags, ...]
    points: Points

    def below(self, high: float) -> Level:
        """The part of the level below a margin."""
        highest = np.full(len(self.points.margin), high)
        return replace(self, high=high, points=replace(self.points, margin=highest))

    def gap(self, known: Points) -> float:
        """The factor less 1 by which what is known may have to be improved to be as good as every
        choice of the level."""
        return float(gain(Points.nothing(), self.points, known)[0])


def level(
    pairs: PairMargins, order: Sequence[int], low: float, high: float, good: Sequence[Flags]
) -> Level | None:
    """The level between two margins of choices of some pairs; None where there can be none."""
    count = len(pairs.pairs)
    masses = MassRange(np.zeros(count), np.zeros(count))
    found, bound = list(good), Points.nothing()
    for k in order:
        margins = pairs.best_margins(k, masses, good[k])
        found[k] = margins >= low
        if not found[k].any():
            return None
        high = min(high, float(margins.max()))
        own = pairs.pairs[k].mass[found[k]], pairs.price[k][found[k]]
        masses.least[k], masses.most[k] = own[0].min(), own[0].max()
        bound = bound.and_each(Points(*own, np.zeros(len(own[0]))).best())
    return Level(low, high, tuple(found), bound).below(high)


def refined(
    pairs: PairMargins,
    order: Sequence[int],
    known: list[PartialChoice],
    margin: float,
    enough: float,
    say: Callable[[str, float], None],
) -> tuple[list[PartialChoice], float]:
    """Known choices with better ones, and the factor less 1 by which they may have to be improved
    to be as good as every choice of at least a margin; enough: where no more is needed."""
    whole = level(pairs, order, margin, np.inf, [x.fits for x in pairs.pairs])
    assert whole is not None, "what is known is of this level"
    waiting, parts = [(-np.inf, 0, whole)], 1
    most = min(_MOST_PARTS, max(1, _WORK // max(x.mass.size for x in pairs.pairs)))
    while True:
        _, number, worst = heapq.heappop(waiting)
        gap = worst.gap(points(known))
        if waiting and gap < -waiting[0][0]:  # others are further from what is known now
            heapq.heappush(waiting, (-gap, number, worst))
            continue
        if gap <= enough or parts >= most or worst.high <= _NARROW * worst.low:
            return known, gap
        say("levels of the margin", parts / most)
        middle = float(np.sqrt(worst.low * min(worst.high, 1e3 * worst.low)))
        above = level(pairs, order, middle, worst.high, worst.good)
        for part in (worst.below(middle), above):
            if part is not None:
                parts += 1
                heapq.heappush(waiting, (-gap, parts, part))
        if above is not None:
            known = best([*known, *_searched(pairs, order, above)])


def _searched(pairs: PairMargins, order: Sequence[int], level: Level) -> list[PartialChoice]:
    """Choices of a level, the best from the tip to the base by mixtures of mass and price."""
    found, aims = [nothing(len(pairs.pairs))], Aims(pairs, (level.low,), _MIXTURES, safest=True)
    for k in order:
        found = aims.kept(k, found, level.good[k])
    return found
