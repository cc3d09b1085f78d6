"""One quantity that can be asked."""

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
"""What acts besides drives and loops: a force from outside alone, with the weights, or with these
and the motion; "" of lines without such a force."""


@dataclass(frozen=True)
class AskedQuantity:
    """One quantity: its kind, indices from 1, and how to compute the right value."""

    kind: Kind
    index: tuple[int, ...]
    compute: Callable[[], Value]
    idle: bool = False
    """Whether nothing drives the joint: the torque is 0, and that is its equation of motion."""
    joint: str = ""
    """The joint that it belongs to, in words."""
    axis: str = ""
    """Of a body's vector: x, y or z."""
    in_world: Callable[[], Trig] | None = None
    """The same component in the world's axes, of a vector that has those of its own body."""
    words: str = ""
    """What it is, where its kind alone does not tell."""
    is_angular: bool = False
    """Whether radians are named in its unit."""
    thoughts: tuple[Mistaken, ...] = ()
    """What it is often mistaken for: a sentence that says so, and its value."""
    note: str = ""
    """What is said of an answer that is right."""
    soft: bool = False
    """Whether its name is often one of the user's own: what has other units is not this."""
    acting: ActingLoads = ""
    """Of a closed chain under a force from outside what else a line has: nothing, weights, or the
    motion too."""
    also: tuple[Mistaken, ...] = ()
    """Other values that are right, each with what is said of it."""

    def polynomial(self) -> Trig:
        """The right value of what is none of the quotients."""
        value = self.compute()
        assert isinstance(value, Trig)
        return value

    @property
    def title(self) -> str:
        """What it is, in words."""
        return self.words or self.kind.titled(self.index, self.joint)


INVERSE = "inv"
"""What the name of a matrix ends with where its inverse is meant."""

QuantityTable = list[list[AskedQuantity]]
"""A vector (one column) or a matrix of quantities."""
