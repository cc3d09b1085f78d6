"""Friction of grease: d |q̇|^(1/3) sign(q̇), which grows less and less with the rate (Grotjahn,
Daemi, Heimann 2001)."""

from __future__ import annotations

from freebody.elementary import Scalar, absolute, equal, exp, log, where
from freebody.model.drives.law import DriveLaw, LawNumber, at_least_zero
from freebody.spatial import Vector


def _torque(p: Vector, position: Scalar, rate: Scalar, s: Scalar) -> Scalar:
    size, still = absolute(rate), equal(rate, 0.0)
    root = exp(log(where(still, 1.0, size)) * (1.0 / 3.0))
    return p[0] * where(still, 0.0, root) * s


LAW = DriveLaw(
    "cube_root",
    "friction",
    "friction",
    "friction by the cube root of the rate",
    (
        LawNumber(
            "cube_root",
            "friction.cube_root",
            "{effort} (s/{position})^(1/3)",
            "friction by the cube root of the rate",
            refused=at_least_zero("friction by the cube root of the rate"),
        ),
    ),
    torque=_torque,
    signed=True,
    assumed_by=("identify",),
)
