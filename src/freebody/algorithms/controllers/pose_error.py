"""The error of a frame's pose, which several control laws share."""

from __future__ import annotations

from freebody.algorithms.kinematics import frame_pose_at
from freebody.elementary import atan2, sqrt
from freebody.model.tree import Tree
from freebody.spatial import AnySpace, Matrix, Vector, product, scale, sub, transposed

_TINY = 1e-30


def pose_error(tree: Tree, q: Vector, frame: str, wanted: Matrix) -> Vector:
    """The error of a frame's pose against the wanted one (a homogeneous matrix): what the origin
    lacks, then the rotation vector, world axes."""
    R, p = frame_pose_at(tree, q, frame)
    rotation, origin = parted(tree.space, wanted)
    return (*sub(origin, p), *rotation_vector(tree.space, product(rotation, transposed(R))))


def parted(space: AnySpace, pose: Matrix) -> tuple[Matrix, Vector]:
    """Rotation and origin of a homogeneous matrix."""
    rows = pose[: space.dim]
    return tuple(row[: space.dim] for row in rows), tuple(row[space.dim] for row in rows)


def rotation_vector(space: AnySpace, R: Matrix) -> Vector:
    """Axis times angle, of length at most π; one number in the plane."""
    if space.dim == 2:
        return (atan2(R[1][0], R[0][0]),)
    sines = (
        0.5 * (R[2][1] - R[1][2]),
        0.5 * (R[0][2] - R[2][0]),
        0.5 * (R[1][0] - R[0][1]),
    )
    cosine = 0.5 * (R[0][0] + R[1][1] + R[2][2] - 1.0)
    x, y, z = sines
    sine = sqrt(x * x + y * y + z * z + _TINY)
    return scale(atan2(sine, cosine) / sine, sines)
