"""The quantities of a log, a record each: the words by which headers name them, and their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from freebody.motion.files.csv_columns import UNITS

RPM = 0.10471975511965977  # rad/s


@dataclass(frozen=True)
class LogQuantity:
    """A quantity of a joint that a column of a log may hold."""

    name: str
    words: frozenset[str]
    """Words of headers, in lower case."""
    of_turning: Mapping[str, float]
    """Units where the joint turns, with their sizes in SI units."""
    of_sliding: Mapping[str, float]
    """Units where the joint slides."""
    turns_over: bool
    """Whether it changes sign with the joint's direction."""
    needed: bool = False

    def units(self, turns: bool | None) -> Mapping[str, float]:
        """The units for a joint that turns or slides; None: not known which."""
        if turns is None:
            return {**self.of_turning, **self.of_sliding}
        return self.of_turning if turns else self.of_sliding


def words_in(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


def _per_second(units: Mapping[str, float]) -> dict[str, float]:
    return {f"{unit}/s": size for unit, size in units.items()}


_DEGREES = {"degC": 1.0, "°C": 1.0, "C": 1.0}
QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        LogQuantity(
            "position",
            words_in("position positions pos q angle angles"),
            UNITS["angle"],
            UNITS["length"],
            True,
            needed=True,
        ),
        LogQuantity(
            "velocity",
            words_in("velocity velocities vel qd dq qdot v rate rates speed speeds"),
            {**_per_second(UNITS["angle"]), "rpm": RPM},
            _per_second(UNITS["length"]),
            True,
        ),
        LogQuantity(
            "torque",
            words_in("torque torques effort efforts tau trq force forces"),
            UNITS["torque"],
            UNITS["force"],
            True,
        ),
        LogQuantity(
            "current",
            words_in("current currents cur amps"),
            {"A": 1.0, "mA": 1e-3},
            {"A": 1.0, "mA": 1e-3},
            True,
        ),
        LogQuantity(
            "temperature",
            words_in("temperature temperatures temp"),
            _DEGREES,
            _DEGREES,
            False,
        ),
    )
}
TIME_UNITS = UNITS["time"]
