"""Natural modes of undamped oscillation: K v = ω² M v for symmetric matrices with M positive
definite, by Cholesky's factor of M and Jacobi's rotations (Golub and Van Loan 2013, sections 4.2.5
and 8.5), a fixed number of them, without branches."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from functools import reduce
from itertools import combinations

from freebody.algorithms.singular_values import either, pairs, sense
from freebody.elementary import Scalar, absolute, less, less_equal, maximum, minimum, sqrt, where
from freebody.spatial import Matrix, Vector, dot, identity, scale

SWEEPS = (0, 0, 1, 3, 4, 4, 4, 5)
"""Rotations for each two coordinates, by their number; beyond, matrices are not worth a
straight-line program."""
_RIGHT = 1e-12
"""Entry off the diagonal, relative to the two on it, of a matrix that is diagonal."""
_NOISE = 1e-15
"""An entry, relative to the largest, that is nothing but rounding."""
_GONE = 1e-24
"""An entry, relative to those on the diagonal, that is 0: what shrinks below the least normal
number makes processors slow."""
_NOTHING = 1e-290
"""A size beside which nothing is lost, and by which one can divide."""


def vibration_modes(M: Matrix, K: Matrix) -> tuple[tuple[Vector, Matrix], Scalar]:
    """((ω², the least first; v, one a row, with vᵀ M v = 1), 1 where they are sure, else 0).

    Of the two senses of a mode that in which the first entry of more than half the largest one's
    size is positive.
    """
    ways = _inverse_factor(M)
    A = [[dot(a, tuple(dot(row, b) for row in K)) for b in ways] for a in ways]
    carried = [list(way) for way in ways]
    for i, j in SWEEPS[len(M)] * pairs(len(M)):
        _turn(A, carried, i, j)
    largest = reduce(maximum, (absolute(A[i][i]) for i in range(len(A))))
    sure: Scalar = 1.0
    for i, j in combinations(range(len(A)), 2):
        least = _RIGHT**2 * absolute(A[i][i] * A[j][j]) + (_NOISE * largest) ** 2 + _NOTHING
        sure = sure * less_equal(A[i][j] * A[i][j], least)  # 0 of what is NaN
    found = [(A[i][i], tuple(way)) for i, way in enumerate(carried)]
    for i, j in combinations(range(len(found)), 2):
        (a, first), (b, second) = found[i], found[j]
        swapped = less(b, a)
        found[i] = minimum(a, b), either(swapped, second, first)
        found[j] = maximum(a, b), either(swapped, first, second)
    squares, modes = zip(*found, strict=True)
    return (squares, tuple(scale(sense(mode), mode) for mode in modes)), sure


def _inverse_factor(M: Matrix) -> Matrix:
    """The inverse of L with M = L Lᵀ: its rows are ways of which each has the kinetic energy of a
    unit mass, and no two have one in common."""
    n = len(M)
    L: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    rows: list[Vector] = []
    for i, unit in enumerate(identity(n)):
        for j in range(i):
            L[i][j] = (M[i][j] - _sum(L[i][k] * L[j][k] for k in range(j))) * rows[j][j]
        pivot = 1.0 / sqrt(M[i][i] - _sum(x * x for x in L[i][:i]))
        rest = (_sum(L[i][k] * rows[k][j] for k in range(j, i)) for j in range(n))
        rows.append(tuple(pivot * (x - y) for x, y in zip(unit, rest, strict=True)))
    return tuple(rows)


def _turn(A: list[list[Scalar]], carried: list[list[Scalar]], i: int, j: int) -> None:
    """Turn two coordinates so far that entry (i, j) of a symmetric matrix is gone: the tangent t of
    the smaller such angle solves t² + 2 t (a_jj - a_ii) / (2 a_ij) = 1."""
    ahead, size = A[j][j] - A[i][i], absolute(A[i][i]) + absolute(A[j][j])
    entry = where(less(_GONE * size, absolute(A[i][j])), A[i][j], 0.0)
    long = absolute(ahead) + sqrt(ahead * ahead + 4.0 * (entry * entry)) + _NOTHING
    t = where(less(ahead, 0.0), -2.0, 2.0) * entry / long
    c = 1.0 / sqrt(1.0 + t * t)
    s = t * c
    A[i][i], A[j][j] = A[i][i] - t * entry, A[j][j] + t * entry
    A[i][j] = A[j][i] = 0.0
    for k in range(len(A)):
        if k not in (i, j):
            x, y = A[k][i], A[k][j]
            A[k][i] = A[i][k] = c * x - s * y
            A[k][j] = A[j][k] = s * x + c * y
    first, second = carried[i], carried[j]
    carried[i] = [c * x - s * y for x, y in zip(first, second, strict=True)]
    carried[j] = [s * x + c * y for x, y in zip(first, second, strict=True)]


def _sum(terms: Iterable[Scalar]) -> Scalar:
    return reduce(operator.add, terms, 0.0)
