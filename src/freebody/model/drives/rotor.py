"""Rotor with gear: inertia J before a gear of ratio n, which the joint feels as J n²."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from freebody.elementary import Scalar
from freebody.model.drives.law import DriveLaw, LawNumber, LinearForm, at_least_zero, quotient
from freebody.spatial import Vector


def _reflected(rotor: Scalar, gear: Scalar) -> Vector:
    return (0.0 if isinstance(rotor, float) and rotor == 0.0 else rotor * gear * gear,)


def _numbers(entries: Sequence[Any], now: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """The rotor's inertia from the reflected one; the gear ratio stays."""
    (reflected,), gear = entries, np.asarray(now["gear"])
    what = "a reflected rotor inertia behind a gear of ratio 0"
    return {"rotor": quotient(reflected, gear * gear, 0.0, what, owner)}


LAW = DriveLaw(
    "rotor",
    "rotors",
    "rotor",
    "rotor inertia",
    (
        LawNumber(
            "rotor",
            "rotor.inertia",
            "{inertia}",
            "rotor inertia before the gear",
            "rotor inertia",
            refused=at_least_zero("rotor inertia"),
            needed=True,
        ),
        LawNumber(
            "gear",
            "rotor.gear",
            "1",
            "gear ratio of the rotor",
            "gear ratio",
            default=1.0,
            refused=lambda x: (
                "gear is 0; give the ratio of motor speed to joint speed, below 0 where they turn "
                "in opposite directions, 1 without a gear"
                if x == 0.0
                else None
            ),
            strict=True,
            waits=True,
        ),
    ),
    inertia=lambda p: p[0],
    scalars=_reflected,
    form=LinearForm(
        ("rotor",),
        values=lambda p: p,
        torques=lambda p, position, rate, s: (0.0,),
        energies=lambda p, position: (0.0,),
        numbers=_numbers,
    ),
    usual=True,
)
