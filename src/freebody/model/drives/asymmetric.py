"""Asymmetric viscous friction: d |q̇|, by which viscous friction is greater forward and smaller
back."""

from __future__ import annotations

from freebody.elementary import absolute
from freebody.model.drives.law import DriveLaw, LawNumber

LAW = DriveLaw(
    "asymmetric",
    "friction",
    "friction",
    "asymmetric viscous friction",
    (
        LawNumber(
            "asymmetric",
            "friction.asymmetric",
            "{effort} s/{position}",
            "difference of viscous friction by direction",
        ),
    ),
    torque=lambda p, position, rate, s: p[0] * absolute(rate),
    recounted=lambda numbers, flip, offset: (flip * numbers[0],),
)
