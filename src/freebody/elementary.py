"""The elementary functions of an algorithm, over any scalar.

A scalar is anything that adds, subtracts, multiplies and divides, and either is understood by NumPy
or has a method `elementary(name, operands)`: the value of the function of that name, or
NotImplemented, which leaves it to another operand. So floats, NumPy arrays (one entry a sample),
traced, symbolic and differentiated scalars all run through the same text.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Scalar = Any
"""A float, a NumPy array, or any object with the arithmetic above."""

FUNCTIONS: dict[str, Callable[..., Scalar]] = {}
"""Every function of this module by its name, which is that of the operation in a program."""

NUMERIC: dict[str, Callable[..., Any]] = {}
"""Every function for floats and NumPy arrays alone, which does not look at its operands."""


_One = Callable[[Scalar], Scalar]
_Two = Callable[[Scalar, Scalar], Scalar]
_Three = Callable[[Scalar, Scalar, Scalar], Scalar]


def _dispatch(name: str, numeric: Callable[..., Any], doc: str) -> Callable[..., Scalar]:
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
    FUNCTIONS[name], NUMERIC[name] = function, numeric
    return function


def _flag(comparison: Callable[..., Any]) -> Callable[..., Any]:
    """A comparison that returns 1.0 and 0.0 instead of True and False, so that its results can be
    used in arithmetic."""
    return lambda a, b: np.where(comparison(a, b), 1.0, 0.0)[()]


def _where(condition: Any, a: Any, b: Any) -> Any:
    return np.where(np.not_equal(condition, 0.0), a, b)[()]


def _epsilon(x: Any) -> Any:
    kind = np.result_type(x)
    return np.finfo(kind if kind.kind == "f" else np.float64).eps


sin: _One = _dispatch("sin", np.sin, "Sine of an angle in radians.")
cos: _One = _dispatch("cos", np.cos, "Cosine of an angle in radians.")
sqrt: _One = _dispatch("sqrt", np.sqrt, "Square root; NaN where negative.")
exp: _One = _dispatch("exp", np.exp, "e to the power of x; infinite from 709.8 on.")
log: _One = _dispatch("log", np.log, "Natural logarithm; -infinity of 0, NaN where negative.")
tanh: _One = _dispatch("tanh", np.tanh, "Hyperbolic tangent, which saturates at -1 and 1.")
atan2: _Two = _dispatch(
    "atan2",
    np.arctan2,
    "atan2(y, x): the angle of the vector (x, y), -pi to pi; 0 of (0, 0), whose slopes are NaN.",
)
asin: _One = _dispatch(
    "asin", np.arcsin, "Arc sine, -pi/2 to pi/2; NaN beyond -1 and 1, where its slope is infinite."
)
acos: _One = _dispatch(
    "acos", np.arccos, "Arc cosine, 0 to pi; NaN beyond -1 and 1, where its slope is infinite."
)
sign: _One = _dispatch(
    "sign",
    lambda x: np.sign(np.real(x)),  # complex numbers are real ones with a small step: no angles
    "-1, 0 or 1; 0 at 0.",
)
absolute: _One = _dispatch("absolute", np.absolute, "|x|; its derivative at 0 is 0.")
less: _Two = _dispatch("less", _flag(np.less), "1 where a < b, else 0.")
less_equal: _Two = _dispatch("less_equal", _flag(np.less_equal), "1 where a <= b, else 0.")
equal: _Two = _dispatch("equal", _flag(np.equal), "1 where a and b are equal, else 0.")
where: _Three = _dispatch(
    "where",
    _where,
    "a where the condition is not 0, else b; the derivative is that of the one chosen.",
)
minimum: _Two = _dispatch(
    "minimum",
    np.minimum,
    "The smaller one, NaN if one is NaN; where they are equal, the derivative is a's.",
)
maximum: _Two = _dispatch(
    "maximum",
    np.maximum,
    "The larger one, NaN if one is NaN; where they are equal, the derivative is a's.",
)
epsilon: _One = _dispatch(
    "epsilon",
    _epsilon,
    "The distance from 1 to the next number of the type that x is computed in: 2^-52 of 64 bits, "
    "2^-23 of 32.",
)


def _of_angle(angle: Scalar, y: Scalar, x: Scalar) -> tuple[Scalar, Scalar]:
    square = x * x + y * y
    return x / square, -(y / square)


PARTIALS: dict[str, Callable[..., tuple[Scalar, ...]]] = {
    "sqrt": lambda y, x: (0.5 / y,),
    "sin": lambda y, x: (cos(x),),
    "cos": lambda y, x: (-sin(x),),
    "exp": lambda y, x: (y,),
    "log": lambda y, x: (1.0 / x,),
    "tanh": lambda y, x: (1.0 - y * y,),
    "atan2": _of_angle,
    "asin": lambda y, x: (1.0 / sqrt((1.0 - x) * (1.0 + x)),),
    "acos": lambda y, x: (-1.0 / sqrt((1.0 - x) * (1.0 + x)),),
    "absolute": lambda y, x: (sign(x),),
}
"""(value, *operands) -> the partial derivative by each operand, of each function that is not
constant wherever it has a derivative, and does not choose."""

CHOOSES: dict[str, Callable[..., Scalar]] = {
    "where": lambda c, a, b: c,
    "minimum": less_equal,
    "maximum": lambda a, b: less_equal(b, a),
}
"""(*operands) -> condition, of each function that returns its last operand but one where the
condition is not 0, else its last; its derivative is that of the one returned."""
