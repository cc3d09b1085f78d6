"""Choices of motors and gears: as they are told, and while they are made joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.design.bounds import Points, front
from freebody.design.drive_loads import ChosenDrives
from freebody.design.pairs import used
from freebody.outputs.display import Tabled, TextTable


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


@dataclass(frozen=True, eq=False)
class PartialChoice:
    """A choice for some joints: pairs (motor, gear) of those chosen, masses (n,) of all drives and
    margins (n,), infinite of those not chosen."""

    picks: dict[int, tuple[int, int]]
    masses: Array
    margins: Array
    mass: float
    price: float
    margin: float

    def with_pair(
        self, k: int, pair: tuple[int, int], mass: float, price: float, margin: float
    ) -> PartialChoice:
        """This choice with a pair for joint k."""
        masses, margins = self.masses.copy(), self.margins.copy()
        masses[k], margins[k] = mass, margin
        return PartialChoice(
            {**self.picks, k: pair},
            masses,
            margins,
            self.mass + mass,
            self.price + price,
            min(self.margin, margin),
        )


def nothing(joints: int) -> PartialChoice:
    """The choice of drives for a number of joints before a pair is chosen for any of them."""
    return PartialChoice({}, np.zeros(joints), np.full(joints, np.inf), 0.0, 0.0, np.inf)


def points(choices: Sequence[PartialChoice]) -> Points:
    """The masses, prices and margins of choices."""
    aims = ("mass", "price", "margin")
    return Points(*(np.array([getattr(one, aim) for one in choices]) for aim in aims))


def best(choices: Sequence[PartialChoice]) -> list[PartialChoice]:
    """The choices of which no other is better in everything, those alike but for the order of their
    sums taken as equal."""
    every = points(choices)
    return [choices[k] for k in front(*map(_rounded, (every.mass, every.price, every.margin)))]


def _rounded(x: Array) -> Array:
    """Numbers of which those alike but for the order of their sums are equal."""
    scale = np.abs(x[np.isfinite(x)]).max(initial=0.0) or 1.0
    return np.round(x / scale, 11)
