"""`size`: motors and gears for all joints of a robot, from a catalogue."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array, above_zero
from freebody.by_value import ByValue
from freebody.design.catalogue import PartCatalogue
from freebody.design.choices import FITS, DriveChoice, RejectedPair
from freebody.design.drive_loads import (
    ChosenDrives,
    DriveLoads,
    Mounts,
    assembled,
    checked_life,
    cycle_notices,
    demand_of,
    doubt_notices,
)
from freebody.design.duty_cycle import Cycles, DutyCycle, duty_cycles
from freebody.design.heaviest import HeaviestPayloads, heaviest_payloads
from freebody.design.loads import (
    CycleLoads,
    DriveJoint,
    RestLoads,
    cycle_loads,
    drive_joints,
    rest_loads,
)
from freebody.design.notices import noise_notices, unmended
from freebody.design.pair_margins import pairs_for
from freebody.design.pairs import LIMITS, uses
from freebody.design.search import SizingSearch
from freebody.errors import FreebodyError, KindError, UnknownNameError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class Sizing(Tabled, ByValue):
    """Motors and gears from a catalogue that suffice for duty cycles: the choices of which no other
    is lighter, cheaper and safer at once, the lightest first, complete within a tolerance."""

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
    tolerance: float = 0.0
    """For every choice that suffices there is one in `choices` of at most 1 + tolerance times its
    mass and its price and of at least its margin over 1 + tolerance; 0: `choices` are the whole
    front, but of choices alike in all three one."""

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

    def heaviest(self, choice: DriveChoice | None = None) -> HeaviestPayloads:
        """How many times as heavy the payloads of the cycles may be with the drives of a choice,
        default the lightest, until a limit keeps no more than the margin; lives, RMS torques, gears
        and brakes count as in the choice."""
        drives = self._chosen(choice).drives
        return heaviest_payloads(
            self.model, self.cycles, self.joints, drives,
            life=self.life, hold=self.hold, margin=self.margin,
        )  # fmt: skip

    @property
    def carries(self) -> bool:
        """Whether a segment of the cycles has a payload."""
        return any(x.payload is not None for cycle in self.cycles for x in cycle.segments)

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
        pairs = pairs_for(self.catalogue, self.joints[k])
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
        pairs = pairs_for(self.catalogue, next(x for x in self.joints if x.name == joint))
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
        Its choices are all that are best, but where there are too many to compare: then its
        `tolerance`, and one of its notices, tell how much better another choice could be. Without
        any, the first of its notices tells what is missing.

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
    margin, life = above_zero("size", "margin", margin), checked_life("size", life)
    done = duty_cycles("size", model, cycles)
    driven = drive_joints("size", model, joints, mounts)
    say = progress or (lambda text, part: None)
    say("loads", 0.0)
    loads = cycle_loads(model, done, driven)
    rest = rest_loads(model, done, driven) if hold else None
    search = SizingSearch(loads, rest, catalogue, life, margin, say)
    found = search.whole_front() if len(driven) == 1 else search.near_front()
    empty = Sizing(model, done, catalogue, driven, (), margin, life, hold, ())
    notices = (*search.failure, *search.remarks, *doubt_notices(model), *unmended(model, done),
               *noise_notices(model, done), *cycle_notices(done))  # fmt: skip
    choices = tuple(search.choice(label) for label in found)
    return replace(empty, choices=choices, notices=notices, tolerance=search.tolerance)
