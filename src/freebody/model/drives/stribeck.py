"""Stribeck friction: besides dry friction that is the same at all speeds, l exp(-(q̇/v)²) sign(q̇),
which is l at rest and gone at a few times the speed v (Armstrong-Hélouvry, Dupont, Canudas de Wit
1994)."""

from __future__ import annotations

from freebody.elementary import Scalar, exp
from freebody.model.drives.law import DriveLaw, LawNumber, above_zero, at_least_zero
from freebody.spatial import Vector


def _torque(p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Scalar:
    part = rate * p[1]
    return p[0] * exp(-(part * part)) * s


LAW = DriveLaw(
    "stribeck",
    "friction",
    "friction",
    "Stribeck friction",
    (
        LawNumber(
            "stribeck",
            "friction.stribeck",
            "{effort}",
            "Stribeck friction at rest",
            refused=at_least_zero("Stribeck friction"),
            needed=True,
        ),
        LawNumber(
            "stribeck_speed",
            "friction.stribeck_speed",
            "{position}/s",
            "speed by which Stribeck friction falls",
            refused=above_zero("stribeck_speed"),
            strict=True,
            needed=True,
        ),
    ),
    torque=_torque,
    scalars=lambda level, speed: (level, 1.0 / speed),
    signed=True,
)
