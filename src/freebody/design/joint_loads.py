"""Loads of a joint's bearing, guide and drive: reactions over motions, as far as rigid bodies
determine them, split along and across its axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from freebody.any_chain.dynamics import joint_wrenches
from freebody.any_chain.reactions import reactions
from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.bodies import Body
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.spatial import of_dimension


def known_wrenches(
    model: Model, q: Array, qd: Array, qdd: Array, wrenches: Any, axes: Literal["world", "child"]
) -> Array:
    """Wrenches (T, joints and loops, 6 or 3) as of `joint_wrenches`, NaN where a closed chain is
    held more than once, so that what its parts share is not determined."""
    if not model.loops:
        return joint_wrenches(model, q, qd, qdd, wrenches, axes)
    found = reactions(model, q, qd, qdd=qdd, wrenches=wrenches, reference=axes)
    return np.where(found.determined, found.wrenches, np.nan)


def undetermined(places: Sequence[str]) -> tuple[str, ...]:
    """The sentence on joints whose loads are not all determined; none where there is no such."""
    if not places:
        return ()
    return (
        f"nan at {listed(map(repr, places), 8)}: the mechanism is held more than once there, so "
        f"that its parts share a load as they yield, which rigid bodies do not tell.",
    )


JOINT_LOADS = {
    "axial_force": ("N", "force along the axis of a revolute joint, on the child"),
    "radial_force": ("N", "force across the axis of the joint"),
    "tilting_moment": ("N m", "moment across the axis of the joint, about its origin"),
    "guide_moment": ("N m", "moment about the axis of a prismatic joint, carried by its guide"),
    "drive_load": (
        "N m|N",
        "moment about the axis of a revolute joint (of a helical one plus pitch times the force "
        "along it), force along the axis of a prismatic one: what the drive supplies, less what "
        "friction, spring and rotor take",
    ),
}
"""Unit and meaning of what a bearing or guide and its drive carry; of joints without one axis, and
where a plane has no such load, NaN."""


def joint_loads(model: Model, force: Array, moment: Array) -> dict[str, Array]:
    """Variables (time, joint) from the reactions in the child's axes, (T, joints, dim) and (T,
    joints, 3 or 1)."""
    found = {name: np.full(force.shape[:2], np.nan) for name in JOINT_LOADS}
    for k, body in enumerate(model.bodies):
        if body.kind.needs_axis:
            for name, value in _along_axis(body, force[:, k], moment[:, k]).items():
                found[name][:, k] = value
    return found


def _along_axis(body: Body, force: Array, moment: Array) -> dict[str, Array]:
    """The loads of a joint with an axis, whose drive is what the reactions do along its motion;
    force (T, dim), moment (T, 3 or 1)."""
    joint, motion, dim = body.joint, body.kind.motion, force.shape[-1]
    parts: dict[str, Array] = {}
    turning, sliding = motion is None or motion.turns, motion is None or motion.slides
    if len(joint.axis) == dim:
        axial, parts["radial_force"] = _split(force, joint.axis)
        if not sliding or (turning and motion is not None):
            parts["axial_force"] = axial
    else:
        parts["radial_force"] = _size(force)
    if dim == 3:
        about, parts["tilting_moment"] = _split(moment, joint.axis)
        if not turning:
            parts["guide_moment"] = about
    elif not turning:
        parts["tilting_moment"] = np.abs(moment[:, 0])
    if motion is not None:
        numbers = tuple(map(VALUES.quantity, joint.numbers))
        ((primitive, axis),) = body.kind.primitives(of_dimension(dim), joint.axis, numbers)
        ((w, v),) = primitive.columns(of_dimension(dim), axis)
        parts["drive_load"] = moment @ np.asarray(w) + force @ np.asarray(v)
    return parts


def bearing_vectors(body: Body, force: Array, moment: Array) -> tuple[Array, Array, Array]:
    """The loads of the bearing of a joint that turns about one axis, from reactions (T, dim) and
    (T, 3 or 1) in the child's axes: axial force (T, 1), radial force (T, dim), and tilting moment
    (T, 3), 0 in the plane. Linear in the reactions; their sizes are those of `JOINT_LOADS`."""
    if force.shape[-1] == 2:
        nothing = np.zeros((len(force), 3))
        return nothing[:, :1], force, nothing
    axial, radial = _parts(force, body.joint.axis)
    return axial[:, None], radial, _parts(moment, body.joint.axis)[1]


def _split(vectors: Array, axis: tuple[float, ...]) -> tuple[Array, Array]:
    """Component along the axis, with its sign, and the size of what is across it."""
    along, across = _parts(vectors, axis)
    return along, _size(across)


def _parts(vectors: Array, axis: tuple[float, ...]) -> tuple[Array, Array]:
    """Component along the axis, with its sign, and what is across it."""
    n = np.asarray(axis)
    along = vectors @ n
    return along, vectors - along[:, None] * n


def _size(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)
