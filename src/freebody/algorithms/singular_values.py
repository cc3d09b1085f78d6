"""Singular values of small matrices, by rotations in the planes of two rows until all rows are at
right angles (Hestenes 1958; Golub and Van Loan 2013, section 8.6.3)."""

from __future__ import annotations

import operator
from functools import reduce
from itertools import combinations

from freebody.algorithms.singular_thresholds import LOST
from freebody.elementary import Scalar, absolute, less, maximum, minimum, sqrt, where
from freebody.spatial import Matrix, Vector, dot, identity, scale, transposed

_SWEEPS = (0, 0, 2, 4, 4, 5, 5)
"""Rotations for each two rows, by the number of rows. At most one in ten thousand of a robot's
matrices takes more; with one less, several in a hundred do."""
_EXACT = 1e-15
"""Error of singular values, relative to the largest: that of rounding."""
_RIGHT = 1e-13
"""Cosine of rows that are at right angles."""
_NOISE = 1e-14
"""Length of a row, relative to all, that is nothing but rounding."""
_NO_LENGTH = 1e-150
"""Square of the length of a row that is 0; not so small that its own square is."""


def singular_values(A: Matrix) -> tuple[tuple[Vector], Scalar]:
    """((the singular values, the largest first), 1 where they are sure, else 0) of a matrix of up
    to 6 rows or columns.

    The product p of two rows shifts their squares a and b by |p| or, if less, by p² / |a - b|.
    """
    rows = A if len(A) <= len(A[0]) else transposed(A, len(A[0]))
    turned = _turned(rows, ((),) * len(rows), _SWEEPS[len(rows)])
    squares, whole = _squares(turned)
    sure: Scalar = 1.0
    for i, j in combinations(range(len(rows)), 2):
        product, apart = dot(turned[i][0], turned[j][0]), squares[i] - squares[j]
        square = product * product
        least = _EXACT**2 * (whole * minimum(squares[i], squares[j]))
        shifted = less(least, square) * less(least * (apart * apart), square * square)
        sure = sure * (1.0 - shifted)
    sizes = [sqrt(x) for x in squares]
    for i, j in combinations(range(len(sizes)), 2):
        sizes[i], sizes[j] = maximum(sizes[i], sizes[j]), minimum(sizes[i], sizes[j])
    return (tuple(sizes),), sure


def left_singular_vectors(A: Matrix) -> tuple[tuple[Matrix, Vector], Scalar]:
    """((unit vectors U, one a row; singular values s), 1 where they are sure, else 0) with A Aᵀ =
    Uᵀ diag(s²) U, as `vectors_and_values`."""
    turned = _turned(A, identity(len(A)), _SWEEPS[len(A)])
    squares, whole = _squares(turned)
    sure: Scalar = 1.0
    for i, j in combinations(range(len(A)), 2):
        product = dot(turned[i][0], turned[j][0])
        skew = less(_RIGHT**2 * (squares[i] * squares[j]), product * product)
        real = less(_NOISE**2 * whole, minimum(squares[i], squares[j]))
        sure = sure * (1.0 - skew * real)
    found = [(way, sqrt(x)) for (_, way), x in zip(turned, squares, strict=True)]
    for i, j in combinations(range(len(found)), 2):
        (a, first), (b, second) = found[i], found[j]
        swapped = less(first, second)
        found[i] = either(swapped, b, a), maximum(first, second)
        found[j] = either(swapped, a, b), minimum(first, second)
    ways, sizes = zip(*found, strict=True)
    return vectors_and_values(ways, sizes), sure


def vectors_and_values(ways: Matrix, sizes: Vector) -> tuple[Matrix, Vector]:
    """Unit vectors and their singular values, the largest first; of each vector the first entry
    larger than half its largest is positive, and values lost in rounding are 0."""
    turned = tuple(scale(sense(way), way) for way in ways)
    return turned, tuple(where(less(LOST * sizes[0], x), x, 0.0) for x in sizes)


def sense(way: Vector) -> Scalar:
    """The sign, 1 or -1, of the first entry of a vector that has more than half the size of the
    largest."""
    half: Scalar = 0.0
    for x in way:
        half = maximum(half, 0.5 * absolute(x))
    leading = way[-1]
    for x in reversed(way[:-1]):
        leading = where(less(half, absolute(x)), x, leading)
    return where(less(leading, 0.0), -1.0, 1.0)


def either(condition: Scalar, a: Vector, b: Vector) -> Vector:
    """The first of two vectors where the condition is 1, else the second."""
    return tuple(where(condition, x, y) for x, y in zip(a, b, strict=True))


def _turned(A: Matrix, carried: Matrix, sweeps: int) -> list[tuple[Vector, Vector]]:
    """Rows of A after sweeps of rotations of every two of them, each with its carried row, which
    was rotated along."""
    rows = list(zip(A, carried, strict=True))
    for i, j in sweeps * pairs(len(rows)):
        (a, along_a), (b, along_b) = rows[i], rows[j]
        c, s = _rotation(a, b)
        rows[i] = _sum(c, a, s, b), _sum(c, along_a, s, along_b)
        rows[j] = _sum(c, b, -s, a), _sum(c, along_b, -s, along_a)
    return rows


def _squares(rows: list[tuple[Vector, Vector]]) -> tuple[list[Scalar], Scalar]:
    """The squares of the lengths of rows, and their sum, which is replaced by a positive number
    where all are 0."""
    squares = [dot(row, row) for row, _ in rows]
    return squares, reduce(operator.add, squares, _NO_LENGTH / _NOISE**2)


def _rotation(a: Vector, b: Vector) -> tuple[Scalar, Scalar]:
    """(cosine, sine) of the smaller angle by which two rows are turned to right angles: tan of
    twice the angle is 2 a · b / (a² - b²)."""
    product, ahead = dot(a, b), dot(a, a) - dot(b, b)
    apart = absolute(ahead) + _NO_LENGTH
    long = sqrt(apart * apart + 4.0 * (product * product))
    each = 1.0 / sqrt(2.0 * (long * (long + apart)))
    sine = 2.0 * (product * each)
    return (long + apart) * each, where(less(ahead, 0.0), -sine, sine)


def _sum(c: Scalar, a: Vector, s: Scalar, b: Vector) -> Vector:
    return tuple(c * x + s * y for x, y in zip(a, b, strict=True))


def pairs(n: int) -> list[tuple[int, int]]:
    """All pairs of n numbers, those without a common one next to one another, so that a processor
    turns several at once."""
    places = list(range(n + n % 2))
    found = []
    for _ in places[1:]:
        found += [(i, j) for i, j in zip(places, reversed(places), strict=True) if i < j < n]
        places.insert(1, places.pop())
    return found
