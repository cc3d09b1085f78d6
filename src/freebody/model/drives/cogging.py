"""Cogging: a sin(n q - phase), by which the magnets of a motor hold its rotor at n places in a turn
of the joint: the motor's number times the gear ratio. It stores energy and gives it back, as
springs do, and acts on the motor's side of the gear."""

from __future__ import annotations

import math

from freebody.elementary import Scalar, cos, sin
from freebody.model.drives.law import DriveLaw, LawNumber, above_zero
from freebody.spatial import Vector


def _torque(p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Scalar:
    return p[0] * sin(p[1] * position - p[2])


def _energy(p: Vector, position: Scalar) -> Scalar:
    """The energy of cogging, 0 where the rotor rests."""
    return p[0] * p[3] * (1.0 - cos(p[1] * position - p[2]))


def _recounted(numbers: Vector, flip: float, offset: float) -> Vector:
    """The numbers of cogging for a joint at flip times its position plus offset, with an amplitude
    of 0 or more; a negative one is a shift by half a cog."""
    amplitude, count, phase = numbers
    half = math.pi if amplitude < 0.0 else 0.0
    return abs(amplitude), count, flip * (phase + half) + count * offset


LAW = DriveLaw(
    "cogging",
    "springs",
    "cogging torque",
    "cogging torque",
    (
        LawNumber(
            "cogging",
            "cogging.amplitude",
            "{effort}",
            "amplitude of the cogging torque",
            needed=True,
        ),
        LawNumber(
            "cogging_count",
            "cogging.count",
            "{waves}",
            "number of cogs in a turn",
            refused=above_zero("cogging_count"),
            strict=True,
            needed=True,
        ),
        LawNumber(
            "cogging_phase",
            "cogging.phase",
            "rad",
            "phase of the cogging torque",
            period=2.0 * math.pi,
        ),
    ),
    torque=_torque,
    energy=_energy,
    stored="that of a cogging torque is its amplitude over the number of cogs in a turn, times "
    "1 less the cosine of the angle whose sine it has",
    scalars=lambda amplitude, count, phase: (amplitude, count, phase, 1.0 / count),
    recounted=_recounted,
    waves=lambda p: p[1],
)
