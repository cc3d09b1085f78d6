"""Functions of scalars for one's own computations: of floats, NumPy arrays, and what `fb.compile`
traces.

A traced scalar has no value yet, so that Python's `if`, `min`, `math.sin` and NumPy's functions
cannot take it. What depends on values is written with `where`, `minimum`, `maximum` and `clip`;
comparisons are 1.0 or 0.0. In compiled code exp, log, asin and acos are within 1 unit in the last
place of the exact value, sin, cos, tanh and atan2 within 2 (sin and cos of arguments beyond 1e5:
4), with and without fused multiply-add. The sign of a zero that is computed on the way is not kept.
"""

from __future__ import annotations

from math import inf, pi
from numbers import Real

from freebody.elementary import (
    Scalar,
    absolute,
    acos,
    asin,
    atan2,
    cos,
    epsilon,
    equal,
    exp,
    less,
    less_equal,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tanh,
    where,
)

__name__ = "freebody.math"  # where users find the functions, which say so

__all__ = [
    "absolute",
    "acos",
    "asin",
    "atan",
    "atan2",
    "clip",
    "cos",
    "epsilon",
    "equal",
    "exp",
    "greater",
    "greater_equal",
    "hypot",
    "less",
    "less_equal",
    "log",
    "logical_and",
    "logical_not",
    "logical_or",
    "maximum",
    "minimum",
    "not_equal",
    "pi",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
    "where",
]


def tan(x: Scalar) -> Scalar:
    """Tangent of an angle in radians, sin x / cos x."""
    return sin(x) / cos(x)


def atan(x: Scalar) -> Scalar:
    """Arc tangent, -pi/2 to pi/2."""
    return atan2(x, 1.0)


def clip(x: Scalar, lowest: Scalar, highest: Scalar) -> Scalar:
    """The value x limited to bounds, `highest` where lowest > highest; the derivative is that of
    the value returned.

    A number that is infinite is no bound.
    """
    if not _is(lowest, -inf):
        x = maximum(x, lowest)
    return x if _is(highest, inf) else minimum(x, highest)


def _is(bound: Scalar, value: float) -> bool:
    return isinstance(bound, Real) and float(bound) == value


def hypot(x: Scalar, y: Scalar) -> Scalar:
    """The length sqrt(x² + y²) without overflow on the way; its derivatives at 0, 0 are 0."""
    a, b = absolute(x), absolute(y)
    larger, smaller = maximum(a, b), minimum(a, b)
    ratio = smaller / where(equal(larger, 0.0), 1.0, larger)
    return larger * sqrt(1.0 + ratio * ratio)


def greater(a: Scalar, b: Scalar) -> Scalar:
    """Comparison as a number: 1 where a > b, else 0."""
    return less(b, a)


def greater_equal(a: Scalar, b: Scalar) -> Scalar:
    """Comparison as a number: 1 where a >= b, else 0."""
    return less_equal(b, a)


def not_equal(a: Scalar, b: Scalar) -> Scalar:
    """Comparison as a number: 1 where a and b differ, else 0."""
    return 1.0 - equal(a, b)


def logical_not(a: Scalar) -> Scalar:
    """Logical negation as a number: 1 where a is 0, else 0."""
    return equal(a, 0.0)


def logical_and(a: Scalar, b: Scalar) -> Scalar:
    """1 where neither a nor b is 0, else 0."""
    return where(a, not_equal(b, 0.0), 0.0)


def logical_or(a: Scalar, b: Scalar) -> Scalar:
    """1 where a or b is not 0, else 0."""
    return where(a, 1.0, not_equal(b, 0.0))
