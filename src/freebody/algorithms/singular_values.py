"""Singular values of small matrices, by rotations in the planes of two rows until all rows are at
right angles (Hestenes 1958; Golub and Van Loan 2013, section 8.6.3)."""

from __future__ import annotations

from freebody.elementary import Scalar, absolute, less, maximum, sqrt, where
from freebody.spatial import Matrix, dot

_RIGHT = 1e-16
"""Rows whose product is as small as this, beside the squares of all entries, are at right
angles."""


def sweep(A: Matrix) -> tuple[Matrix, Scalar]:
    """A after one rotation for each two of its rows, and 1 where some were not at right angles,
    else 0; rows at right angles stay as they are."""
    rows = [tuple(row) for row in A]
    whole: Scalar = 0.0
    for row in rows:
        whole = whole + dot(row, row)
    left: Scalar = 0.0
    for i in range(len(rows)):
        for j in range(i + 1, len(rows)):
            a, b = rows[i], rows[j]
            product = dot(a, b)
            turned = less(_RIGHT * whole, absolute(product))
            ratio = (dot(b, b) - dot(a, a)) / where(turned, 2.0 * product, 1.0)
            size = 1.0 / (absolute(ratio) + sqrt(1.0 + ratio * ratio))
            tangent = where(turned, where(less(ratio, 0.0), -size, size), 0.0)
            c = 1.0 / sqrt(1.0 + tangent * tangent)
            s = c * tangent
            rows[i] = tuple(c * x - s * y for x, y in zip(a, b, strict=True))
            rows[j] = tuple(s * x + c * y for x, y in zip(a, b, strict=True))
            left = maximum(left, where(turned, 1.0, 0.0))
    return tuple(rows), left
