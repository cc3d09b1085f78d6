"""The search for drives: pairs of motors and gears for joints that carry each other's drives.

Joints are chosen for from the tip to the base, each behind those whose drives it carries, so that
its load is known. For one joint all pairs are compared, and the front is exact. For several, a
first search keeps at each joint the best partial choices by every mixture of mass and price and
every margin of a grid; mass alone, for which the lightest from the tip is the best, is one of them.
A second one goes through all partial choices but those that, by bounds of what the joints behind
can add, become no better than what is known already; where they are too many, it leaves those that
could gain least, and tells how much that is.

The share of peak torque, which needs every sample, is first taken at the few samples that were the
worst of some pair, which is never too much; what is chosen is then looked at everywhere, and where
it was worse elsewhere, that sample is added and the search goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.design.bounds import Points, best_margins, gain, ranges
from freebody.design.catalogue import PartCatalogue
from freebody.design.drive_loads import ChosenDrives, demand_of, refuse_no_gear
from freebody.design.front import front
from freebody.design.loads import CycleLoads, DriveJoint, RestLoads, order
from freebody.design.pairs import LIMITS, Demand, PairTable, margin_of, used, used_of, uses
from freebody.design.parts import Gear, Motor
from freebody.motion.ranges import Flags
from freebody.outputs.display import Tabled, TextTable
from freebody.trees.position_rates import Index

_MARGINS = (1.0, 1.1, 1.25, 1.5, 1.8, 2.2, 3.0)
"""Times the margin that is asked for: what partial choices are kept for."""
_MIXTURES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Shares of mass, the others of price, that partial choices are kept for."""
_TIE = 1e-6
"""Share of the other one where one alone counts."""
_SAME = 1e-12
_WORK = 60_000
"""Numbers that are computed for all partial choices that one joint is added to."""
_LEAST = 1e-300

_FEW = 32
"""Partial choices, fewer than which are not worth their time: bounds alone tell the tolerance."""


@dataclass(frozen=True, eq=False, repr=False)
class DriveChoice(Tabled, ByValue):
    """A motor and a gear for every joint."""

    drives: ChosenDrives
    mass: float
    """Mass of all motors and gears, kg."""
    price: float | None
    """Price of all of them; None where the catalogue has not all prices."""
    margin: float
    """The smallest ratio of what is allowed to what is used."""
    joint: str
    """The joint that has this margin."""
    limit: str
    """Its limit that has it."""

    def _title(self) -> str:
        price = "" if self.price is None else f", price {self.price:.6g}"
        return (
            f"Drives of {self.mass:.4g} kg{price}, margin {self.margin:.3g} "
            f"({self.limit} of {self.joint})"
        )

    def _table(self) -> TextTable:
        rows = [(name, motor.name, gear.name) for name, (motor, gear) in self.drives.items()]
        return TextTable(("joint", "motor", "gear"), rows)


@dataclass(frozen=True)
class RejectedPair:
    """A motor and a gear that do not suffice for a joint: the limit that it exceeds most, and the
    share that is used of it, infinite where there is nothing to use."""

    motor: str
    gear: str
    limit: str
    share: float

    @property
    def text(self) -> str:
        """The reason in a sentence."""
        if self.limit == FITS:
            return f"{self.gear} is not made for {self.motor}."
        return f"{self.motor} with {self.gear}: {self.limit} {used(self.share)}."


FITS = "fit"
"""The limit of a gear that is not made for a motor."""


def pairs_for(catalogue: PartCatalogue, joint: DriveJoint) -> PairTable:
    return PairTable(catalogue.motors, refuse_no_gear("size", joint, catalogue.gears))


@dataclass(frozen=True, eq=False)
class PartialChoice:
    """A choice for some joints: pairs (motor, gear) of those chosen, masses (n,) of all drives."""

    picks: dict[int, tuple[int, int]]
    masses: Array
    mass: float
    price: float
    margin: float

    def with_pair(
        self, k: int, pair: tuple[int, int], mass: float, price: float, margin: float
    ) -> PartialChoice:
        """This choice with a pair for joint k."""
        masses = self.masses.copy()
        masses[k] = mass
        return PartialChoice(
            {**self.picks, k: pair},
            masses,
            self.mass + mass,
            self.price + price,
            min(self.margin, margin),
        )


class SizingSearch:
    """The search over one catalogue; each joint has its pairs and the samples that were the worst
    of some."""

    def __init__(
        self,
        loads: CycleLoads,
        rest: RestLoads | None,
        catalogue: PartCatalogue,
        life: float,
        margin: float,
        say: Callable[[str, float], None],
    ):
        self.loads, self.rest, self.life = loads, rest, life
        self.margin, self.say = margin, say
        self.order = order(loads)
        tables: dict[bool, PairTable] = {}
        for joint in loads.joints:
            if joint.turns not in tables:
                tables[joint.turns] = pairs_for(catalogue, joint)
        self.pairs = [tables[joint.turns] for joint in loads.joints]
        self.priced = all(np.isfinite(pairs.price).all() for pairs in tables.values())
        self.price = {k: x.price if self.priced else 0.0 * x.mass for k, x in enumerate(self.pairs)}
        self.failure: tuple[str, ...] = ()
        self.tolerance = 0.0
        """The factor less 1 by which the mass, the price or the margin of what was found may have
        to be improved to be as good as every choice that there is."""
        self.worst: list[Index] = [self._first_samples(k) for k in range(len(loads.joints))]
        self.allowed = [
            pairs.allowed(loads.speed[at, k])
            for k, (pairs, at) in enumerate(zip(self.pairs, self.worst, strict=True))
        ]

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on what did not count, and on what was not compared."""
        found = []
        if not self.priced:
            found.append("Prices do not count: not every motor and gear of the catalogue has one.")
        if self.tolerance > 0.0:
            found.append(
                f"There are too many choices to compare all: one that is not listed could be at "
                f"most {100.0 * self.tolerance:.2g} % better in mass, price or margin than a "
                f"listed one that is better in neither of the others."
            )
        return tuple(found)

    def _first_samples(self, k: int) -> Index:
        """Samples that are the worst of a few pairs far apart, without drives."""
        demand, pairs = self._demand(k, np.zeros(len(self.loads.joints))), self.pairs[k]
        gears = np.argsort(pairs.factor[0])[[0, len(pairs.gears) // 2, -1]]
        motors = np.argsort([motor.inertia for motor in pairs.motors])[
            [0, len(pairs.motors) // 2, -1]
        ]
        found = {pairs.peak_of(demand, m, g)[1] for m in motors for g in gears}
        for size in (demand.torque, demand.speed, demand.acceleration):
            found.add(int(np.argmax(np.abs(size))))
        return np.array(sorted(found), dtype=np.intp)

    def _demand(self, k: int, masses: Array) -> Demand:
        return demand_of(self.loads, k, masses, self.life, self.rest)

    def margins(self, k: int, masses: Array) -> Array:
        """The margin (M, G) of each pair of joint k, at most too large."""
        demand, pairs = self._demand(k, masses), self.pairs[k]
        peak = pairs.peak_use(demand, self.worst[k], self.allowed[k])
        return 1.0 / np.maximum(uses(demand, pairs, peak).max(axis=0), _LEAST)

    def _is_true(self, k: int, partial: PartialChoice) -> bool:
        """Whether the samples known to be the worst are that of the pair of joint k; else they
        are from now on."""
        demand, pairs, (m, g) = self._demand(k, partial.masses), self.pairs[k], partial.picks[k]
        use, at = pairs.peak_of(demand, m, g)
        one = PairTable([pairs.motors[m]], [pairs.gears[g]])
        known = float(one.peak_use(demand, self.worst[k])[0, 0])
        if use <= known * (1.0 + _SAME):
            return True
        self.worst[k] = np.append(self.worst[k], at)
        more = pairs.allowed(self.loads.speed[[at], k])
        self.allowed[k] = np.concatenate([self.allowed[k], more])
        return False

    # ------------------------------------------------------------ one joint
    def whole_front(self) -> list[PartialChoice]:
        """All pairs of the only joint of which no other is better in everything."""
        start = PartialChoice({}, np.zeros(1), 0.0, 0.0, np.inf)
        while True:
            margins = self.margins(0, start.masses)
            good = np.argwhere(margins >= self.margin)
            if not len(good):
                self._fail(0, start, margins)
                return []
            at = tuple(good.T)
            mass, price = self.pairs[0].mass[at], self.price[0][at]
            best = front(mass, price, margins[at])
            found = [self._extended(start, 0, good[k], margins) for k in best]
            true = [self._is_true(0, one) for one in found]
            if all(true):
                return found

    # ------------------------------------------------------------ several joints
    def best_choices(self) -> list[PartialChoice]:
        """The best choices that were found, looked at everywhere."""
        found = [PartialChoice({}, np.zeros(len(self.order)), 0.0, 0.0, np.inf)]
        for done, k in enumerate(self.order):
            self.say(f"drives of {self.loads.joints[k].name}", done / len(self.order))
            found, before = self._kept(k, found), found
            if not found:
                lightest = min(before, key=lambda one: one.mass)
                self._fail(k, lightest, self.margins(k, lightest.masses))
                return []
        best = front(*(np.array([getattr(x, aim) for x in found]) for aim in _AIMS))
        return [found[k] for k in best]

    def near_front(self) -> list[PartialChoice]:
        """All choices of which no other is better in everything; where they are too many, some, and
        for each other one that is as good within `tolerance`."""
        known = self.best_choices()
        while known:
            self.tolerance = 0.0
            found = self._better(known)
            true = [self._is_true(k, one) for one in found for k in self.order]
            known = [*known, *found]
            best = _points(known)
            if all(true):
                whole = (_rounded(x) for x in (best.mass, best.price, best.margin))
                return [known[k] for k in front(*whole)]
            known = known[: len(known) - len(found)]
        return known

    def _better(self, known: Sequence[PartialChoice]) -> list[PartialChoice]:
        """Choices that are better in something than those known, their margins at most too
        large."""
        ahead, best = self._bounds(), _points(known)
        whole = float(gain(Points.nothing(), ahead[0], best)[0])
        if self._width < _FEW:
            self.tolerance = whole
        if self.tolerance == whole:
            return []
        found = [PartialChoice({}, np.zeros(len(self.order)), 0.0, 0.0, np.inf)]
        for done, k in enumerate(self.order):
            self.say(f"front at {self.loads.joints[k].name}", done / len(self.order))
            found = self._worth(k, found, ahead[done + 1], best)
        self.tolerance = min(self.tolerance, whole)
        return found

    def _worth(
        self, k: int, partials: Sequence[PartialChoice], ahead: Points, known: Points
    ) -> list[PartialChoice]:
        """The ways to go on at joint k that may become better than what is known, as many as there
        is time for: those that may gain most."""
        offers: list[tuple[float, int, int]] = []
        margins = [self.margins(k, partial.masses) for partial in partials]
        for at, (partial, margin) in enumerate(zip(partials, margins, strict=True)):
            good = np.flatnonzero(margin >= self.margin)
            reached = Points(
                partial.mass + self.pairs[k].mass.ravel()[good],
                partial.price + self.price[k].ravel()[good],
                np.minimum(partial.margin, margin.ravel()[good]),
            )
            gains = gain(reached, ahead, known)
            offers += [(float(x), at, int(j)) for x, j in zip(gains, good, strict=True) if x > 0.0]
        offers.sort(key=lambda offer: -offer[0])
        if len(offers) > self._width:
            self.tolerance = max(self.tolerance, offers[self._width][0])
        return [
            self._extended(partials[at], k, np.unravel_index(j, self.pairs[k].shape), margins[at])
            for _, at, j in offers[: self._width]
        ]

    @property
    def _width(self) -> int:
        """The number of partial choices that a joint is added to."""
        numbers = len(self.loads.speed) + 4 * max(pairs.mass.size for pairs in self.pairs)
        return max(1, _WORK // numbers)

    def _bounds(self) -> list[Points]:
        """Bounds of the drives of the joints still to be chosen for, from all to
        none."""
        good: list[Flags] = [pairs.fits for pairs in self.pairs]
        margins = [np.where(fits, np.inf, 0.0) for fits in good]
        for _ in range(_ROUNDS):
            least, most = ranges(self.pairs, good)
            margins = [
                best_margins(self.loads, self.rest, k, pairs, self.life, least, most,
                             (self.worst[k], self.allowed[k]))
                for k, pairs in enumerate(self.pairs)
            ]  # fmt: skip
            good = [margin >= self.margin for margin in margins]
        found = [Points.nothing()]
        for k in reversed(self.order):
            one = Points(self.pairs[k].mass[good[k]], self.price[k][good[k]], margins[k][good[k]])
            found.append(found[-1].and_each(one.best()))
        return found[::-1]

    def _worst_use(self, partial: PartialChoice) -> tuple[float, int, int]:
        """(the largest share, its joint, its limit), at all samples."""
        found = (0.0, 0, 0)
        for k, (m, g) in partial.picks.items():
            demand, pairs = self._demand(k, partial.masses), self.pairs[k]
            one = PairTable([pairs.motors[m]], [pairs.gears[g]])
            peak = np.array([[pairs.peak_of(demand, m, g)[0]]])
            shares = uses(demand, one, peak)[:, 0, 0]
            found = max(found, (float(shares.max()), k, int(shares.argmax())))
        return found

    def _kept(self, k: int, partials: Sequence[PartialChoice]) -> list[PartialChoice]:
        """The best ways to go on at joint k, one for each aim, looked at everywhere."""
        margins = [self.margins(k, partial.masses) for partial in partials]
        while True:
            found = self._aimed(k, partials, margins)
            known = len(self.worst[k])
            true = [self._is_true(k, one) for one in found]
            if all(true):
                return found
            fresh = self.worst[k][known:], self.allowed[k][known:]
            for partial, margin in zip(partials, margins, strict=True):
                peak = self.pairs[k].peak_use(self._demand(k, partial.masses), *fresh)
                np.minimum(margin, 1.0 / np.maximum(peak, _LEAST), out=margin)

    def _aimed(
        self, k: int, partials: Sequence[PartialChoice], margins: Sequence[Array]
    ) -> list[PartialChoice]:
        """The best way to go on at joint k for each aim: a mixture of mass and price with at least
        some margin, and the largest margin."""
        pairs, price = self.pairs[k], self.price[k]
        scales = np.array([_typical(pairs.mass), _typical(price)])
        best: dict[tuple[float, int], tuple[float, PartialChoice, int, Array]] = {}

        def offer(
            aim: tuple[float, int], cost: float, partial: PartialChoice, at: int, x: Array
        ) -> None:
            if aim not in best or cost < best[aim][0]:
                best[aim] = cost, partial, at, x

        for j, share in enumerate(min(max(x, _TIE), 1.0 - _TIE) for x in _MIXTURES):
            weights = np.array([share, 1.0 - share]) / scales
            cost = (weights[0] * pairs.mass + weights[1] * price).ravel()
            cheap = np.argsort(cost, kind="stable")
            for partial, margin in zip(partials, margins, strict=True):
                reach = np.minimum(margin.ravel()[cheap], partial.margin)
                so_far = float(weights @ (partial.mass, partial.price))
                for level in _MARGINS:
                    first = int(np.argmax(reach >= level * self.margin))
                    if reach[first] < level * self.margin:
                        break
                    at = int(cheap[first])
                    offer((level, j), so_far + float(cost[at]), partial, at, margin)
        for partial, margin in zip(partials, margins, strict=True):
            at = int(margin.argmax())
            safest = min(float(margin.flat[at]), partial.margin)
            if safest >= self.margin:
                offer((np.inf, 0), -safest, partial, at, margin)
        found = {}
        for _, partial, at, margin in best.values():
            one = self._extended(partial, k, np.unravel_index(at, pairs.shape), margin)
            found[tuple(sorted(one.picks.items()))] = one
        return list(found.values())

    def _extended(self, partial: PartialChoice, k: int, at: Any, margins: Array) -> PartialChoice:
        m, g = (int(x) for x in at)
        return partial.with_pair(
            k,
            (m, g),
            float(self.pairs[k].mass[m, g]),
            float(self.price[k][m, g]),
            float(margins[m, g]),
        )

    def _fail(self, k: int, partial: PartialChoice, margins: Array) -> None:
        """Tell that nothing suffices for joint k, and what comes nearest."""
        m, g = np.unravel_index(int(margins.argmax()), margins.shape)
        near = self._extended(partial, k, (m, g), margins)
        only = PartialChoice({k: near.picks[k]}, near.masses, 0.0, 0.0, 0.0)
        share, _, limit = self._worst_use(only)
        pairs = self.pairs[k]
        asked = "" if self.margin == 1.0 else f", with a margin of {self.margin:g}"
        self.failure = (
            f"No motor with a gear of the catalogue suffices for joint "
            f"{self.loads.joints[k].name!r}{asked}: nearest comes {pairs.motors[m].name} with "
            f"{pairs.gears[g].name}, which would use "
            f"{used_of(share, f'its {LIMITS[limit].name}')}.",
        )

    def choice(self, partial: PartialChoice) -> DriveChoice:
        """The choice as it is told."""
        share, joint, limit = self._worst_use(partial)
        drives: dict[str, tuple[Motor, Gear]] = {}
        for k, joint_of in enumerate(self.loads.joints):
            m, g = partial.picks[k]
            drives[joint_of.name] = self.pairs[k].motors[m], self.pairs[k].gears[g]
        return DriveChoice(
            drives,
            partial.mass,
            partial.price if self.priced else None,
            margin_of(share),
            self.loads.joints[joint].name,
            LIMITS[limit].name,
        )


_ROUNDS = 2
"""How often the pairs that may suffice narrow the masses by which they are found."""


def _points(choices: Sequence[PartialChoice]) -> Points:
    return Points(*(np.array([getattr(one, aim) for one in choices]) for aim in _AIMS))


def _rounded(x: Array) -> Array:
    """Numbers of which those alike but for the order of their sums are equal."""
    scale = np.abs(x[np.isfinite(x)]).max(initial=0.0) or 1.0
    return np.round(x / scale, 11)


_AIMS = ("mass", "price", "margin")


def _typical(x: Array) -> float:
    """A scale of masses or prices."""
    return float(np.median(x)) or 1.0
