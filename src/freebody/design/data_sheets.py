"""The numbers of a data sheet: what each must be, and how varying loads wear a part as one does."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Any, ClassVar, Literal, TypeGuard

import numpy as np

from freebody.arrays import as_floats
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, shown

Curve = tuple[tuple[float, float], ...]
"""Points (speed in rad/s, torque in N m) of a limit that falls with the speed, straight between."""


@dataclass(frozen=True)
class PartNumber:
    """One number of a part: its name, its unit, its meaning, what it must be, and whether every
    part has it."""

    name: str
    unit: str
    what: str
    bound: Literal["above 0", "0 or more", "above 0, up to 1"] = "above 0"
    needed: bool = False

    @property
    def kind(self) -> str:
        """The kind of its unit, by which files may give others."""
        return "speed" if self.unit == "rad/s" else "number"

    def fault(self, value: float) -> str | None:
        """Why no part has this number, or None."""
        good = {
            "above 0": value > 0.0,
            "0 or more": value >= 0.0,
            "above 0, up to 1": 0.0 < value <= 1.0,
        }[self.bound]
        if good and math.isfinite(value):
            return None
        return (
            f"{self.name} is {value:g} {self.unit}".rstrip() + f", expected a number {self.bound}"
        )


@dataclass(frozen=True, eq=False)
class DataSheet(ByValue):
    """A name and checked numbers, which motors, gears and bearings have in common."""

    name: str
    NUMBERS: ClassVar[tuple[PartNumber, ...]] = ()
    CURVES: ClassVar[tuple[str, ...]] = ()
    WHAT: ClassVar[str] = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise self.refusal(f"its name is {shown(self.name)}, expected text")
        for number in self.NUMBERS:
            self._take(number)
        for curve in self.CURVES:
            object.__setattr__(self, curve, self._curve(curve))
        super().__post_init__()

    def _take(self, number: PartNumber) -> None:
        value = getattr(self, number.name)
        if value is None and not number.needed:
            return
        if not _is_number(value):
            raise self.refusal(f"{number.name} is {shown(value)}, expected a number")
        if fault := number.fault(float(value)):
            raise self.refusal(fault)
        object.__setattr__(self, number.name, float(value))

    def _curve(self, name: str) -> Curve:
        try:
            pairs: list[tuple[Any, Any]] = [
                (speed, torque) for speed, torque in getattr(self, name)
            ]
        except (TypeError, ValueError):
            pairs = [(None, None)]
        if not all(map(_is_number, chain.from_iterable(pairs))):
            raise self.refusal(f"{name} must be pairs of numbers (speed, torque)")
        points = tuple((float(speed), float(torque)) for speed, torque in pairs)
        if not all(math.isfinite(x) and x >= 0.0 for point in points for x in point):
            raise self.refusal(f"{name} has a speed or torque that is negative or not finite")
        for (slow, high), (fast, low) in pairwise(points):
            if not (slow < fast and low <= high):
                raise self.refusal(
                    f"{name} goes from {high:g} N m at {slow:g} rad/s to {low:g} N m at {fast:g} "
                    f"rad/s; speeds must grow and torques must not"
                )
        return points

    def refusal(self, problem: str) -> FreebodyError:
        """The error of a number that no such part has."""
        return FreebodyError(f"{self.WHAT} {self.name!r}: {problem}.")


def _is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a real number, NumPy's too; True and False are none."""
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def sure(number: float | None) -> float:
    """A number that every checked part of its kind has."""
    assert number is not None
    return number


def mean_load(load: Any, speed: Any, time: Any, exponent: float) -> float:
    """The constant load that wears a part as loads (k,) do at speeds (k,) during times (k,):
    (Σ |n| t |F|^p / Σ |n| t)^(1/p); 0 where nothing turns.

    Palmgren's and Miner's sum; ISO 281; of strain wave gears with p = 3 Harmonic Drive AG,
    1019659 11/2014, equation 18.2; of cycloidal ones with p = 10/3 Nabtesco, RV series.
    """
    given = {"load": load, "speed": speed, "time": time}
    F, n, t = (np.abs(as_floats("mean_load", name, x)) for name, x in given.items())
    turned = float(np.sum(n * t))
    largest = float(F.max(initial=0.0))
    if turned == 0.0 or largest == 0.0:
        return 0.0
    return largest * float(np.sum(n * t * (F / largest) ** exponent) / turned) ** (1.0 / exponent)
