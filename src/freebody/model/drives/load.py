"""Load-dependent friction: the part a of the torque that the joint transmits is lost, whichever way
power flows. With Coulomb friction the motor needs tau + (c + a |tau|) sign(q̇) (Hao, Pagani, Beschi,
Legnani 2021)."""

from __future__ import annotations

from freebody.model.drives.law import NO_PARAMETERS, DriveLaw, LawNumber


def _refused(part: float) -> str | None:
    if part < 0.0:
        return f"load-dependent friction {part:g} is negative; give it as 0 or more"
    if part >= 1.0:
        return (
            f"load-dependent friction {part:g} loses all that the joint transmits: the gear locks "
            f"itself, and accelerations do not follow from torques; give a number below 1"
        )
    return None


LAW = DriveLaw(
    "load",
    "friction",
    "friction",
    "load-dependent friction",
    (
        LawNumber(
            "load_friction",
            "friction.load",
            "1",
            "friction by the torque that the joint transmits",
            "load-dependent friction",
            refused=_refused,
            strict=True,
            below=1.0,
        ),
    ),
    losses=lambda p: (p[0], p[0]),
    form=NO_PARAMETERS,
    assumed_by=("identify",),
)
