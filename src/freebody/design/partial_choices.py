"""The best partial choices from the tip to the base: for each joint, behind those whose drives it
carries, one by each mixture of mass and price with at least each of some margins, and the safest.

Mass alone is one of the mixtures, for which the lightest from the tip is the best.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.arrays import Array
from freebody.design.choices import PartialChoice
from freebody.design.pair_margins import PairMargins
from freebody.motion.ranges import Flags

_TIE = 1e-6
"""Share of the other one where one alone counts."""


class Aims:
    """The aims that partial choices are kept for: levels of their margin, and shares of mass, the
    others of price."""

    def __init__(
        self, pairs: PairMargins, levels: Sequence[float], mixtures: Sequence[float], safest: bool
    ):
        self.pairs, self.levels, self.safest = pairs, levels, safest
        self.mixtures = [min(max(x, _TIE), 1.0 - _TIE) for x in mixtures]

    def kept(
        self, k: int, partials: Sequence[PartialChoice], among: Flags | None = None
    ) -> list[PartialChoice]:
        """The best ways to go on at joint k with some of its pairs, one for each aim, looked at
        everywhere."""
        pairs = self.pairs
        margins = [pairs.margins(k, partial.masses, among).copy() for partial in partials]
        while True:
            found = self._aimed(k, partials, margins)
            known = len(pairs.worst[k])
            true = [pairs.is_true(k, one) for one in found]
            if all(true):
                return found
            pairs.lower(k, known, [partial.masses for partial in partials], margins)

    def _aimed(
        self, k: int, partials: Sequence[PartialChoice], margins: Sequence[Array]
    ) -> list[PartialChoice]:
        """The partial choices with a pair for joint k, the best one for each aim."""
        pairs, price, least = self.pairs.pairs[k], self.pairs.price[k], self.levels[0]
        scales = np.array([_typical(pairs.mass), _typical(price)])
        best: dict[tuple[float, int], tuple[float, PartialChoice, int, Array]] = {}

        def offer(
            aim: tuple[float, int], cost: float, partial: PartialChoice, at: int, x: Array
        ) -> None:
            if aim not in best or cost < best[aim][0]:
                best[aim] = cost, partial, at, x

        for j, share in enumerate(self.mixtures):
            weights = np.array([share, 1.0 - share]) / scales
            cost = (weights[0] * pairs.mass + weights[1] * price).ravel()
            cheap = np.argsort(cost, kind="stable")
            for partial, margin in zip(partials, margins, strict=True):
                reach = np.minimum(margin.ravel()[cheap], partial.margin)
                so_far = float(weights @ (partial.mass, partial.price))
                for level in self.levels:
                    first = int(np.argmax(reach >= level))
                    if reach[first] < level:
                        break
                    at = int(cheap[first])
                    offer((level, j), so_far + float(cost[at]), partial, at, margin)
        for partial, margin in zip(partials, margins, strict=True) if self.safest else ():
            at = int(margin.argmax())
            safest = min(float(margin.flat[at]), partial.margin)
            if safest >= least:
                offer((np.inf, 0), -safest, partial, at, margin)
        found = {}
        for _, partial, at, margin in best.values():
            one = self.pairs.extended(partial, k, np.unravel_index(at, pairs.shape), margin)
            found[tuple(sorted(one.picks.items()))] = one
        return list(found.values())


def _typical(x: Array) -> float:
    """The median of masses or prices, by which they are scaled; 1 where it is 0."""
    return float(np.median(x)) or 1.0
