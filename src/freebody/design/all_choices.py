"""All choices of drives that are better than known ones in something, from the tip to the base.

Of partial choices those are left that, by bounds of what the joints behind can add, may become
better than what is known; of those whose drives load the joints behind alike, only the best. Where
they are too many, those go that could gain least, and it is told how much that is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from freebody.arrays import Array
from freebody.design.bounds import MassRange, Points, front, gain
from freebody.design.choices import PartialChoice, nothing
from freebody.design.pair_margins import PairMargins
from freebody.motion.ranges import Flags
from freebody.trees.position_rates import Index

_WORK = 1_000_000
"""Numbers that are computed for all partial choices that a joint is added to, over all joints."""
_FEW = 32
"""Partial choices, fewer than which are not worth their time."""
_ROUNDS = 2
"""How often the pairs that may suffice narrow the masses by which they are found."""


class BetterChoices:
    """The choices of at least a margin that are better in something than known ones."""

    def __init__(self, pairs: PairMargins, order: Sequence[int], margin: float):
        self.pairs, self.order, self.margin = pairs, order, margin
        self.tolerance = np.inf
        """The factor less 1 by which known choices and those found may have to be improved to be as
        good as every other."""
        numbers = len(pairs.loads.speed) + 4 * max(x.mass.size for x in pairs.pairs)
        self.width = max(1, _WORK // (numbers * len(order)))

    def found(self, known: Points, say: Callable[[str, float], None]) -> list[PartialChoice]:
        """The better choices, their margins at most too large."""
        ahead = self._bounds()
        whole = float(gain(Points.nothing(), ahead[0], known)[0])
        if self.width < _FEW or whole == 0.0:
            self.tolerance = whole
            return []
        self.tolerance = 0.0
        found = [nothing(len(self.order))]
        for done, k in enumerate(self.order):
            say(f"front at {self.pairs.loads.joints[k].name}", done / len(self.order))
            found = self._worth(done, found, ahead[done + 1], known)
        self.tolerance = min(self.tolerance, whole)
        return found

    def _worth(
        self, done: int, partials: Sequence[PartialChoice], ahead: Points, known: Points
    ) -> list[PartialChoice]:
        """The ways to go on at a joint, as many as there is time for: those that may gain most."""
        if not partials:
            return []
        k, pairs = self.order[done], self.pairs
        mass, price = pairs.pairs[k].mass.ravel(), pairs.price[k].ravel()
        margins = [pairs.margins(k, partial.masses) for partial in partials]
        ways = [np.flatnonzero(x >= self.margin) for x in margins]
        at = np.repeat(np.arange(len(partials)), [len(x) for x in ways])
        pair = np.concatenate(ways)
        own = np.concatenate([x.ravel()[j] for x, j in zip(margins, ways, strict=True)])
        before = [np.array([getattr(x, aim) for x in partials])[at]
                  for aim in ("mass", "price", "margin")]  # fmt: skip
        reached = Points(
            before[0] + mass[pair], before[1] + price[pair], np.minimum(before[2], own)
        )
        masses = np.array([partial.masses for partial in partials])[at]
        masses[:, k] = mass[pair]
        left = self._best_alike(done, reached, masses)
        gains = gain(reached.taken(left), ahead, known)
        order = np.argsort(-gains, kind="stable")
        order = order[gains[order] > 0.0]
        if len(order) > self.width:
            self.tolerance = max(self.tolerance, float(gains[order[self.width]]))
        return [
            pairs.extended(
                partials[at[i]], k, np.unravel_index(pair[i], pairs.pairs[k].shape), margins[at[i]]
            )
            for i in map(int, left[order[: self.width]])
        ]

    def _best_alike(self, done: int, reached: Points, masses: Array) -> Index:
        """The partial choices, with drives of masses (k, n), of which no other that loads the
        joints behind alike is better in everything."""
        behind = list(self.order[done + 1 :])
        loading = self.pairs.loads.burdens[:, behind].any(axis=1)
        _, group = np.unique(masses[:, loading], axis=0, return_inverse=True)
        found = []
        for members in np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))):
            best = reached.taken(members)
            found.append(members[front(best.mass, best.price, best.margin)])
        return np.sort(np.concatenate(found))

    def _bounds(self) -> list[Points]:
        """Bounds of the drives of the joints still to be chosen for, from all to none."""
        pairs = self.pairs
        good: list[Flags] = [table.fits for table in pairs.pairs]
        margins: list[Array] = []
        for _ in range(_ROUNDS):
            own = [table.mass[at] for table, at in zip(pairs.pairs, good, strict=True)]
            masses = MassRange(*(np.array([f(x) for x in own]) for f in (np.min, np.max)))
            margins = [pairs.best_margins(k, masses, at) for k, at in enumerate(good)]
            good = [margin >= self.margin for margin in margins]
        found = [Points.nothing()]
        for k in reversed(self.order):
            at = good[k]
            one = Points(pairs.pairs[k].mass[at], pairs.price[k][at], margins[k][at])
            found.append(found[-1].and_each(one.best()))
        return found[::-1]
