"""Which entries of q and q̇ move a joint, and how: as they are, or, where the joint follows another,
by a polynomial of that one's coordinate.

With p(q) the position of the joint, its rate is p' q̇ and its acceleration p' q̈ + p" q̇²; of a
torque at the joint the coordinate feels p' times that (d'Alembert). Of a linear follower p' is its
ratio, a constant, and p" is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from freebody.elementary import Scalar
from freebody.spatial import Vector


@dataclass(frozen=True)
class Coordinates:
    """The entries of q and q̇ that move a joint, and how: joint position = ratio · q + offset, and
    of a joint that follows another by a polynomial the terms of q², q³, … besides."""

    q: tuple[int, ...]
    v: tuple[int, ...]
    ratio: float
    offset: float
    powers: tuple[float, ...] = ()
    """Coefficients of q², q³, …; none of a joint whose position is linear in q."""

    def position(self, q: Vector) -> Vector:
        """The joint's own position scalars."""
        if self.powers:
            return (_polynomial((self.offset, self.ratio, *self.powers), q[self.q[0]]),)
        if self.ratio == 1.0 and self.offset == 0.0:
            return tuple(q[k] for k in self.q)
        return tuple(self.ratio * q[k] + self.offset for k in self.q)

    def slope(self, q: Vector) -> Scalar:
        """The joint's rate for each unit of its coordinate's: the ratio, unless that changes with
        the position."""
        if not self.powers:
            return self.ratio
        return _polynomial(_derivative((self.ratio, *self.powers)), q[self.q[0]])

    def slope_rate(self, q: Vector, qd: Vector) -> Scalar:
        """The time derivative of the slope."""
        if not self.powers:
            return 0.0
        second = _derivative(_derivative((self.ratio, *self.powers))[1:])
        return _polynomial(second, q[self.q[0]]) * qd[self.v[0]]

    def rates(self, q: Vector, qd: Vector) -> Vector:
        """The joint's own rates."""
        slope = self.slope(q)
        if _is_one(slope):
            return tuple(qd[k] for k in self.v)
        return tuple(slope * qd[k] for k in self.v)

    def second_rates(self, q: Vector, qd: Vector, qdd: Vector) -> Vector:
        """The joint's own accelerations."""
        along = self.rates(q, qdd)
        if not self.powers:
            return along
        return (along[0] + self.slope_rate(q, qd) * qd[self.v[0]],)

    def felt(self, q: Vector, torque: Scalar) -> Scalar:
        """The torque at the coordinate that a torque at the joint amounts to."""
        slope = self.slope(q)
        return torque if _is_one(slope) else slope * torque


def _is_one(slope: Scalar) -> bool:
    return isinstance(slope, float) and slope == 1.0


def _polynomial(coefficients: Sequence[float], x: Scalar) -> Scalar:
    """c₀ + c₁ x + c₂ x² + …, by Horner's rule."""
    total: Scalar = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * x + c
    return total


def _derivative(coefficients: Sequence[float]) -> tuple[float, ...]:
    """Coefficients of the derivative of c₁ x + c₂ x² + …, from c₁ on."""
    return tuple(k * c for k, c in enumerate(coefficients, start=1))
