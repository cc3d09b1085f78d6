"""The rates of least norm that move a frame as wanted (2.25), and their accelerations (2.26); the
wrench that torques hold (2.51)."""

from __future__ import annotations

from functools import reduce
from operator import add as plus

from freebody.algorithms.kinematics import ancestors, frame_motion, jacobian, outward
from freebody.algorithms.operational_space import factors, nan_unless, surely_independent
from freebody.elementary import Scalar, sqrt
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, dot, scale, sub, symmetric, times, transposed

_SURE = 1e-6
"""Ratio of singular values above which as many steps of refinement leave rounding alone."""
_STEPS = 2


def inverse_velocity(tree: Tree, q: Vector, frame: str, rows: tuple[int, ...], V: Vector) -> Vector:
    """q̇ of least norm with J q̇ = V; NaN where the rows of J are not surely independent."""
    units, J = _comparable(tree, q, frame, rows)
    wanted = tuple(unit * x for unit, x in zip(units, V, strict=True))
    L, inverse = _factored(J)
    back = transposed(J, tree.nv)
    found = times(back, _solved(L, inverse, wanted))
    for _ in range(_STEPS):
        left = sub(wanted, times(J, found))
        found = add(found, times(back, _solved(L, inverse, left)))
    return nan_unless(surely_independent(J, _SURE), q, found)


def inverse_acceleration(
    tree: Tree, q: Vector, qd: Vector, frame: str, rows: tuple[int, ...], A: Vector
) -> Vector:
    """q̈ of least norm with J q̈ + J̇ q̇ = A; NaN where the rows of J are not surely
    independent."""
    _, (wd, vd) = frame_motion(tree, outward(tree, q, qd, (0.0,) * tree.nv), frame)
    drift = vd + wd
    wanted = tuple(x - drift[row] for x, row in zip(A, rows, strict=True))
    return inverse_velocity(tree, q, frame, rows, wanted)


def tip_wrench(tree: Tree, q: Vector, frame: str, tau: Vector) -> Vector:
    """The wrench f with Jᵀ f = tau of an arm, in as many rows as `wrench_rows` says and 0 in the
    others; NaN where the rows of J are not surely independent."""
    six = tree.space.six
    rows = tuple(range(wrench_rows(tree.nv, six, tree.space.dim)))
    units, J = _comparable(tree, q, frame, rows)
    L, inverse = _factored(J)
    back = transposed(J, tree.nv)
    found = _solved(L, inverse, times(J, tau))
    for _ in range(_STEPS):
        left = sub(tau, times(back, found))
        found = add(found, _solved(L, inverse, times(J, left)))
    wrench = tuple(unit * x for unit, x in zip(units, found, strict=True))
    return nan_unless(surely_independent(J, _SURE), q, wrench) + (0.0,) * (six - len(rows))


def wrench_rows(nv: int, six: int, dim: int) -> int:
    """The number of components of a wrench that nv torques can determine: all, or the force alone
    where there are fewer torques than components."""
    return six if nv >= six else dim


def _comparable(
    tree: Tree, q: Vector, frame: str, rows: tuple[int, ...]
) -> tuple[list[Scalar], Matrix]:
    """(factors of the chosen rows of a frame's Jacobian, the rows times their factors): lengths
    divided by the arm's, so that linear and angular rows compare."""
    each = 1.0 / _reach(tree, frame)
    units = [each if row < tree.space.dim else 1.0 for row in rows]
    whole = jacobian(tree, q, frame)
    return units, tuple(scale(unit, whole[row]) for unit, row in zip(units, rows, strict=True))


def _reach(tree: Tree, frame: str) -> Scalar:
    """Distances from joint to joint on the way to a frame, added up (m); 1 where they are all
    zero."""
    body, _, p = tree.frames[frame]
    ways = [p, *(tree.bodies[i].p for i in ancestors(tree, body)[:-1])]
    long = [way for way in ways if any(not isinstance(x, float) or x for x in way)]
    return reduce(plus, (sqrt(dot(way, way)) for way in long)) if long else 1.0


def _factored(J: Matrix) -> tuple[list[list[Scalar]], list[Scalar]]:
    """L of J Jᵀ = L D Lᵀ, and the inverses of D."""
    L, _, inverse = factors(symmetric(len(J), lambda i, j: dot(J[i], J[j])))
    return L, inverse


def _solved(L: Matrix | list[list[Scalar]], inverse: list[Scalar], b: Vector) -> Vector:
    """x of L D Lᵀ x = b, the pivots' inverses given."""
    n, x = len(b), list(b)
    for i in range(n):
        for k in range(i):
            x[i] = x[i] - L[i][k] * x[k]
    x = [value * one for value, one in zip(x, inverse, strict=True)]
    for i in reversed(range(n)):
        for k in range(i + 1, n):
            x[i] = x[i] - L[k][i] * x[k]
    return tuple(x)
