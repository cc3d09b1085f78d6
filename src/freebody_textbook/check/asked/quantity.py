"""A quantity that an answer may be about, as a record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from freebody.expressions.quantities.kinds import Kind
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value

Mistaken = tuple[str, Callable[[], Value]]
"""A sentence about what may have been thought, and the value under it."""

ActingLoads = Literal["", "load", "weight", "motion"]
"""The loads that act besides drives and loops: a force from outside alone, with the weights, or
with these and the motion; "" of lines without such a force."""


@dataclass(frozen=True)
class AskedQuantity:
    """A quantity that an answer may be about: its kind, its indices from 1, and how to compute the
    correct value."""

    kind: Kind
    index: tuple[int, ...]
    compute: Callable[[], Value]
    idle: bool = False
    """Whether nothing drives the joint: the torque is 0, and that is its equation of motion."""
    joint: str = ""
    """The joint that it belongs to, in words."""
    axis: str = ""
    """The axis of a component of a vector: x, y or z."""
    in_world: Callable[[], Trig] | None = None
    """The component in the world's axes, of a vector that has those of its own body."""
    words: str = ""
    """The quantity in words, where its kind alone does not tell."""
    is_angular: bool = False
    """Whether radians are named in its unit."""
    thoughts: tuple[Mistaken, ...] = ()
    """Values for which it is often mistaken, each with a sentence that says so."""
    note: str = ""
    """A note on an answer that is right."""
    soft: bool = False
    """Whether its name is often one of the user's own: what has other units is not this."""
    acting: ActingLoads = ""
    """The loads that a line about a closed chain has besides a force from outside."""
    also: tuple[Mistaken, ...] = ()
    """Other values that are right, each with what is said of it."""

    def polynomial(self) -> Trig:
        """The correct value, for a quantity that is a polynomial and no quotient."""
        value = self.compute()
        assert isinstance(value, Trig)
        return value

    @property
    def title(self) -> str:
        """Description of the quantity in words."""
        return self.words or self.kind.titled(self.index, self.joint)


INVERSE = "inv"
"""The ending of a matrix's name where its inverse is meant."""

QuantityTable = list[list[AskedQuantity]]
"""A vector (one column) or a matrix of quantities."""
