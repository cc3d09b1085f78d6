"""The record of a drive law: its numbers, its torque over scalars, and its further properties.

A law acts along a joint of one coordinate. All but its torque, inertia and energy has a default, so
that most laws are a few lines.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import FreebodyError, ModelError
from freebody.lazy import cached_property
from freebody.spatial import Vector

TorqueOfLaw = Callable[[Vector, Scalar, Scalar, Scalar], Scalar]
"""(scalars, position, rate, s) -> the torque that the motor needs besides, s being the sign of the
rate or what stands for it; linear in s."""

_UNITS = {
    True: {"effort": "N m", "position": "rad", "inertia": "kg m²", "waves": "1"},
    False: {"effort": "N", "position": "m", "inertia": "kg", "waves": "rad/m"},
}
"""Units of a joint that turns, and of one that slides."""


@dataclass(frozen=True)
class LawNumber:
    """One number of a drive law.

    name: as an attribute of `Drive`. label: behind the joint's name, "friction.viscous"; in files
    the table and its key. unit: with {effort}, {position}, {inertia} and {waves}, angle over
    position, of the joint. what: in words. short: in tables of symbols, where that differs.
    refused: why no joint has such a number, or None. strict: whether without such a number the law
    says nothing, so that no policy accepts what is refused. needed: whether a file that has its
    table gives it too. waits: whether it may be known before the strength, as of data sheets.
    below: of a number within bounds the upper one. period: after which it means the same again.
    """

    name: str
    label: str
    unit: str
    what: str
    short: str = ""
    default: float = 0.0
    refused: Callable[[float], str | None] | None = None
    strict: bool = False
    needed: bool = False
    waits: bool = False
    below: float = math.inf
    period: float = math.inf

    @property
    def words(self) -> str:
        """The name of the number in tables of symbols."""
        return self.short or self.what

    @cached_property
    def place(self) -> tuple[str, str]:
        """The table of a file and the key in it that hold the number."""
        table, key = self.label.split(".")
        return table, key

    def kind_of(self, turns: bool) -> str:
        """The kind of the number's unit, by which files may give others, such as degrees."""
        return {"rad": "angle", "rad/s": "rate"}.get(self.unit_of(turns), "number")

    def unit_of(self, turns: bool) -> str:
        """The number's unit at a joint that turns, or at one that slides."""
        return self._units[turns]

    @cached_property
    def _units(self) -> dict[bool, str]:
        return {turns: self.unit.format(**units) for turns, units in _UNITS.items()}


def at_least_zero(what: str) -> Callable[[float], str | None]:
    """A check of a number that returns the refusal of a negative value, or None."""
    return lambda x: f"{what} {x:g} is negative; give it as 0 or more" if x < 0.0 else None


def above_zero(what: str) -> Callable[[float], str | None]:
    """A check of a number that returns the refusal of a value that is not positive, or None."""
    return lambda x: None if x > 0.0 else f"{what} is {x:g}; give a number above 0"


def quotient(part: Any, whole: Any, otherwise: Any, what: str, owner: str) -> Any:
    """part / whole; `otherwise` where both are 0. Raises ModelError, which names `what` and the
    owner, where the whole alone is 0."""
    if np.any((whole == 0.0) & (part != 0.0)):
        raise ModelError(f"{owner}: {what}.")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(whole == 0.0, otherwise, part / whole)


def resting_elsewhere(numbers: Vector, flip: float, offset: float) -> Vector:
    """The strength and rest position of a spring for a joint at flip times its position plus
    offset."""
    strength, rest = numbers
    return strength, flip * rest + offset


@dataclass(frozen=True)
class LinearForm:
    """A drive law as a linear function of parameters other than its strength.

    names: of the parameters. values: of the law's scalars. torques: (scalars, position, rate, s) ->
    the torque of each parameter, being 1. energies: (scalars, position) -> its energy, without what
    no motion changes. numbers: (entries, the law's numbers now, whose) -> the law's numbers.
    """

    names: tuple[str, ...]
    values: Callable[[Vector], Vector]
    torques: Callable[[Vector, Scalar, Scalar, Scalar], Vector]
    energies: Callable[[Vector, Scalar], Vector]
    numbers: Callable[[Sequence[Any], Mapping[str, Any], str], dict[str, Any]]


NO_PARAMETERS = LinearForm(
    (),
    values=lambda p: (),
    torques=lambda p, position, rate, s: (),
    energies=lambda p, position: (),
    numbers=lambda entries, now, owner: {},
)
"""Columns of a law that is linear in nothing: its numbers are no parameters."""


@dataclass(frozen=True)
class DriveLaw:
    """A law of drives. Its scalars are made of its numbers; the first is its strength, without
    which it does not act, and in which every law but losses is linear.

    feature: "friction", "rotors" or "springs", by which a model is without it. words: the same, of
    one joint. term: its term of an equation. torque: see `TorqueOfLaw`. inertia: (scalars) -> what
    q̈ is multiplied by. energy: (scalars, position) -> the energy it stores. stored: the same in
    words, of a law that has one. scalars: of its numbers in their order, where they are not these.
    recounted: (numbers, flip, offset) -> the numbers of the same law where the joint is at flip
    times its position plus offset, flip being 1 or -1, where these are others. form: as a linear
    function of other parameters than its strength. waves: (scalars) -> by which angle a torque that
    comes and goes with the position turns for each unit of it. power: of the rate, to which
    friction is proportional, where it is to one. signed: whether the torque depends on s. losses:
    (scalars) -> which part of the torque that the joint transmits is lost while the motor drives
    it, and which of it the motor is spared while the joint drives the motor. at_joint: whether the
    torque acts on the joint itself, so that what is transmitted has it; friction and rotors are the
    motor's. usual: whether it is counted wherever any law acts, so that kernels and regressors do
    not depend on which of the usual ones are 0. assumed_by: functions that count on the law at each
    joint unless they are given others; it is of one parameter then.
    """

    name: str
    feature: str
    words: str
    term: str
    numbers: tuple[LawNumber, ...]
    torque: TorqueOfLaw | None = None
    inertia: Callable[[Vector], Scalar] | None = None
    energy: Callable[[Vector, Scalar], Scalar] | None = None
    stored: str = ""
    scalars: Callable[..., Vector] | None = None
    recounted: Callable[[Vector, float, float], Vector] | None = None
    form: LinearForm | None = None
    waves: Callable[[Vector], Scalar] | None = None
    power: int | None = None
    signed: bool = False
    losses: Callable[[Vector], tuple[Scalar, Scalar]] | None = None
    at_joint: bool = False
    usual: bool = False
    assumed_by: tuple[Literal["identify", "excitation"], ...] = ()

    @property
    def strength(self) -> str:
        """The name of the law's strength, the number without which it does not act."""
        return self.numbers[0].name

    @property
    def is_constant(self) -> bool:
        """Whether the law is a torque that depends neither on the rate nor on its sign."""
        return self.power == 0 and not self.signed

    @property
    def off(self) -> dict[str, float]:
        """The numbers of the law with which it does not act."""
        bounded = {number.name: 0.0 for number in self.numbers if number.below < math.inf}
        return {self.strength: 0.0} | bounded

    def scalars_of(self, read: Callable[[str], Scalar]) -> Vector:
        """The law's scalars, from numbers by name. Raises FreebodyError for symbols that it cannot
        divide by."""
        own = tuple([read(number.name) for number in self.numbers])
        if self.scalars is None:
            return own
        try:
            return self.scalars(*own)
        except FreebodyError:
            raise self.no_closed_form() from None

    def no_closed_form(self, where: str = "") -> FreebodyError:
        """The error that refuses a law which is no polynomial; where: text behind its name."""
        return FreebodyError(
            f"the {self.term}{where} has no closed form, which is a polynomial in sines, cosines "
            f"and rates: derive without it, model.with_drive(joint, {self.strength}=0), or take "
            f"numbers from a kernel."
        )

    def counted_otherwise(self, numbers: Vector, flip: float, offset: float) -> Vector:
        """The numbers of the same law where the joint is at flip times its position plus offset;
        flip is 1 or -1."""
        return numbers if self.recounted is None else self.recounted(numbers, flip, offset)

    @cached_property
    def size(self) -> int:
        """The number of the law's scalars."""
        return len(self.scalars_of(lambda name: 1.0))

    @cached_property
    def only_moving(self) -> bool:
        """Whether the law has a torque only while the joint moves."""
        unit = (1.0,) * self.size
        return self.torque is None or not any(self.torque(unit, x, 0.0, 0.0) for x in (0.0, 2.0))

    @cached_property
    def grips(self) -> bool:
        """Whether the law holds a joint at rest, with a torque of either sign."""
        if self.torque is None or not self.signed:
            return False
        unit = (1.0,) * self.size
        return bool(self.torque(unit, 0.0, 0.0, 1.0) != self.torque(unit, 0.0, 0.0, -1.0))

    # ------------------------------------------------------------ as a linear function
    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters in which the law is linear."""
        return (self.strength,) if self.form is None else self.form.names

    def parameter_values(self, p: Vector) -> Vector:
        """The values of the law's parameters, from its scalars."""
        return p[:1] if self.form is None else self.form.values(p)

    def torques(self, p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Vector:
        """The torque for each parameter of the law set to 1 alone, without the inertia's."""
        if self.form is not None:
            return self.form.torques(p, position, rate, s)
        return (0.0 if self.torque is None else self.torque((1.0, *p[1:]), position, rate, s),)

    def inertias(self, p: Vector) -> Vector:
        """The inertia for each parameter of the law set to 1 alone."""
        if self.inertia is None:
            return (0.0,) * len(self.parameters)
        return (self.inertia((1.0, *p[1:])),)

    def energies(self, p: Vector, position: Scalar) -> Vector:
        """The stored energy for each parameter of the law set to 1 alone."""
        if self.form is not None:
            return self.form.energies(p, position)
        return (0.0 if self.energy is None else self.energy((1.0, *p[1:]), position),)

    def numbers_of(
        self, entries: Sequence[Any], now: Mapping[str, Any], owner: str
    ) -> dict[str, Any]:
        """The numbers of the law for other parameters, given as NumPy arrays; numbers that these do
        not determine stay."""
        if self.form is None:
            return {self.strength: entries[0]}
        return self.form.numbers(entries, now, owner)
