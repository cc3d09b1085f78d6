"""One quantity that can be asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from freebody.derivations.check.algebra.quotients import Value
from freebody.scalars.trig import Trig

Mistaken = tuple[str, Callable[[], Value]]
"""A sentence about what may have been thought, and the value under it."""


@dataclass(frozen=True)
class AskedQuantity:
    """One quantity: its family ("tau", "M", …), indices from 1, and how to compute the right
    value."""

    family: str
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
    """What it is, where its family alone does not tell."""
    thoughts: tuple[Mistaken, ...] = ()
    """What it is often mistaken for: a sentence that says so, and its value."""
    note: str = ""
    """What is said of an answer that is right."""
    soft: bool = False
    """Whether its name is often one of the user's own: what has other units is not this."""
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
        return self.words or _TITLES[self.family].format(*self.index, joint=self.joint)


LONG = "long"
"""The family of an equation of a closed chain that is too long to be multiplied out: its sides are
compared in numbers."""
INVERSE = "inv"
"""What the name of a matrix ends with where its inverse is meant."""

Table = list[list[AskedQuantity]]
"""A vector (one column) or a matrix of quantities."""

_TITLES = {
    "tau": "the drive's torque or force at {joint}",
    "0": "which nothing drives",
    "M": "entry {}, {} of the mass matrix",
    "C": "entry {}, {} of the Coriolis matrix of Christoffel symbols",
    "christoffel": "the Christoffel symbol of the mass matrix of row {}, column {} and rate {}",
    "c": "the velocity term of {joint}",
    "bias": "the velocity and gravity terms of {joint}",
    "g": "the gravity term of {joint}",
    "J": "entry {}, {} of the tip's Jacobian",
    "T": "the kinetic energy",
    "V": "the potential energy",
    "L": "the Lagrangian",
    "E": "the total energy",
    "Ti": "the kinetic energy of body {}",
    "Vi": "the potential energy of body {}",
    "h": "the velocity coefficient",
    "tip": "a coordinate of the tip",
    "tip_d": "a velocity of the tip",
    "tip_dd": "an acceleration of the tip",
    "det": "the determinant of the tip's Jacobian",
    "det M": "the determinant of the mass matrix",
    "derivative": "a derivative of the robot's quantities",
    "q": "one of the coordinates and their rates",
    "solved": "solved for it",
    "inverse": "entry {}, {} of the inverse of {joint}",
    "active": "the generalized active force of {joint}",
    "inertia": "the generalized inertia force of {joint}",
    "parameter": "which a formula gives",
    LONG: "an equation between the robot's quantities",
    "identity": "an equation between the robot's quantities",
}
