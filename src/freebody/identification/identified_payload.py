"""`IdentifiedPayload`: what an arm carries, as its logs tell it, in numbers and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from freebody.by_value import ByValue
from freebody.errors import UnknownNameError
from freebody.identification.drift import FrictionChange
from freebody.identification.reported import Reported
from freebody.model.model import Model
from freebody.outputs.display import TextTable

PayloadOutcome = Literal["told", "not told", "no payload alone"]

DENSITY = 2000.0
"""kg/m³ of the ball whose shape counts where the logs do not tell the load's: between water and
aluminium."""


@dataclass(frozen=True)
class PayloadNumber:
    """A number of a load. value: of the regression, with its interval of 95 %, lower … upper, or
    NaN. in_model: of the nearest load that a body can have. told: whether the interval says more
    than that the number is small or unknown."""

    name: str
    unit: str
    value: float
    lower: float
    upper: float
    in_model: float
    told: bool


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiedPayload(Reported, ByValue):
    """The load that an arm carries, as its logs tell it.

    model: the given one with the load. frame: that the load is fixed to, in whose axes its numbers
    are. numbers: mass, com.x, …, inertia.xx, … about the centre. friction: how it changed between
    the logs, joint by joint; empty where there is one log. unexplained: how many times larger than
    their noise the differences are that no load on this frame explains; intervals are wider by it
    where it is above what noise gives.
    """

    model: Model
    frame: str
    numbers: tuple[PayloadNumber, ...]
    friction: tuple[FrictionChange, ...]
    unexplained: float
    outcome: PayloadOutcome
    """Whether the logs tell a mass above 0, and differ by nothing but the load and friction."""
    verdict: str
    notices: tuple[str, ...]
    _aside = ("verdict", "notices")

    @property
    def mass(self) -> PayloadNumber:
        """The load's mass, kg."""
        return self.numbers[0]

    def __getitem__(self, name: str) -> PayloadNumber:
        for x in self.numbers:
            if x.name == name:
                return x
        raise UnknownNameError("number", name, "payload", [x.name for x in self.numbers])

    def _title(self) -> str:
        return f"Payload of {self.model.name} at {self.frame}: {self.outcome}"

    def _table(self) -> TextTable:
        rows = [
            (
                x.name,
                "–" if np.isnan(x.value) else f"{x.value:.4g}",
                "–" if np.isnan(x.lower) else f"{x.lower:.4g} … {x.upper:.4g}",
                f"{x.in_model:.4g}",
                x.unit,
                "" if x.told else "not told by these motions",
            )
            for x in self.numbers
        ]
        head = ("number", "value", "95 %", "in the model", "unit", "")
        return TextTable(head, rows, (self.verdict, *self.notices))


def payload_verdict(
    outcome: PayloadOutcome, strange: bool, numbers: Sequence[PayloadNumber], frame: str, dim: int
) -> str:
    """The verdict on a load in one sentence. strange: whether the logs differ by more than it."""
    mass = numbers[0]
    if outcome == "not told" and np.isnan(mass.lower):
        said = f"The mass of a load at {frame} is not told apart from its inertia by these motions"
    elif outcome == "not told":
        said = (
            f"The logs tell no load at {frame}: its mass is {mass.lower:.3g} … {mass.upper:.3g} kg"
        )
    else:
        centre = numbers[1 : 1 + dim]
        at = ", ".join("not told" if np.isnan(x.value) else f"{x.value:.3g}" for x in centre)
        said = (
            f"The load at {frame} weighs {mass.value:.4g} kg ({mass.lower:.4g} … {mass.upper:.4g})"
            f", its centre is at ({at}) m"
        )
    more = "; torques differ by more than a load there gives, which the intervals count"
    return f"{said}{more if strange else ''}."


def payload_notices(
    numbers: Sequence[PayloadNumber],
    changes: Sequence[FrictionChange],
    known: bool,
    strange: float,
    frame: str,
) -> list[str]:
    """Sentences on what the numbers of a load rest on. known: whether the model's masses count as
    known. strange: by how much more than noise the logs differ than a load explains, or 0."""
    found = []
    if known:
        found.append(
            "There is no log without the load: the model's masses and rotors count as known, and "
            "what is wrong with them is in the load."
        )
    if strange:
        what = "the model's masses are not the arm's" if known else "more than the load has changed"
        found.append(
            f"Torques differ by {strange:.2g} times more than their noise from what any load at "
            f"{frame} gives: {what}, or the load is elsewhere; intervals are wider by that."
        )
    untold = [x.name for x in numbers if not x.told]
    if untold:
        what = ", ".join(untold) if len(untold) < len(numbers) else "any number"
        found.append(
            f"These motions do not tell {what} of the load; where they do not, the model has those "
            f"of an even ball of {DENSITY:.0f} kg/m³."
        )
    changed = [x for x in changes if x.significant]
    if changed:
        found.append(
            "Friction changed between the logs without the load and those with it, and was "
            f"estimated in each: {', '.join(x.text() for x in changed)}."
        )
    return found
