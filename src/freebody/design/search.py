"""The search for drives: pairs of motors and gears for joints that carry each other's drives.

Joints are chosen for from the tip to the base, each behind those whose drives it carries, so that
its load is known. For one joint all pairs are compared, and the front is exact. For several, a
first search keeps the best partial choices for some aims (`partial_choices`), a second one goes
through all that may become better (`all_choices`), and where these are too many, levels of the
margin tell what there can be at best (`margin_levels`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.arrays import Array
from freebody.design.all_choices import BetterChoices
from freebody.design.bounds import front
from freebody.design.catalogue import PartCatalogue
from freebody.design.choices import DriveChoice, PartialChoice, best, nothing, points
from freebody.design.loads import CycleLoads, RestLoads, order
from freebody.design.margin_levels import refined
from freebody.design.pair_margins import PairMargins
from freebody.design.pairs import LIMITS, margin_of, used_of
from freebody.design.partial_choices import Aims
from freebody.design.parts import Gear, Motor

_LEVELS = (1.0, 1.25, 1.8, 3.0)
"""Times the margin that is asked for: what partial choices are kept for."""
_MIXTURES = (1.0, 0.5, 0.0)
"""Shares of mass, the others of price, that partial choices are kept for."""
_SAME = 1e-9
_ENOUGH = 0.01
"""Tolerance below which no better choices are looked for."""


class SizingSearch:
    """The search over one catalogue for choices of at least a margin."""

    def __init__(
        self,
        loads: CycleLoads,
        rest: RestLoads | None,
        catalogue: PartCatalogue,
        life: float,
        margin: float,
        say: Callable[[str, float], None],
    ):
        self.joints, self.margin, self.say = loads.joints, margin, say
        self.order = order(loads)
        self.pairs = PairMargins(loads, rest, catalogue, life)
        self.failure: tuple[str, ...] = ()
        self.tolerance = 0.0
        """The factor less 1 by which the mass, the price or the margin of what was found may have
        to be improved to be as good as every choice that there is."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on what did not count, and on what was not compared."""
        found = []
        if not self.pairs.priced:
            found.append("Prices do not count: not every motor and gear of the catalogue has one.")
        if self.tolerance > 0.0:
            found.append(
                f"There are too many choices to compare all: one that is not listed could be at "
                f"most {100.0 * self.tolerance:.2g} % better in mass, price or margin than a "
                f"listed one that is better in neither of the others."
            )
        return tuple(found)

    def whole_front(self) -> list[PartialChoice]:
        """All pairs of the only joint of which no other is better in everything."""
        start = nothing(1)
        while True:
            margins = self.pairs.margins(0, start.masses)
            good = np.argwhere(margins >= self.margin)
            if not len(good):
                self._fail(0, start, margins)
                return []
            at = tuple(good.T)
            mass, price = self.pairs.pairs[0].mass[at], self.pairs.price[0][at]
            chosen = front(mass, price, margins[at])
            found = [self.pairs.extended(start, 0, good[k], margins) for k in chosen]
            true = [self.pairs.is_true(0, one) for one in found]
            if all(true):
                return found

    def best_choices(self) -> list[PartialChoice]:
        """The best choices for several joints that were found at once, looked at everywhere."""
        aims = Aims(self.pairs, [x * self.margin for x in _LEVELS], _MIXTURES, safest=True)
        found = [nothing(len(self.order))]
        for done, k in enumerate(self.order):
            self.say(f"drives of {self.joints[k].name}", done / len(self.order))
            found, before = aims.kept(k, found), found
            if not found:
                lightest = min(before, key=lambda one: one.mass)
                self._fail(k, lightest, self.pairs.margins(k, lightest.masses))
                return []
        return best(found)

    def near_front(self) -> list[PartialChoice]:
        """All choices of which no other is better in everything; where these are too many, some of
        them, so that one of those is as good as each other one, within `tolerance`."""
        known = self.best_choices()
        if not known:
            return known
        known = self._with_better(known)
        if self.tolerance > _ENOUGH:
            known, reached = refined(self.pairs, self.order, known, self.margin, _ENOUGH, self.say)
            self.tolerance = min(self.tolerance, reached)
        return known

    def _with_better(self, known: list[PartialChoice]) -> list[PartialChoice]:
        """Known choices, and those that are better, looked at everywhere."""
        while True:
            better = BetterChoices(self.pairs, self.order, self.margin)
            found = better.found(points(known), self.say)
            true = [self.pairs.is_true(k, one) for one in found for k in self.order]
            if all(true):
                self.tolerance = better.tolerance
                return best([*known, *found])

    def _fail(self, k: int, partial: PartialChoice, margins: Array) -> None:
        """Tell that nothing suffices for joint k, and what comes nearest."""
        m, g = np.unravel_index(int(margins.argmax()), margins.shape)
        near = self.pairs.extended(partial, k, (m, g), margins)
        share, limit = self.pairs.worst_use(k, near)
        pairs = self.pairs.pairs[k]
        asked = "" if self.margin == 1.0 else f", with a margin of {self.margin:g}"
        self.failure = (
            f"No motor with a gear of the catalogue suffices for joint "
            f"{self.joints[k].name!r}{asked}: nearest comes {pairs.motors[m].name} with "
            f"{pairs.gears[g].name}, which would use "
            f"{used_of(share, f'its {LIMITS[limit].name}')}.",
        )

    def choice(self, partial: PartialChoice) -> DriveChoice:
        """The choice as it is told."""
        weakest = np.flatnonzero(partial.margins <= partial.margin * (1.0 + _SAME))
        (share, limit), joint = max(
            (self.pairs.worst_use(k, partial), k) for k in map(int, weakest)
        )
        drives: dict[str, tuple[Motor, Gear]] = {}
        for k, joint_of in enumerate(self.joints):
            m, g = partial.picks[k]
            drives[joint_of.name] = self.pairs.pairs[k].motors[m], self.pairs.pairs[k].gears[g]
        return DriveChoice(
            drives,
            partial.mass,
            partial.price if self.pairs.priced else None,
            margin_of(share),
            self.joints[joint].name,
            LIMITS[limit].name,
        )
