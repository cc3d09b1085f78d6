"""Rational numbers near given ones that satisfy exact conditions: points on the circle, rotations,
unit vectors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from numbers import Rational
from typing import Any

import numpy as np

from freebody.model.quantity_reader import EXACT

_HALF_TURN_PARTS = (
    10**9
)  # denominators of rational points on the circle: angles are met within 1e-18


def exactly(number: float | Rational) -> Fraction:
    """A float as the fraction of the shortest decimal that reads back as it; rationals
    unchanged."""
    return Fraction(number) if isinstance(number, Rational) else Fraction(repr(float(number)))


def rational_sin_cos(angle: float) -> tuple[Any, Any]:
    """Rational (s, c) with s² + c² = 1 exactly: 0 and ±1 at right angles, else the nearest rational
    point by the half angle."""
    quarter = round(angle / (math.pi / 2))
    rest = angle - quarter * (math.pi / 2)
    if abs(rest) <= EXACT:
        s, c = Fraction(0), Fraction(1)
    else:
        t = Fraction(math.tan(rest / 2)).limit_denominator(_HALF_TURN_PARTS)
        s, c = 2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)
    for _ in range(quarter % 4):
        s, c = c, -s
    return s, c


def rational_rotation(matrix: Sequence[Sequence[float]]) -> tuple[tuple[Any, ...], ...]:
    """An exactly orthogonal rational matrix near a rotation: its quaternion is rounded to
    rationals."""
    if all(x in (0.0, 1.0, -1.0) for row in matrix for x in row):
        return tuple(tuple(row) for row in matrix)
    w, x, y, z = (
        Fraction(v).limit_denominator(_HALF_TURN_PARTS)
        for v in _quaternion(np.asarray(matrix, dtype=float))
    )
    n = w * w + x * x + y * y + z * z
    return (
        (1 - 2 * (y * y + z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n),
        (2 * (x * y + w * z) / n, 1 - 2 * (x * x + z * z) / n, 2 * (y * z - w * x) / n),
        (2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, 1 - 2 * (x * x + y * y) / n),
    )


def rational_axis(axis: Sequence[float]) -> tuple[Any, ...]:
    """A rational vector of length exactly 1 near a unit vector (stereographic projection)."""
    if sum(x != 0.0 for x in axis) == 1:
        return tuple(axis)
    k = max(range(3), key=lambda i: abs(axis[i]))
    pole = 1 if axis[k] > 0 else -1
    u, v = (
        Fraction(axis[i] / (1 + abs(axis[k]))).limit_denominator(_HALF_TURN_PARTS)
        for i in range(3)
        if i != k
    )
    square = u * u + v * v
    plane = iter((2 * u / (1 + square), 2 * v / (1 + square)))
    return tuple(pole * (1 - square) / (1 + square) if i == k else next(plane) for i in range(3))


def _quaternion(R: np.ndarray) -> tuple[float, float, float, float]:
    """Quaternion w, x, y, z of a rotation, scaled so that its largest entry is 1 (simple fractions
    stay simple)."""
    xx, yy, zz = R[0, 0], R[1, 1], R[2, 2]
    squares = np.array([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    outer = np.array(
        [
            [squares[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], squares[1], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], squares[2], R[1, 2] + R[2, 1]],
            [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], squares[3]],
        ]
    )
    k = int(np.argmax(squares))
    w, x, y, z = outer[k] / squares[k]
    return float(w), float(x), float(y), float(z)
