"""Aspects of a robot that a doubt may be about, which formulas and results name too; and how rules
say what they find."""

from __future__ import annotations

from typing import NamedTuple

MASSES, LOADS, ROTORS, FRICTION = "masses", "loads", "rotors", "friction"
EFFORTS, SPEEDS, RANGES = "effort limits", "speed limits", "position limits"
INERTIAL = (MASSES, LOADS)
DYNAMIC = (*INERTIAL, ROTORS, FRICTION)
"""All aspects that forces, and motions under forces, depend on."""
LIMITS = (EFFORTS, SPEEDS, RANGES)
ALL = (*DYNAMIC, *LIMITS)
"""All that a doubt may be about."""

NAMES = 4
"""Joints that a sentence names before it counts the others."""


class DoubtedJoints(NamedTuple):
    """A sentence that is about the limits of some joints alone."""

    text: str
    joints: tuple[str, ...]
