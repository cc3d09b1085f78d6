"""Dynamics seen from a frame (Khatib 1987) and from the centre of mass (Orin, Goswami, Lee
2013)."""

from __future__ import annotations

import operator
from functools import reduce
from typing import Any

from freebody.algorithms.crba import bias, composites, crba, factor, momentum_of, substitute
from freebody.algorithms.kinematics import (
    centre_of_mass,
    frame_motion,
    jacobian,
    joint_poses,
    outward,
    world_poses,
)
from freebody.algorithms.singular_thresholds import SURELY_INDEPENDENT
from freebody.elementary import Scalar, less, maximum, minimum, sqrt, where
from freebody.model.tree import Tree
from freebody.spatial import (
    Matrix,
    Vector,
    add,
    dot,
    identity,
    scale,
    sub,
    symmetric,
    times,
    transposed,
)


def mass_matrix_inverse(tree: Tree, q: Vector) -> Matrix:
    """Inverse M⁻¹ of the mass matrix, nv × nv."""
    factored = factor(tree, crba(tree, q))
    columns = [substitute(tree, factored, unit) for unit in identity(tree.nv)]
    return symmetric(tree.nv, lambda i, j: columns[j][i])


def operational_space(
    tree: Tree, q: Vector, qd: Vector | None, frame: str, rows: tuple[int, ...]
) -> tuple[Matrix, Vector]:
    """(Λ, μ) of the chosen rows of a frame's motion: Λ ẍ + μ is the wrench that moves the arm,
    friction and gravity in μ.

    Λ = (J M⁻¹ Jᵀ)⁻¹, μ = Λ (J M⁻¹ bias - J̇ q̇); μ is empty without q̇. The rows of J must be
    independent.
    """
    J = tuple(jacobian(tree, q, frame)[r] for r in rows)
    factored = factor(tree, crba(tree, q))
    solved = [substitute(tree, factored, row) for row in J]
    mobility = symmetric(len(rows), lambda i, j: dot(J[i], solved[j]))
    inertia = inverse_of_symmetric(mobility)
    if qd is None:
        return inertia, ()
    torque = bias(tree, q, qd)
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    _, (wd, vd) = frame_motion(tree, motion, frame)
    drift = vd + wd
    rest = tuple(dot(solved[i], torque) - drift[r] for i, r in enumerate(rows))
    return inertia, times(inertia, rest)


def where_sure(
    tree: Tree, q: Vector, frame: str, rows: tuple[int, ...], values: Vector | Matrix
) -> Any:
    """Values that need independent rows of a frame's Jacobian; NaN where these are not surely
    independent."""
    J = tuple(jacobian(tree, q, frame)[r] for r in rows)
    return nan_unless(surely_independent(J), q, tuple(values))


def nan_unless(sure: Scalar, q: Vector, values: Vector | Matrix) -> Any:
    """Values where `sure` is 1, else NaN, which is no constant of a program: q is in it, where the
    rest may be the same for all positions."""
    none = sqrt(sure - 0.5 + minimum(q[0] * q[0], 0.0))

    def shown(x: Any) -> Any:
        return tuple(map(shown, x)) if isinstance(x, tuple) else where(less(0.0, none), x, none)

    return shown(values)


_NO_PIVOT = 1e-300
"""Number that stands in the place of a pivot that is 0, perhaps for all positions."""
_NO_ROWS = 1e-280
"""Squares of the entries of rows that are all 0, added up."""


def surely_independent(J: Matrix) -> Scalar:
    """1 where the smallest singular value of J is surely above the fraction `SURELY_INDEPENDENT` of
    the largest, else 0.

    The traces of J Jᵀ and of its inverse are their largest eigenvalues at least, and n times these
    at most.
    """
    n = len(J)
    gram = symmetric(n, lambda i, j: dot(J[i], J[j]))
    L, _, inverse = factors(gram)
    size = reduce(operator.add, (gram[k][k] for k in range(n)))
    spread = reduce(
        operator.add,
        (each * dot(row, row) for each, row in zip(inverse, _inverse_of_lower(L), strict=True)),
    )
    return less(_NO_ROWS, size) * less(SURELY_INDEPENDENT**2 * (size * spread), 1.0)


def factors(A: Matrix) -> tuple[list[list[Scalar]], list[Scalar], list[Scalar]]:
    """Factors (L, D, D⁻¹) of a symmetric matrix, without pivoting."""
    n = len(A)
    L: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    pivots: list[Scalar] = []
    inverse: list[Scalar] = []
    for j in range(n):
        column = [A[i][j] for i in range(n)]
        for k in range(j):
            for i in range(j, n):
                column[i] = column[i] - L[i][k] * (L[j][k] * pivots[k])
        pivots.append(column[j])
        inverse.append(1.0 / maximum(column[j], _NO_PIVOT))
        for i in range(j, n):
            L[i][j] = 1.0 if i == j else column[i] * inverse[j]
    return L, pivots, inverse


def inverse_of_symmetric(A: Matrix) -> Matrix:
    """A⁻¹ of a positive definite matrix, by LDLᵀ without pivoting."""
    n, (L, _, inverse) = len(A), factors(A)
    rows = _inverse_of_lower(L)  # A⁻¹ = L⁻ᵀ D⁻¹ L⁻¹
    return symmetric(
        n,
        lambda i, j: reduce(
            operator.add, (rows[k][i] * inverse[k] * rows[k][j] for k in range(j, n))
        ),
    )


def _inverse_of_lower(L: list[list[Scalar]]) -> Matrix:
    """L⁻¹ of a lower triangle with ones on its diagonal."""
    n = len(L)
    rows: list[list[Scalar]] = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    for i in range(n):
        for k in range(i):
            for j in range(k + 1):
                rows[i][j] = rows[i][j] - L[i][k] * rows[k][j]
    return tuple(map(tuple, rows))


def centroidal_momentum_matrix(tree: Tree, q: Vector) -> Matrix:
    """A with A q̇ = momentum about the centre of mass of what moves: rows linear, then angular,
    world axes."""
    space = tree.space
    joints = joint_poses(tree, q)
    poses = world_poses(tree, joints)
    gathered = composites(tree, joints)
    centre = centre_of_mass(tree, q, base=False)
    columns: list[Vector] = [(0.0,) * space.six for _ in range(tree.nv)]
    for body, composite, (R, p) in zip(tree.bodies, gathered, poses, strict=True):
        at = body.coordinates
        for column, k in zip(body.columns, at.v, strict=True):
            angular, linear = momentum_of(space, composite, column)
            force = times(R, linear)
            about = add(space.turn(R, angular), space.moment(sub(p, centre), force))
            columns[k] = add(columns[k], scale(at.slope(q), force + about))
    return transposed(tuple(columns), space.six)
