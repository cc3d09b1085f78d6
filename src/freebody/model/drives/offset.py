"""Offset: a constant torque, as of a motor whose current is not 0 at rest. With dry friction c it
makes that different in the two directions: c + o forward, c - o back."""

from __future__ import annotations

from freebody.model.drives.law import DriveLaw, LawNumber

LAW = DriveLaw(
    "offset",
    "friction",
    "friction",
    "constant torque of the drive",
    (LawNumber("offset", "friction.offset", "{effort}", "constant torque of the drive"),),
    torque=lambda p, position, rate, s: p[0],
    recounted=lambda numbers, flip, offset: (flip * numbers[0],),
    power=0,
    assumed_by=("identify", "excitation"),
)
