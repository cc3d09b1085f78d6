"""Flexible joints: between the motor's rotor and the link a shaft that twists (Spong 1987). The
rotor's angle, seen behind its gear, is the coordinate of the joint; the twist of the shaft is that
of a passive joint behind it, with a spring and a damper, about the same axis. The link's angle is
their sum. The rotor has its inertia about that axis alone, as everywhere in freebody.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.errors import ModelError, UnknownNameError
from freebody.model.bodies import Body, Frame
from freebody.model.changes import with_symbols_known
from freebody.model.description import Drive, Joint, Limits, Link
from freebody.model.families import Members, is_array, members, one_family
from freebody.model.parameters import LARGEST, Parameter, Quantity, quantity
from freebody.model.placement import Placement, rotate, shift
from freebody.model.quantity_reader import VALUES
from freebody.spatial import of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model


_NEAR = 1e-9
"""Distance (m) or difference of directions of two lines that are one."""
_TRACE = 1e-6
"""Share of a robot's mass that a rotor's link has where a format knows none without mass."""


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
    if (least := _least(shaft.stiffness)) <= 0.0:
        return f"the stiffness of its shaft is {least:g}; give a number above 0"
    if (least := _least(shaft.viscous)) < 0.0:
        return f"the damping of its shaft is {least:g}; give it as 0 or more"
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


def _least(number: Quantity) -> float:
    """The least value of a quantity among the members of a family; infinite where it has none."""
    known = number.value if isinstance(number, Parameter) else number
    if known is None:
        return math.inf
    return float(known.array.min()) if isinstance(known, Members) else known


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


def with_rigid_joints(model: Model) -> tuple[Model, dict[int, Body]]:
    """The model with shafts that do not twist, and the shaft of each body of it that has one: a
    body whose joint goes on along the axis of the joint above, with nothing between."""
    shafts = {k for k in range(len(model.bodies)) if _is_shaft(model, k)}
    if not shafts:
        return model, {}
    above = {model.bodies[k].parent for k in shafts}
    kept = [k for k in range(len(model.bodies)) if k not in above]
    index = {-1: -1} | {k: i for i, k in enumerate(kept)}
    index |= {model.bodies[k].parent: index[k] for k in shafts}
    bodies = []
    for k in kept:
        body = model.bodies[k]
        if k in shafts:
            rotor = model.bodies[body.parent]
            placement = rotor.joint.placement.then(body.joint.placement)
            axis, child = body.joint.axis, body.joint.child
            joint = replace(rotor.joint, placement=placement, axis=axis, child=child)
            body = replace(body, joint=joint, parent=rotor.parent)
        bodies.append(replace(body, parent=index[body.parent]))
    behind = {model.bodies[k].parent: model.bodies[k].joint.placement for k in shafts}
    frames = []
    for frame in model.frames:
        if frame.body in behind and behind[frame.body].steps:
            R, p = _pose(behind[frame.body], model.dim)
            back = rotate(R.T, frame.name).then(shift(*(-p).tolist()))
            frame = replace(frame, placement=back.then(frame.placement))
        frames.append(replace(frame, body=index[frame.body]))
    rigid = replace(model, bodies=tuple(bodies), frames=tuple(frames), home=())
    return rigid, {index[k]: model.bodies[k] for k in shafts}


def _is_shaft(model: Model, k: int) -> bool:
    """Whether a body's joint goes on along the joint above, from a link without mass."""
    body = model.bodies[k]
    if body.parent < 0 or body.kind.nv != 1 or body.joint.mimic is not None:
        return False
    rotor = model.bodies[body.parent]
    mass = sum(part.inertia.numbers()[0] for part in rotor.inertias)
    return (
        body.kind.motion is rotor.kind.motion
        and body.joint.numbers == rotor.joint.numbers
        and mass <= _TRACE * model.mass
        and sum(other.parent == body.parent for other in model.bodies) == 1
        and _goes_on(rotor, body, model.dim)
    )


def _goes_on(rotor: Body, body: Body, dim: int) -> bool:
    """Whether the axes of two joints in a row are one line; those of slides are parallel."""
    R, p = _pose(body.joint.placement, dim)
    if not body.joint.axis:
        return not p.any()
    one, two, aside = np.array(rotor.joint.axis), np.array(body.joint.axis), p
    if len(two) == dim:  # else it is normal to the plane
        two, aside = R @ two, p - one * (one @ p)
    if body.kind.slides:
        aside = np.zeros(dim)
    return max(abs(one - two).max(), abs(aside).max()) <= _NEAR


def _pose(placement: Placement, dim: int) -> tuple[np.ndarray, np.ndarray]:
    R, p = placement.lower(of_dimension(dim), VALUES)
    return np.array(R, dtype=float), np.array(p, dtype=float)
