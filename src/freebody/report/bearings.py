"""What a bearing or a guide carries, apart from what the drive gives: reactions in the axes of
their joint.

About (along) the axis of a joint the parent exerts on the child what the drive gives, less what
friction, spring and rotor take; all else is carried by the bearing, or the guide.
"""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.model.bodies import Body
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.report.variables import LOADS
from freebody.spatial import of_dimension


def bearing_loads(model: Model, force: Array, moment: Array) -> dict[str, Array]:
    """Variables (time, joint) from the reactions in the child's axes, (T, joints, dim) and (T,
    joints, 3 or 1)."""
    found = {name: np.full(force.shape[:2], np.nan) for name in LOADS}
    for k, body in enumerate(model.bodies):
        if body.kind.needs_axis:
            for name, value in _along_axis(body, force[:, k], moment[:, k]).items():
                found[name][:, k] = value
    return found


def _along_axis(body: Body, force: Array, moment: Array) -> dict[str, Array]:
    """Of a joint with an axis, whose drive is what the reactions do along its motion; force (T,
    dim), moment (T, 3 or 1)."""
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


def _split(vectors: Array, axis: tuple[float, ...]) -> tuple[Array, Array]:
    """Component along the axis, with its sign, and the size of what is across it."""
    n = np.asarray(axis)
    along = vectors @ n
    return along, _size(vectors - along[:, None] * n)


def _size(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)
