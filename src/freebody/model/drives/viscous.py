"""Viscous friction, a torque d q̇ against the motion."""

from __future__ import annotations

from freebody.model.drives.law import DriveLaw, LawNumber, at_least_zero

LAW = DriveLaw(
    "viscous",
    "friction",
    "friction",
    "viscous friction",
    (
        LawNumber(
            "viscous",
            "friction.viscous",
            "{effort} s/{position}",
            "viscous friction",
            refused=at_least_zero("viscous friction"),
        ),
    ),
    torque=lambda p, position, rate, s: p[0] * rate,
    power=1,
    usual=True,
    assumed_by=("identify", "excitation"),
)
