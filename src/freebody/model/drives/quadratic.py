"""Quadratic friction: d q̇ |q̇|, as of a body in a fluid."""

from __future__ import annotations

from freebody.elementary import absolute
from freebody.model.drives.law import DriveLaw, LawNumber, at_least_zero

LAW = DriveLaw(
    "quadratic",
    "friction",
    "friction",
    "quadratic friction",
    (
        LawNumber(
            "quadratic",
            "friction.quadratic",
            "{effort} s²/{position}²",
            "quadratic friction",
            refused=at_least_zero("quadratic friction"),
        ),
    ),
    torque=lambda p, position, rate, s: p[0] * (rate * absolute(rate)),
    assumed_by=("identify",),
)
