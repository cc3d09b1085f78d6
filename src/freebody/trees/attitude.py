"""Rotation matrices from angles about named axes, and the quaternion of a rotation matrix."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError
from freebody.model.placement import about, rotation_matrix


def rotation(axes: str, angles: Sequence[float] | ArrayLike) -> Array:
    """R_WB (3, 3) of turns about the body's own axes: rotation("ZXZ", [a, b, c]) is Rz(a) Rx(b)
    Rz(c).

    axes: letters X, Y, Z, one per angle (rad). It takes components in the turned frame to those in
    the first (6.8).
    """
    given = as_floats("rotation", "angles", angles)
    if not axes or set(axes.upper()) - set("XYZ") or given.shape != (len(axes),):
        raise FreebodyError(
            f"rotation: axes {axes!r} and {given.size} angles; give one angle for each of the "
            f"letters X, Y, Z."
        )
    R = np.eye(3)
    for axis, angle in zip(axes.lower(), given, strict=True):
        R = R @ np.array(about(axis, np.sin(angle), np.cos(angle)))
    return R


def quat_wxyz(R: ArrayLike) -> Array:
    """The unit quaternion w, x, y, z (w >= 0) of a rotation matrix (3, 3), as spherical and free
    joints take it."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(
        rotation_matrix(as_floats("quat_wxyz", "R", R), "quat_wxyz")
    ).as_quat(canonical=True, scalar_first=True)
