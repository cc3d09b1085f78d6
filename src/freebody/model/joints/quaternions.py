"""Unit quaternions w, x, y, z over scalars: products, turns by a rotation vector and back, motion
along a screw.

No formula asks for a value: where the usual ones divide by an angle that may be 0, the angle's
square is raised by `_TINY`, which changes nothing that a double can hold.
"""

from __future__ import annotations

from freebody.elementary import Scalar, cos, sign, sin, sqrt
from freebody.spatial import AnySpace, Vector, add, dot, scale

_TINY = 1e-30
_HALVINGS = 3
"""Halvings of the angle before its tangent is small enough for the arctangent's series."""
_ARCTANGENT = tuple((-1) ** k / (2 * k + 1) for k in range(13))
"""arctan(t)/t in powers of t²: tan(π/16)² to the 13th power is below 1e-18."""


def product(a: Vector, b: Vector) -> Vector:
    """Product a b of two quaternions."""
    (w, x, y, z), (W, X, Y, Z) = a, b
    return (
        w * W - x * X - y * Y - z * Z,
        w * X + x * W + y * Z - z * Y,
        w * Y - x * Z + y * W + z * X,
        w * Z + x * Y - y * X + z * W,
    )


def conjugate(q: Vector) -> Vector:
    """The inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def unit(q: Vector) -> Vector:
    """A quaternion divided by its length."""
    return scale(1.0 / sqrt(dot(q, q)), q)


def exponential(v: Vector) -> Vector:
    """The turn by the rotation vector v (3 scalars)."""
    half = 0.5 * _size(v)
    return (cos(half), *scale(0.5 * sin(half) / half, v))


def logarithm(q: Vector) -> Vector:
    """The rotation vector, of length at most π, of a quaternion of any length but 0.

    Halving the angle three times leaves a tangent below 0.2; q and -q are the same turn.
    """
    w, *u = unit(q)
    shorter = sign(sign(w) + 0.5)  # that of w, and 1 for 0
    w, u = shorter * w, scale(shorter, tuple(u))
    for _ in range(_HALVINGS):
        w_half = sqrt(0.5 + 0.5 * w)
        w, u = w_half, scale(0.5 / w_half, u)
    tangent = scale(1.0 / w, u)
    square, series = dot(tangent, tangent), 0.0
    for factor in reversed(_ARCTANGENT):
        series = series * square + factor
    return scale(2.0 * 2**_HALVINGS * series, tangent)


def screw_shift(space: AnySpace, w: Vector, v: Vector) -> Vector:
    """∫ exp(s w×) v ds over s from 0 to 1: how far the origin goes, in the axes it starts with."""
    angle = _size(w)
    first = (
        0.5 * (sin(0.5 * angle) / (0.5 * angle)) ** 2
    )  # (1 - cos) / angle², without the difference
    second = (angle - sin(angle)) / (angle * angle * angle)
    across = space.cross(w, v)
    return add(v, add(scale(first, across), scale(second, space.cross(w, across))))


def unshifted(space: AnySpace, w: Vector, p: Vector) -> Vector:
    """The v whose `screw_shift` is p."""
    angle = _size(w)
    half = 0.5 * angle
    rest = (1.0 - half * cos(half) / sin(half)) / (angle * angle)
    across = space.cross(w, p)
    return add(p, add(scale(-0.5, across), scale(rest, space.cross(w, across))))


def _size(w: Vector) -> Scalar:
    """Length of a rotation vector, never 0."""
    return sqrt(dot(w, w) + _TINY)
