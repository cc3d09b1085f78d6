"""Motion and force vectors of one column, angular part first, for the algorithms that are shortest
that way."""

from __future__ import annotations

from freebody.algorithms.crba import Composite
from freebody.algorithms.kinematics import Column, Pose
from freebody.model.tree import TreeBody
from freebody.spatial import AnySpace, Matrix, Vector, identity, product, scale, transposed


def size_angular(space: AnySpace) -> int:
    """Number of angular entries."""
    return len(space.zero_angular)


def parts(space: AnySpace, column: Vector) -> Column:
    """(angular, linear) part of a column."""
    a = size_angular(space)
    return column[:a], column[a:]


def columns(body: TreeBody) -> tuple[Vector, ...]:
    """Motion columns of a joint."""
    return tuple(w + v for w, v in body.columns)


def transform(space: AnySpace, pose: Pose) -> Matrix:
    """X that takes motions of the parent to motions of the child at (R, p): ω' = Rᵀ ω, v' = Rᵀ (v +
    ω × p)."""
    R, p = pose
    E = transposed(R)
    a = size_angular(space)
    turn = transposed(tuple(space.turn(E, unit) for unit in identity(a)))
    moved = product(E, transposed(tuple(space.cross(unit, p) for unit in identity(a))))
    top = tuple(row + (0.0,) * space.dim for row in turn)
    return top + tuple(m + e for m, e in zip(moved, E, strict=True))


def inertia_matrix(space: AnySpace, composite: Composite) -> Matrix:
    """The 6×6 (plane: 3×3) inertia about the origin."""
    m, h, inertia = composite
    hx = space.skew(h)
    top = tuple(i + row for i, row in zip(space.inertia_matrix(inertia), hx, strict=True))
    bottom = tuple(
        row + scale(m, unit) for row, unit in zip(transposed(hx), identity(space.dim), strict=True)
    )
    return top + bottom
