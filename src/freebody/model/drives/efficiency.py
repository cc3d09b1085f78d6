"""Efficiency of a gear by the direction of power: the motor needs tau / η while it drives the
joint, and η' tau while the joint drives the motor."""

from __future__ import annotations

from freebody.elementary import Scalar
from freebody.model.drives.law import NO_PARAMETERS, DriveLaw, LawNumber
from freebody.spatial import Vector


def _forward(efficiency: float) -> str | None:
    if 0.0 < efficiency <= 1.0:
        return None
    return f"efficiency of the gear is {efficiency:g}; give a number above 0, up to 1"


def _back(efficiency: float) -> str | None:
    if 0.0 < efficiency <= 1.0:
        return None
    if efficiency > 1.0:
        return f"back_efficiency of the gear is {efficiency:g}; give a number above 0, up to 1"
    return (
        f"back_efficiency of the gear is {efficiency:g}: a gear that no torque drives from the "
        f"joint's side locks itself, and accelerations do not follow from torques; give a number "
        f"above 0, up to 1, such as 2 - 1/efficiency where the friction is the same both ways"
    )


def _losses(p: Vector) -> tuple[Scalar, Scalar]:
    forward, back = p
    return 1.0 / forward - 1.0, 1.0 - back


LAW = DriveLaw(
    "efficiency",
    "friction",
    "friction",
    "efficiency of the gear",
    (
        LawNumber(
            "efficiency",
            "transmission.efficiency",
            "1",
            "efficiency of the gear, the motor driving",
            refused=_forward,
            strict=True,
            needed=True,
            below=1.0,
        ),
        LawNumber(
            "back_efficiency",
            "transmission.back_efficiency",
            "1",
            "efficiency of the gear, the joint driving",
            refused=_back,
            strict=True,
            needed=True,
            below=1.0,
        ),
    ),
    losses=_losses,
    form=NO_PARAMETERS,
)
