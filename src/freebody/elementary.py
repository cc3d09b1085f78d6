"""The elementary functions of an algorithm, over any scalar.

A scalar is anything that adds, subtracts, multiplies and divides, and either is understood by NumPy or has a method
`elementary(name, operands)`: the value of the function of that name, or NotImplemented, which leaves it to another
operand. So floats, NumPy arrays (one entry a sample), traced, symbolic and differentiated scalars all run through the
same text.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import numpy as np

Scalar = Any
"""A float, a NumPy array, or any object with the arithmetic above."""

FUNCTIONS: dict[str, Callable[..., Scalar]] = {}
"""Every function of this module by its name, which is that of the operation in a program."""

OF_ARRAYS: dict[str, Callable[[Any], Callable[..., Any]]] = {}
"""The same: from an array library, `numpy` or `jax.numpy`, to the function over its arrays."""


def _dispatch(name: str, of_arrays: Callable[[Any], Callable[..., Any]], doc: str) -> Callable[..., Scalar]:
    numeric = of_arrays(np)

    def function(*operands: Scalar) -> Scalar:
        for x in operands:
            handler = getattr(x, "elementary", None)
            if handler is not None:
                result = handler(name, operands)
                if result is not NotImplemented:
                    return result
        return numeric(*operands)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = doc
    FUNCTIONS[name], OF_ARRAYS[name] = function, of_arrays
    return function


def _flag(comparison: str) -> Callable[[Any], Callable[..., Any]]:
    """1.0 and 0.0 instead of True and False, so that the results can be reckoned with."""
    return lambda xp: lambda a, b: xp.where(getattr(xp, comparison)(a, b), 1.0, 0.0)[()]


def _where(xp: Any) -> Callable[..., Any]:
    return lambda condition, a, b: xp.where(xp.not_equal(condition, 0.0), a, b)[()]


sin = _dispatch("sin", attrgetter("sin"), "Sine of an angle in radians.")
cos = _dispatch("cos", attrgetter("cos"), "Cosine of an angle in radians.")
sqrt = _dispatch("sqrt", attrgetter("sqrt"), "Square root; NaN where negative.")
exp = _dispatch("exp", attrgetter("exp"), "e to the power of x; infinite from 709.8 on.")
log = _dispatch("log", attrgetter("log"), "Natural logarithm; -infinity of 0, NaN where negative.")
tanh = _dispatch("tanh", attrgetter("tanh"), "Hyperbolic tangent, which saturates at -1 and 1.")
atan2 = _dispatch(
    "atan2",
    attrgetter("arctan2"),
    "atan2(y, x): the angle of the vector (x, y), -pi to pi; 0 of (0, 0), whose slopes are NaN.",
)
asin = _dispatch(
    "asin", attrgetter("arcsin"), "Arc sine, -pi/2 to pi/2; NaN beyond -1 and 1, where its slope is infinite."
)
acos = _dispatch(
    "acos", attrgetter("arccos"), "Arc cosine, 0 to pi; NaN beyond -1 and 1, where its slope is infinite."
)
sign = _dispatch("sign", attrgetter("sign"), "-1, 0 or 1; 0 at 0.")
absolute = _dispatch("absolute", attrgetter("absolute"), "|x|; its derivative at 0 is 0.")
less = _dispatch("less", _flag("less"), "1 where a < b, else 0.")
less_equal = _dispatch("less_equal", _flag("less_equal"), "1 where a <= b, else 0.")
equal = _dispatch("equal", _flag("equal"), "1 where a and b are equal, else 0.")
where = _dispatch(
    "where", _where, "a where the condition is not 0, else b; the derivative is that of the one chosen."
)
minimum = _dispatch(
    "minimum",
    attrgetter("minimum"),
    "The smaller one, NaN if one is NaN; where they are equal, the derivative is a's.",
)
maximum = _dispatch(
    "maximum",
    attrgetter("maximum"),
    "The larger one, NaN if one is NaN; where they are equal, the derivative is a's.",
)
