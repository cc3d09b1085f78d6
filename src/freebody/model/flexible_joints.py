"""Flexible joints: between the motor's rotor and the link a shaft that twists (Spong 1987). The
rotor's angle, seen behind its gear, is the coordinate of the joint; the twist of the shaft is that
of a passive joint behind it, with a spring and a damper, about the same axis. The link's angle is
their sum. The rotor has its inertia about that axis alone, as everywhere in freebody. Which joints
of a model are such shafts, and the robot without them: `model.shafts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from freebody.errors import ModelError, UnknownNameError
from freebody.model.bodies import Body, Frame
from freebody.model.changes import with_symbols_known
from freebody.model.description import Drive, Joint, Limits, Link
from freebody.model.families import is_array, members, one_family
from freebody.model.parameters import LARGEST, Quantity, quantity
from freebody.model.placement import Placement
from freebody.model.shafts import least

if TYPE_CHECKING:
    from freebody.model.model import Model


def split(joint: Joint, stiffness: Quantity, damping: Quantity) -> tuple[Joint, Link, Joint]:
    """(the joint of the rotor, the link behind its gear, which has no mass, the joint that is the
    shaft). Raises ModelError for a joint that cannot be flexible."""
    shaft = Drive(stiffness=stiffness, viscous=damping)
    if fault := _fault(joint, shaft):
        raise ModelError(f"{fault}.")
    link = Link(f"{joint.name}_rotor", line=joint.line)
    twist = replace(
        joint,
        name=f"{joint.name}_twist",
        parent=link.name,
        placement=Placement(),
        limits=Limits(),
        drive=shaft,
        passive=True,
    )
    return replace(joint, child=link.name), link, twist


def _fault(joint: Joint, shaft: Drive) -> str | None:
    """Why a joint cannot be flexible, or None."""
    if (smallest := least(shaft.stiffness)) <= 0.0:
        return f"the stiffness of its shaft is {smallest:g}; give a number above 0"
    if (smallest := least(shaft.viscous)) < 0.0:
        return f"the damping of its shaft is {smallest:g}; give it as 0 or more"
    if joint.mimic is not None:
        return f"it follows {joint.mimic.joint!r}; give a joint that has a motor of its own"
    acting = [x for x in joint.drive.listed_laws if getattr(joint.drive, x.strength) != 0.0]
    if not any(law.inertia is not None for law in acting):
        return (
            "its rotor has no inertia, which is what a motor turns while the shaft twists; give it "
            "rotor and gear"
        )
    for law in acting:
        if law.at_joint:
            return (
                f"its {law.term} acts on the link's angle, which behind a flexible shaft is no "
                f"coordinate; leave it out, {law.strength} = 0"
            )
    return None


def with_flexible_joint(model: Model, name: str, given: Mapping[str, Any]) -> Model:
    """The model with a flexible joint, see `Model.with_flexible_joint`."""
    single = [body.joint.name for body in model.bodies if body.kind.nv == 1]
    if name not in single:
        raise UnknownNameError("one-coordinate joint", name, f"{model.name!r}", single)
    numbers = {
        key: members(x, f"with_flexible_joint: {key}", LARGEST)
        if is_array(x)
        else quantity(x, f"with_flexible_joint: {key}")
        for key, x in given.items()
    }
    followers = [
        b.joint.name for b in model.bodies if b.joint.mimic and b.joint.mimic.joint == name
    ]
    if followers:
        raise ModelError(
            f"with_flexible_joint: joint {followers[0]!r} follows {name!r}, and would follow its "
            f"rotor; make a joint flexible that none follows."
        )
    k = model.joint_names.index(name)
    body = model.bodies[k]
    try:
        rotor, link, twist = split(body.joint, numbers["stiffness"], numbers["damping"])
    except ModelError as error:
        raise ModelError(f"with_flexible_joint: joint {name!r}: {error}") from None
    joints = (*model.joint_names, *(loop.name for loop in model.loops))
    new = ("joint", twist.name, joints), ("frame", link.name, model.frame_names)
    for what, added, known in new:
        if added in known:
            raise ModelError(
                f"with_flexible_joint: {model.name!r} already has a {what} {added!r}; is {name!r} "
                f"flexible already?"
            )

    def behind(i: int) -> int:
        return i + (i >= k)

    bodies = [replace(other, parent=behind(other.parent)) for other in model.bodies]
    bodies[k : k + 1] = [Body(link.name, rotor, body.parent), replace(body, joint=twist, parent=k)]
    frames = [replace(frame, body=behind(frame.body)) for frame in model.frames]
    frames.insert(next(i for i, x in enumerate(frames) if x.body == k + 1), Frame(link.name, k))
    changed = replace(model, bodies=tuple(bodies), frames=tuple(frames))
    result = with_symbols_known(changed, *numbers.values())
    return one_family(result, model, *numbers.values())
