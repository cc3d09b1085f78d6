"""Coulomb friction: c sign(q̇), at rest whatever holds, up to c."""

from __future__ import annotations

from freebody.model.drives.law import DriveLaw, LawNumber, at_least_zero

LAW = DriveLaw(
    "coulomb",
    "friction",
    "friction",
    "dry friction",
    (
        LawNumber(
            "coulomb",
            "friction.coulomb",
            "{effort}",
            "Coulomb friction",
            refused=at_least_zero("Coulomb friction"),
        ),
    ),
    torque=lambda p, position, rate, s: p[0] * s,
    signed=True,
    power=0,
    usual=True,
    assumed_by=("identify", "excitation"),
)
