"""`size`: motors and gears for all joints of a robot, from a catalogue.

Joints are chosen for from the tip to the base, each behind those whose drives it carries, so that
its load is known. For one joint all pairs are compared, and the front is exact. For several, the
search keeps at each joint the best partial choices by every mixture of mass and price and every
margin of a grid; mass alone, for which the lightest from the tip is the best, is one of them.

The share of peak torque, which needs every sample, is first taken at the few samples that were the
worst of some pair, which is never too much; what is chosen is then looked at everywhere, and where
it was worse elsewhere, that sample is added and the search goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array, above_zero
from freebody.design.catalogue import PartCatalogue
from freebody.design.drive_loads import (
    ChosenDrives,
    DriveLoads,
    Mounts,
    assembled,
    cycle_notices,
    demand_of,
    doubt_notices,
    refuse_no_gear,
)
from freebody.design.duty_cycle import Cycles, DutyCycle, duty_cycles
from freebody.design.front import front
from freebody.design.loads import (
    CycleLoads,
    DriveJoint,
    RestLoads,
    cycle_loads,
    drive_joints,
    order,
    rest_loads,
)
from freebody.design.pairs import LIMITS, Demand, PairTable, uses
from freebody.design.parts import Gear, Motor
from freebody.errors import FreebodyError, KindError, UnknownNameError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.trees.position_rates import Index
from freebody.values import ByValue

if TYPE_CHECKING:
    import xarray as xr

_MARGINS = (1.0, 1.1, 1.25, 1.5, 1.8, 2.2, 3.0)
"""Times the margin that is asked for: what partial choices are kept for."""
_MIXTURES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Shares of mass, the others of price, that partial choices are kept for."""
_TIE = 1e-6
"""Share of the other one where one alone counts."""
_SAME = 1e-12
_LEAST = 1e-300


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
        used = "beyond it" if np.isinf(self.share) else f"{100.0 * self.share:.4g} %"
        return f"{self.motor} with {self.gear}: {self.limit} {used}."


FITS = "fit"
"""The limit of a gear that is not made for a motor."""


@dataclass(frozen=True, eq=False, repr=False)
class Sizing(Tabled, ByValue):
    """Motors and gears from a catalogue that suffice for duty cycles: all choices that were found
    of which no other is lighter, cheaper and safer at once, the lightest first."""

    model: Model
    cycles: tuple[DutyCycle, ...]
    catalogue: PartCatalogue
    joints: tuple[DriveJoint, ...]
    choices: tuple[DriveChoice, ...]
    margin: float
    """The ratio of what is allowed to what is used that was asked for."""
    life: float
    """h that gears have to last."""
    hold: bool
    """Whether every motor must have a brake that holds its joint."""
    notices: tuple[str, ...]

    def _title(self) -> str:
        if not self.choices:
            return f"Sizing of {self.model.name!r}: {self.notices[0]}"
        first = self.choices[0]
        return (
            f"Sizing of {self.model.name!r}: {counted(len(self.choices), 'choice')} for "
            f"{counted(len(self.joints), 'joint')}; the lightest {first.mass:.4g} kg, margin "
            f"{first.margin:.3g}"
        )

    def _table(self) -> TextTable:
        return choice_table(self)

    def drive_loads(self, choice: DriveChoice | None = None) -> DriveLoads:
        """The loads of the motors and gears of a choice, default the lightest; its `model` is the
        robot with them."""
        drives = self._chosen(choice).drives
        masses = self._masses(drives)
        demands = [
            demand_of(self.loads, k, masses, self.life, self.rest) for k in range(len(self.joints))
        ]
        return assembled(self.model, self.cycles, self.joints, self.loads, demands, drives)

    def pair_uses(
        self, joint: str, carried: DriveChoice | ChosenDrives | None = None
    ) -> xr.DataArray:
        """The share that each motor with each gear would use of each limit, along (limit, motor,
        gear), where the joint carries other drives: of a choice, of some joints, or by default of
        the lightest choice; infinite where motor and gear do not fit."""
        import xarray

        names = [x.name for x in self.joints]
        if joint not in names:
            raise UnknownNameError("joint", joint, "this sizing", names)
        k = names.index(joint)
        drives = self._carried(carried)
        pairs = _pairs(self.catalogue, self.joints[k])
        demand = demand_of(self.loads, k, self._masses(drives), self.life, self.rest)
        found = uses(demand, pairs)
        return xarray.DataArray(
            found,
            {
                "limit": [limit.name for limit in LIMITS],
                "motor": [motor.name for motor in pairs.motors],
                "gear": [gear.name for gear in pairs.gears],
            },
            ("limit", "motor", "gear"),
        )

    def rejected(self, joint: str, choice: DriveChoice | None = None) -> tuple[RejectedPair, ...]:
        """Every pair that does not suffice for a joint, which carries the other drives of a choice
        (default: the lightest), with the limit that it exceeds most."""
        found = self.pair_uses(joint, choice)
        share, worst = found.values.max(axis=0), found.values.argmax(axis=0)
        pairs = _pairs(self.catalogue, next(x for x in self.joints if x.name == joint))
        motors, gears = found.motor.values, found.gear.values
        return tuple(
            RejectedPair(
                str(motors[m]),
                str(gears[g]),
                LIMITS[worst[m, g]].name if pairs.fits[m, g] else FITS,
                float(share[m, g]),
            )
            for m, g in np.argwhere(share > 1.0 / self.margin)
        )

    def _chosen(self, choice: DriveChoice | None) -> DriveChoice:
        if choice is not None:
            return choice
        if not self.choices:
            raise FreebodyError(f"size: there is no choice. {self.notices[0]}")
        return self.choices[0]

    def _carried(self, given: DriveChoice | ChosenDrives | None) -> ChosenDrives:
        if isinstance(given, Mapping):
            return given
        return self._chosen(given).drives if given or self.choices else {}

    def _masses(self, drives: ChosenDrives) -> Array:
        chosen = [drives.get(joint.name, ()) for joint in self.joints]
        return np.array([float(sum(part.mass for part in pair)) for pair in chosen])

    @cached_property
    def loads(self) -> CycleLoads:
        """The loads of the joints before any drive is chosen."""
        return cycle_loads(self.model, self.cycles, self.joints)

    @cached_property
    def rest(self) -> RestLoads | None:
        """The torques that hold the joints, where brakes have to."""
        return rest_loads(self.model, self.cycles, self.joints) if self.hold else None


def choice_table(found: Sizing, most: int | None = None) -> TextTable:
    """The choices as a table, the lightest first; most: how many of them."""
    names = [joint.name for joint in found.joints]
    rows = [
        (
            f"{x.mass:.4g} kg",
            "" if x.price is None else f"{x.price:.6g}",
            f"{x.margin:.3g}",
            f"{x.limit} of {x.joint}",
            *(f"{x.drives[name][0].name} + {x.drives[name][1].name}" for name in names),
        )
        for x in found.choices[:most]
    ]
    return TextTable(("mass", "price", "margin", "of", *names), rows, found.notices)


def size(
    model: Model,
    cycles: Cycles,
    catalogue: PartCatalogue,
    *,
    joints: Sequence[str] | None = None,
    mounts: Mounts = None,
    life: float = 0.0,
    margin: float = 1.0,
    hold: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Sizing:
    """Motors and gears for the joints of a robot, such that none in the catalogue is lighter,
    cheaper and safer at once.

    A drive loads the joints that carry it, so these are chosen for last. Every choice keeps every
    limit that its motors and gears have (`fb.drive_loads` lists them) by the margin.

    Parameters
    ----------
    model
        The robot without these drives: rotors and losses of gears that these joints have in its
        file do not count.
    cycles
        A DutyCycle or a Motion, or a list of those that the robot has to be able to do alike.
    catalogue
        Motors and gears, from `fb.catalogue` or made in Python.
    joints : names, optional
        Default: all that something drives.
    mounts : {joint: frame}, optional
        On which frame, at its origin, the mass of a joint's drive rides, None being the ground.
        Default: the link before the joint, at the joint.
    life : h
        How long gears have to last; 0: not asked.
    margin
        The ratio of what is allowed to what is used, at least; 1: limits are used up.
    hold
        Whether every motor must have a brake that holds its joint, by itself and without the help
        of a gear's losses: at the postures of the cycles and, in an open chain, wherever its limits
        let gravity load the joint most.
    progress
        Called with a text and the fraction done.

    Returns
    -------
    Sizing
        For one joint its choices are all that are best. For several they are the best that were
        found. Without any, the first of its notices tells what is missing.

    Raises
    ------
    FreebodyError, KindError, UnknownNameError
        Drives that carry each other among them.
    """
    if not isinstance(catalogue, PartCatalogue):
        raise KindError(
            "size", "catalogue", catalogue, "a PartCatalogue", "fb.catalogue reads one from a file."
        )
    for what, parts in (("motor", catalogue.motors), ("gear", catalogue.gears)):
        if not parts:
            raise FreebodyError(f"size: the catalogue has no {what}; add [[{what}]] rows.")
    margin = above_zero("size", "margin", margin)
    done = duty_cycles("size", model, cycles)
    driven = drive_joints("size", model, joints, mounts)
    say = progress or (lambda text, part: None)
    say("loads", 0.0)
    loads = cycle_loads(model, done, driven)
    rest = rest_loads(model, done, driven) if hold else None
    search = _SizingSearch(loads, rest, catalogue, life, margin, say)
    found = search.whole_front() if len(driven) == 1 else search.best_choices()
    empty = Sizing(model, done, catalogue, driven, (), margin, life, hold, ())
    notices = (*search.failure, *search.remarks, *doubt_notices(model), *cycle_notices(done))
    choices = tuple(search.choice(label) for label in found)
    return replace(empty, choices=choices, notices=notices)


def _pairs(catalogue: PartCatalogue, joint: DriveJoint) -> PairTable:
    return PairTable(catalogue.motors, refuse_no_gear("size", joint, catalogue.gears))


@dataclass(frozen=True, eq=False)
class _PartialChoice:
    """A choice for some joints: pairs (motor, gear) of those chosen, masses (n,) of all drives."""

    picks: dict[int, tuple[int, int]]
    masses: Array
    mass: float
    price: float
    margin: float

    def with_pair(
        self, k: int, pair: tuple[int, int], mass: float, price: float, margin: float
    ) -> _PartialChoice:
        """This choice with a pair for joint k."""
        masses = self.masses.copy()
        masses[k] = mass
        return _PartialChoice(
            {**self.picks, k: pair},
            masses,
            self.mass + mass,
            self.price + price,
            min(self.margin, margin),
        )


class _SizingSearch:
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
                tables[joint.turns] = _pairs(catalogue, joint)
        self.pairs = [tables[joint.turns] for joint in loads.joints]
        self.priced = all(np.isfinite(pairs.price).all() for pairs in tables.values())
        self.price = {k: x.price if self.priced else 0.0 * x.mass for k, x in enumerate(self.pairs)}
        self.failure: tuple[str, ...] = ()
        self.worst: list[Index] = [self._first_samples(k) for k in range(len(loads.joints))]
        self.allowed = [
            pairs.allowed(loads.speed[at, k])
            for k, (pairs, at) in enumerate(zip(self.pairs, self.worst, strict=True))
        ]

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on what did not count."""
        if self.priced:
            return ()
        return ("Prices do not count: not every motor and gear of the catalogue has one.",)

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

    def _is_true(self, k: int, partial: _PartialChoice) -> bool:
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
    def whole_front(self) -> list[_PartialChoice]:
        """All pairs of the only joint of which no other is better in everything."""
        start = _PartialChoice({}, np.zeros(1), 0.0, 0.0, np.inf)
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
    def best_choices(self) -> list[_PartialChoice]:
        """The best choices that were found, looked at everywhere."""
        found = [_PartialChoice({}, np.zeros(len(self.order)), 0.0, 0.0, np.inf)]
        for done, k in enumerate(self.order):
            self.say(f"drives of {self.loads.joints[k].name}", done / len(self.order))
            found, before = self._kept(k, found), found
            if not found:
                lightest = min(before, key=lambda one: one.mass)
                self._fail(k, lightest, self.margins(k, lightest.masses))
                return []
        best = front(*(np.array([getattr(x, aim) for x in found]) for aim in _AIMS))
        return [found[k] for k in best]

    def _worst_use(self, partial: _PartialChoice) -> tuple[float, int, int]:
        """(the largest share, its joint, its limit), at all samples."""
        found = (0.0, 0, 0)
        for k, (m, g) in partial.picks.items():
            demand, pairs = self._demand(k, partial.masses), self.pairs[k]
            one = PairTable([pairs.motors[m]], [pairs.gears[g]])
            peak = np.array([[pairs.peak_of(demand, m, g)[0]]])
            shares = uses(demand, one, peak)[:, 0, 0]
            found = max(found, (float(shares.max()), k, int(shares.argmax())))
        return found

    def _kept(self, k: int, partials: Sequence[_PartialChoice]) -> list[_PartialChoice]:
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
        self, k: int, partials: Sequence[_PartialChoice], margins: Sequence[Array]
    ) -> list[_PartialChoice]:
        """The best way to go on at joint k for each aim: a mixture of mass and price with at least
        some margin, and the largest margin."""
        pairs, price = self.pairs[k], self.price[k]
        scales = np.array([_typical(pairs.mass), _typical(price)])
        best: dict[tuple[float, int], tuple[float, _PartialChoice, int, Array]] = {}

        def offer(
            aim: tuple[float, int], cost: float, partial: _PartialChoice, at: int, x: Array
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

    def _extended(self, partial: _PartialChoice, k: int, at: Any, margins: Array) -> _PartialChoice:
        m, g = (int(x) for x in at)
        return partial.with_pair(
            k,
            (m, g),
            float(self.pairs[k].mass[m, g]),
            float(self.price[k][m, g]),
            float(margins[m, g]),
        )

    def _fail(self, k: int, partial: _PartialChoice, margins: Array) -> None:
        """Tell that nothing suffices for joint k, and what comes nearest."""
        m, g = np.unravel_index(int(margins.argmax()), margins.shape)
        near = self._extended(partial, k, (m, g), margins)
        only = _PartialChoice({k: near.picks[k]}, near.masses, 0.0, 0.0, 0.0)
        share, _, limit = self._worst_use(only)
        pairs = self.pairs[k]
        asked = "" if self.margin == 1.0 else f", with a margin of {self.margin:g}"
        self.failure = (
            f"No motor with a gear of the catalogue suffices for joint "
            f"{self.loads.joints[k].name!r}{asked}: nearest comes {pairs.motors[m].name} with "
            f"{pairs.gears[g].name}, which would use {100.0 * share:.4g} % of its "
            f"{LIMITS[limit].name}.",
        )

    def choice(self, partial: _PartialChoice) -> DriveChoice:
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
            1.0 / max(share, _LEAST),
            self.loads.joints[joint].name,
            LIMITS[limit].name,
        )


_AIMS = ("mass", "price", "margin")


def _typical(x: Array) -> float:
    """A scale of masses or prices."""
    return float(np.median(x)) or 1.0
