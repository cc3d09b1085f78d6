"""The drive laws of a joint over scalars: torque, inertia and energy, as the algorithms need
them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.dual import Dual, slopes
from freebody.elementary import Scalar, absolute, less, sign, where
from freebody.model.drives import LAWS
from freebody.model.drives.law import DriveLaw
from freebody.spatial import Vector

if TYPE_CHECKING:
    from freebody.model.tree import Coordinates

USUAL = tuple(law.name for law in LAWS.values() if law.usual)
"""Names of the laws that are counted wherever any acts."""


class ActingLaw(NamedTuple):
    """A law of a drive with its scalars."""

    law: DriveLaw
    p: Vector


def _sign(law: DriveLaw, rate: Scalar) -> Scalar:
    return sign(rate)


@dataclass(frozen=True)
class DriveScalars:
    """The drive laws along a joint of one coordinate. at: its coordinates. sign: the function (law,
    rate) whose result replaces the sign of the joint's rate in a law."""

    laws: tuple[ActingLaw, ...]
    at: Coordinates
    sign: Callable[[DriveLaw, Scalar], Scalar] = _sign

    @property
    def inertia(self) -> Scalar:
        """Inertia that the drive adds to its joint: reflected rotor inertia, which multiplies the
        joint's second rate."""
        return inertia_of(self.laws)

    def torque(self, q: Vector, qd: Vector) -> Scalar:
        """The torque that friction, springs and the like need, without inertia and without losses
        of the transmitted torque."""
        (position,), (rate,) = self.at.position(q), self.at.rates(qd)
        return self._torque(position, rate, rate)

    @property
    def lossy(self) -> bool:
        """Whether the joint loses part of the torque that it transmits."""
        return any(x.law.losses is not None for x in self.laws)

    @property
    def at_joint(self) -> DriveScalars:
        """The laws that act on the joint itself, so that their torque is transmitted too."""
        return self.only(lambda law: law.at_joint)

    @property
    def at_motor(self) -> DriveScalars:
        """The laws that act on the motor's side of a lossy gear, so that their torque is not
        transmitted."""
        return self.only(lambda law: not law.at_joint)

    def lost(self, needed: Scalar, q: Vector, qd: Vector) -> Scalar:
        """The torque that the motor supplies in addition because of losses: what is transmitted is
        the torque that the bodies need and that of the laws at the joint itself."""
        transmitted = needed + self.at_joint.torque(q, qd)
        return self.lost_part(qd, transmitted) * transmitted

    def lost_part(self, qd: Vector, direction: Scalar) -> Scalar:
        """The loss as a fraction of the transmitted torque, without friction; negative where the
        joint drives the motor. direction: a number with the sign of the transmitted torque."""
        lossy = [x for x in self.laws if x.law.losses is not None]
        if not lossy:
            return 0.0
        (rate,) = self.at.rates(qd)
        s, (driving, driven) = self.sign(lossy[0].law, rate), self.losses
        return where(less(0.0, s * direction), absolute(s) * driving, -(absolute(s) * driven))

    @property
    def losses(self) -> tuple[Scalar, Scalar]:
        """The lost fraction of the transmitted torque while the motor drives the joint, and the
        fraction that the motor is spared while the joint drives it, of all laws in a row."""
        driving, driven = 0.0, 0.0
        for x in self.laws:
            if x.law.losses is not None:
                lost, spared = x.law.losses(x.p)
                driving, driven = driving + lost + driving * lost, driven + spared - driven * spared
        return driving, driven

    def energy(self, q: Vector) -> Scalar:
        """The energy that springs and the like store at a position (J)."""
        (position,) = self.at.position(q)
        return _sum(x.law.energy(x.p, position) for x in self.laws if x.law.energy is not None)

    def slopes(self, q: Vector, qd: Vector) -> tuple[Scalar, Scalar]:
        """The derivatives of the torque by the joint's position and rate, with the rate's sign kept
        constant."""
        (position,), (rate,) = self.at.position(q), self.at.rates(qd)
        found = self._torque(Dual(position, {0: 1.0}), Dual(rate, {1: 1.0}), rate)
        by_position, by_rate = slopes(found, 2)
        return by_position, by_rate

    # ------------------------------------------------------------ as a linear function
    def parameters(self) -> list[Scalar]:
        """The parameters of all laws in which torque and energy are linear, law by law."""
        return [x for own in self.laws for x in own.law.parameter_values(own.p)]

    def unit_torques(self, q: Vector, qd: Vector, qdd: Vector) -> list[Scalar]:
        """The torque at the joint for each parameter set to 1 alone."""
        (position,), (rate,), (second,) = self.at.position(q), self.at.rates(qd), self.at.rates(qdd)
        found: list[Scalar] = []
        for x in self.laws:
            torques = x.law.torques(x.p, position, rate, self.sign(x.law, rate))
            pairs = zip(torques, x.law.inertias(x.p), strict=True)
            found += [torque + inertia * second for torque, inertia in pairs]
        return found

    def unit_inertias(self) -> list[Scalar]:
        """The inertia for each parameter set to 1 alone."""
        return [inertia for x in self.laws for inertia in x.law.inertias(x.p)]

    def unit_energies(self, q: Vector) -> list[Scalar]:
        """The stored energy for each parameter set to 1 alone."""
        (position,) = self.at.position(q)
        return [energy for x in self.laws for energy in x.law.energies(x.p, position)]

    # ------------------------------------------------------------
    def drag(self, q: Vector, qd: Vector) -> Scalar:
        """The torque per unit of the sign of the rate: the strength of dry friction at a state."""
        (position,), (rate,) = self.at.position(q), self.at.rates(qd)
        signs = replace(self, sign=lambda law, rate: Dual(0.0, {0: 1.0}))
        return slopes(signs._torque(position, rate, rate), 1)[0]

    def only(self, keeps: Callable[[DriveLaw], bool]) -> DriveScalars:
        """The drive with some of its laws."""
        return replace(self, laws=tuple(x for x in self.laws if keeps(x.law)))

    def _torque(self, position: Scalar, rate: Scalar, signed: Scalar) -> Scalar:
        """The torque of all laws at a position and rate; signed: the rate whose sign the laws
        take."""
        return _sum(
            x.law.torque(x.p, position, rate, self.sign(x.law, signed) if x.law.signed else 0.0)
            for x in self.laws
            if x.law.torque is not None
        )


def inertia_of(laws: Sequence[ActingLaw]) -> Scalar:
    """The inertia that laws add to their joint, the factor of its acceleration."""
    return _sum(x.law.inertia(x.p) for x in laws if x.law.inertia is not None)


def _sum(terms: Iterable[Scalar]) -> Scalar:
    total: Scalar = None
    for term in terms:
        total = term if total is None else total + term
    return 0.0 if total is None else total


def every_law(
    read: Callable[[str], Scalar], among: Iterable[DriveLaw] = tuple(LAWS.values())
) -> tuple[ActingLaw, ...]:
    """The usual laws and all others that act, with scalars made of numbers that `read` gives by
    name."""
    return tuple(
        [
            ActingLaw(law, law.scalars_of(read))
            for law in among
            if law.usual or _acts(read(law.strength))
        ]
    )


def counted(laws: Sequence[ActingLaw]) -> tuple[ActingLaw, ...]:
    """The laws that take part: those that act (in a family, on some member), and the usual ones
    where any acts; none otherwise."""
    acting = [_acts(x.p[0]) for x in laws]
    if True not in acting:
        return ()
    return tuple(x for x, acts in zip(laws, acting, strict=True) if acts or x.law.usual)


def _acts(strength: Scalar) -> bool:
    if isinstance(strength, float):  # most are
        return strength != 0.0
    return not isinstance(strength, np.ndarray) or bool(strength.any())


def of_names(names: Sequence[str], scalars: Sequence[Scalar]) -> tuple[ActingLaw, ...]:
    """Acting laws by name, from their scalars in a row."""
    rest = iter(scalars)
    laws = [LAWS[name] for name in names]
    return tuple(ActingLaw(law, tuple(islice(rest, law.size))) for law in laws)


def size_of(names: Sequence[str]) -> int:
    """The number of scalars of these laws."""
    return sum(LAWS[name].size for name in names)
