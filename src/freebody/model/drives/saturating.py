"""Saturating viscous friction: c q̇ / (1 + |q̇|/v), as of a lubricant that thins where it is sheared
(Williamson 1929; what viscosity remains at high rates is viscous friction besides)."""

from __future__ import annotations

from freebody.elementary import Scalar, absolute
from freebody.model.drives.law import DriveLaw, LawNumber, above_zero, at_least_zero
from freebody.spatial import Vector


def _torque(p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Scalar:
    return p[0] * (rate / (absolute(rate * p[1]) + 1.0))


LAW = DriveLaw(
    "saturating",
    "friction",
    "friction",
    "saturating viscous friction",
    (
        LawNumber(
            "saturating",
            "friction.saturating",
            "{effort} s/{position}",
            "saturating viscous friction at low rates",
            refused=at_least_zero("saturating viscous friction"),
            needed=True,
        ),
        LawNumber(
            "saturating_speed",
            "friction.saturating_speed",
            "{position}/s",
            "speed at which saturating viscous friction is half as viscous",
            refused=above_zero("saturating_speed"),
            strict=True,
            needed=True,
        ),
    ),
    torque=_torque,
    scalars=lambda coefficient, speed: (coefficient, 1.0 / speed),
)
