"""What a bearing or a guide carries, apart from what the drive gives: reactions in the axes of
their joint.

About (along) the axis of a joint the parent exerts on the child what the drive gives, less what
friction, spring and rotor take; all else is carried by the bearing, or the guide.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model

LOADS = {
    "axial_force": ("N", "force along the axis of a turning joint, on the child"),
    "radial_force": ("N", "force across the axis of the joint"),
    "tilting_moment": ("N m", "moment across the axis of the joint, about its origin"),
    "guide_moment": ("N m", "moment about the axis of a sliding joint, carried by its guide"),
    "drive_load": (
        "N m|N",
        "moment about the axis of a turning joint, force along that of a sliding one: the drive's",
    ),
}
"""Unit and meaning; of joints without one axis, and where a plane has no such load, NaN."""


def bearing_loads(model: Model, force: Array, moment: Array) -> dict[str, Any]:
    """Variables (time, joint) from the reactions in the child's axes, (T, joints, dim) and (T,
    joints, 3 or 1)."""
    found = {name: np.full(force.shape[:2], np.nan) for name in LOADS}
    for k, body in enumerate(model.bodies):
        if body.kind.turns and model.dim == 2:
            parts = {
                "radial_force": _size(force[:, k]),
                "drive_load": body.joint.axis[0] * moment[:, k, 0],
            }
        elif body.kind.turns:
            axial, radial = _split(force[:, k], body.joint.axis)
            driving, tilting = _split(moment[:, k], body.joint.axis)
            parts = {
                "axial_force": axial,
                "radial_force": radial,
                "tilting_moment": tilting,
                "drive_load": driving,
            }
        elif body.kind.slides:
            driving, radial = _split(force[:, k], body.joint.axis)
            parts = {"radial_force": radial, "drive_load": driving}
            if model.dim == 2:
                parts["tilting_moment"] = np.abs(moment[:, k, 0])
            else:
                parts["guide_moment"], parts["tilting_moment"] = _split(
                    moment[:, k], body.joint.axis
                )
        else:
            continue
        for name, value in parts.items():
            found[name][:, k] = value
    return {name: (("time", "joint"), found[name], *LOADS[name]) for name in LOADS}


def _split(vectors: Array, axis: tuple[float, ...]) -> tuple[Array, Array]:
    """Component along the axis, with its sign, and the size of what is across it."""
    n = np.asarray(axis)
    along = vectors @ n
    return along, _size(vectors - along[:, None] * n)


def _size(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)
