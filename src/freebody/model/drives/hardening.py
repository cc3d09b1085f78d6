"""Hardening spring: h (q - rest)³; with a linear spring it makes one that becomes stiffer as it is
stretched, or softer where h is below 0."""

from __future__ import annotations

from freebody.elementary import Scalar
from freebody.model.drives.law import DriveLaw, LawNumber, resting_elsewhere
from freebody.spatial import Vector


def _torque(p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Scalar:
    stretch = position - p[1]
    return p[0] * (stretch * (stretch * stretch))


def _energy(p: Vector, position: Scalar) -> Scalar:
    square = (position - p[1]) * (position - p[1])
    return 0.25 * p[0] * (square * square)


LAW = DriveLaw(
    "hardening",
    "springs",
    "spring",
    "hardening spring",
    (
        LawNumber(
            "hardening",
            "spring.hardening",
            "{effort}/{position}³",
            "hardening of the spring",
            needed=True,
        ),
        LawNumber(
            "hardening_rest",
            "spring.hardening_rest",
            "{position}",
            "rest position of the hardening spring",
        ),
    ),
    torque=_torque,
    energy=_energy,
    stored="that of a hardening spring is a quarter of its hardening times the fourth power of its "
    "deflection",
    recounted=resting_elsewhere,
    at_joint=True,
)
