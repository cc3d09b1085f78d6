"""Joints that lose a part of the torque that they transmit, one rule for many rooms: which a model
has, where they may be, and the refusal of what does not know them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from freebody.errors import FreebodyError
from freebody.model.drives import DriveLaw

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.model import Model


def lossy_joints(bodies: Sequence[Body]) -> dict[str, DriveLaw]:
    """The first law of losses, by the name of each joint that loses a part of what it transmits."""
    found: dict[str, DriveLaw] = {}
    for body in bodies:
        for law in body.joint.drive.listed_laws:
            if law.losses is not None:
                found.setdefault(body.joint.name, law)
    return found


def loss_fault(bodies: Sequence[Body], loops: Sequence[object]) -> str | None:
    """Why a model cannot have the losses of its joints, or None."""
    joints = lossy_joints(bodies)
    coupled = {
        name for b in bodies if b.joint.mimic for name in (b.joint.name, b.joint.mimic.joint)
    }
    for name, law in joints.items():
        if loops:
            why = "in a closed chain that depends on how its loops share the forces"
        elif name in coupled:
            why = "of joints of which one follows the other that is not determined"
        else:
            continue
        return (
            f"joint {name!r} has {law.term}, which is of the torque that the joint transmits, and "
            f"{why}; leave it out, {_without(name, law)}"
        )
    return None


def require_lossless(function: str, model: Model, why: str = "") -> None:
    """Refuse a model whose joints lose a part of what they transmit, in the name of a function."""
    for name, law in lossy_joints(model.bodies).items():
        raise FreebodyError(
            f"{function}: the {law.term} of joint {name!r} of {model.name!r} makes torques other "
            f"than linear in accelerations, for which this is not available{why}; leave it out, "
            f"model.{_without(name, law)}."
        )


def _without(joint: str, law: DriveLaw) -> str:
    numbers = ", ".join(f"{name}=0" for name in law.off)
    return f"with_drive({joint!r}, {numbers})"
