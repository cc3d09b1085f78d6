"""Spring: k (q - rest); one that pushes away from its rest position has a stiffness below 0, as one
that balances a weight does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from freebody.elementary import Scalar
from freebody.model.drives.law import DriveLaw, LawNumber, LinearForm, resting_elsewhere
from freebody.model.drives.quotients import quotient
from freebody.spatial import Vector


def _energy(p: Vector, position: Scalar) -> Scalar:
    stretch = position - p[1]
    return 0.5 * p[0] * (stretch * stretch)


def _numbers(entries: Sequence[Any], now: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """The stiffness and rest position from the parameters; without stiffness the rest position
    stays."""
    stiffness, moment = entries
    what = "stiffness_rest without stiffness"
    return {
        "stiffness": stiffness,
        "rest": quotient(moment, stiffness, now["rest"], what, owner),
    }


LAW = DriveLaw(
    "spring",
    "springs",
    "spring",
    "spring",
    (
        LawNumber(
            "stiffness",
            "spring.stiffness",
            "{effort}/{position}",
            "spring stiffness",
            "stiffness of the spring",
            needed=True,
        ),
        LawNumber("rest", "spring.rest", "{position}", "rest position of the spring"),
    ),
    torque=lambda p, position, rate, s: p[0] * (position - p[1]),
    energy=_energy,
    stored="that of a spring is half its stiffness times the square of its deflection",
    recounted=resting_elsewhere,
    at_joint=True,
    form=LinearForm(
        ("stiffness", "stiffness_rest"),
        values=lambda p: (p[0], p[0] * p[1]),
        torques=lambda p, position, rate, s: (position, -1.0),
        energies=lambda p, position: (0.5 * (position * position), -position),
        numbers=_numbers,
    ),
    usual=True,
)
