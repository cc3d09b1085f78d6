"""Evaluating formulas with exact polynomials or numbers, and typical symbol values for examples:
vectors are tuples, matrices tuples of tuples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce, wraps
from typing import Any

import numpy as np

from freebody import elementary
from freebody.arrays import Array
from freebody.errors import UnknownNameError
from freebody.expressions.evaluate import NoValue, Rules, arithmetic, evaluate
from freebody.expressions.expression import (
    Arguments,
    Cross,
    Derivative,
    Dot,
    Expression,
    Function,
    Matrix,
    Symbol,
    Transposed,
    Vector,
)
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.scalar_math import tan
from freebody.scalars.composed import Composed
from freebody.scalars.generators import waves_of
from freebody.scalars.trig import Trig, TrigRing
from freebody.spatial import product, times, transposed
from freebody_textbook.relations.formula import FormulaError

FormulaValue = Any


_TYPICAL = {
    "l": (0.5, 0.4, 0.3, 0.2), "lc": (0.2, 0.15, 0.12, 0.1), "m": (3.0, 2.0, 1.5, 1.0),
    "I": (0.08, 0.05, 0.03, 0.02),
    "theta": (0.4, 0.9, -0.6, 0.7), "d": (0.25, 0.35, 0.15, 0.45),
}  # fmt: skip


_TYPICAL_RATES, _TYPICAL_SECONDS = (1.2, -0.7, 0.9, -1.4), (2.0, 1.5, -1.1, 0.8)


class Each(tuple):
    """Values for each of several bodies, such as the masses m_i; `sum` adds them."""


def value(node: Expression, values: Mapping[str, FormulaValue]) -> FormulaValue:
    """The value of an expression, with each symbol's value given by name."""

    def symbol(node: Symbol, at: Any) -> FormulaValue:
        if node.name not in values:
            raise UnknownNameError("quantity", node.name, "the values given", values)
        return plain(values[node.name])

    try:
        return evaluate(node, {**_RULES, Symbol: symbol})
    except NoValue as problem:
        raise FormulaError(problem.problem) from None


def plain(x: Any) -> FormulaValue:
    """Arrays and lists converted to tuples; scalars unchanged."""
    if isinstance(x, np.ndarray):
        return plain(x.tolist())
    if isinstance(x, Each):
        return Each(map(plain, x))
    return tuple(map(plain, x)) if isinstance(x, list | tuple) else x


def rank(x: FormulaValue) -> int:
    """The rank of a value: 0 for a scalar, 1 for a vector, 2 for a matrix."""
    return 1 + rank(x[0]) if isinstance(x, tuple) and x else 0


def shape_name(x: FormulaValue) -> str:
    """The shape of a value in words."""
    if rank(x) == 0:
        return "a scalar"
    return f"a vector of {len(x)}" if rank(x) == 1 else f"a matrix of {len(x)} × {len(x[0])}"


# ---------------------------------------------------------------- arithmetic
def _for_each(rule: Callable[[Any, Any], FormulaValue]) -> Callable[[Any, Any], FormulaValue]:
    """A rule for two values, extended to values given for each of several bodies."""

    @wraps(rule)
    def each(a: FormulaValue, b: FormulaValue) -> FormulaValue:
        counts = [len(x) for x in (a, b) if isinstance(x, Each)]
        if not counts:
            return rule(a, b)
        left, right = (x if isinstance(x, Each) else Each((x,) * max(counts)) for x in (a, b))
        return Each(map(each, left, right))

    return each


@_for_each
def plus(a: FormulaValue, b: FormulaValue) -> FormulaValue:
    """Sum a + b of two values of the same shape."""
    if rank(a) != rank(b) or (rank(a) and len(a) != len(b)):
        raise FormulaError(f"{shape_name(a)} and {shape_name(b)} cannot be added")
    return tuple(map(plus, a, b)) if rank(a) else a + b


def minus(a: FormulaValue) -> FormulaValue:
    """The opposite -a of a value."""
    return type(a)(map(minus, a)) if isinstance(a, tuple) else -a


@_for_each
def multiplied(a: FormulaValue, b: FormulaValue) -> FormulaValue:
    """Product a b: scalars times anything, matrices times vectors and matrices."""
    match rank(a), rank(b):
        case 0, 0:
            return a * b
        case 0, _:
            return tuple(multiplied(a, x) for x in b)
        case _, 0:
            return tuple(multiplied(x, b) for x in a)
        case 2, 1 if len(a[0]) == len(b):
            return times(a, b)
        case 2, 2 if len(a[0]) == len(b):
            return product(a, b)
    raise FormulaError(
        f"{shape_name(a)} and {shape_name(b)} have no product; write dot(a, b) or cross(a, b)"
    )


@_for_each
def crossed(a: FormulaValue, b: FormulaValue) -> FormulaValue:
    """Cross product a × b: a vector in space, a scalar for planar vectors; ω z × b for a scalar
    rate ω and a planar vector b."""
    match (len(a) if rank(a) == 1 else 0), (len(b) if rank(b) == 1 else 0):
        case 3, 3:
            return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        case 2, 2:
            return a[0] * b[1] - a[1] * b[0]
        case 3, 2:
            return crossed(a, (*b, 0.0))[:2]
        case 0, 2 if rank(a) == 0:
            return -(a * b[1]), a * b[0]
    raise FormulaError(f"{shape_name(a)} and {shape_name(b)} have no cross product")


@_for_each
def dotted(a: FormulaValue, b: FormulaValue) -> FormulaValue:
    """Dot product a · b of two vectors."""
    if rank(a) != 1 or rank(b) != 1 or len(a) != len(b):
        raise FormulaError(f"{shape_name(a)} and {shape_name(b)} have no dot product")
    return reduce(lambda x, y: x + y, (x * y for x, y in zip(a, b, strict=True)))


# ---------------------------------------------------------------- functions and powers
def _raised(base: FormulaValue, exponent: int) -> FormulaValue:
    """The base to an integer power: -1 of a matrix is its inverse, r² of a vector r·r."""
    if isinstance(base, Each):
        return Each(_raised(x, exponent) for x in base)
    match rank(base), exponent:
        case 2, -1:
            return plain(np.linalg.inv(_in_numbers(base)))
        case 1, 2:
            return dotted(base, base)
        case 0, -1:
            return 1 / base
        case 0, _:
            return base**exponent
    raise FormulaError(f"{shape_name(base)} has no power {exponent}")


def _in_numbers(x: FormulaValue) -> Array:
    """A matrix of numbers as an array; raises an error if it contains symbols."""
    if any(isinstance(entry, Trig | Composed) for row in x for entry in row):
        raise FormulaError(f"{shape_name(x)} of polynomials is not inverted here; give it numbers")
    return np.array(x, dtype=float)


def _determinant(x: FormulaValue) -> FormulaValue:
    if len(x) == 2:
        return x[0][0] * x[1][1] - x[0][1] * x[1][0]
    return float(np.linalg.det(_in_numbers(x)))


def _added(x: FormulaValue) -> FormulaValue:
    if not isinstance(x, Each):
        raise FormulaError("∑ needs a value for each body")
    return reduce(plus, x)


def _norm(x: FormulaValue) -> FormulaValue:
    return elementary.sqrt(dotted(x, x))


def _diagonal(x: FormulaValue) -> FormulaValue:
    return tuple(tuple(d if i == j else 0.0 for j in range(len(x))) for i, d in enumerate(x))


def _skew(x: FormulaValue) -> FormulaValue:
    """The skew-symmetric matrix of x, for the cross product x × …."""
    a, b, c = x
    return ((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0))


_FUNCTIONS: dict[str, Any] = {
    "sin": elementary.sin, "cos": elementary.cos, "tan": tan, "sqrt": elementary.sqrt,
    "exp": elementary.exp, "log": elementary.log, "sgn": elementary.sign,
    "arcsin": math.asin, "arccos": math.acos, "arctan": math.atan,
    "norm": _norm, "atan2": lambda yx: math.atan2(*yx), "det": _determinant, "∑": _added,
    "diag": _diagonal, "skew": _skew,
}  # fmt: skip


def _derivative(node: Derivative, at: Any) -> FormulaValue:
    return _slope(at(node.of), _variable(at(node.by)) if node.partial else None)


def _variable(x: FormulaValue) -> str:
    """The name of a value that is a single symbol of a ring."""
    names = x.ring.names if isinstance(x, Trig) else x.variables if isinstance(x, Composed) else ()
    for name in names:
        if x == (x.ring[name] if isinstance(x, Trig) else Composed.variable(name)):
            return name
    raise FormulaError("a partial derivative is taken by a coordinate, a rate or a parameter")


def _slope(x: FormulaValue, by: str | None) -> FormulaValue:
    """The partial derivative of a value by a symbol, or its time derivative."""
    if rank(x):
        return tuple(_slope(entry, by) for entry in x)
    if isinstance(x, Composed):
        return x.derivative(by or "t")
    if not isinstance(x, Trig):
        raise FormulaError("only exact polynomials are differentiated")
    return x.derivative(by) if by is not None else x.along(time_rates(x.ring))


def time_rates(ring: TrigRing) -> dict[str, Trig]:
    """The time derivative of each coordinate and rate of a ring."""
    first = {x: ring[x + RATE] for x in ring.names if x + RATE in ring.index}
    return first | {x + RATE: ring[x + SECOND] for x in ring.names if x + SECOND in ring.index}


def divided(a: FormulaValue, b: FormulaValue) -> FormulaValue:
    """The quotient a / b of anything and a scalar; exact for integers."""
    if isinstance(a, tuple):
        return type(a)(divided(x, b) for x in a)
    if rank(b):
        raise FormulaError(f"{shape_name(b)} cannot be divided by")
    return Fraction(a, b) if isinstance(a, int) and isinstance(b, int) else a / b


def _applied(function: Any, x: FormulaValue, name: str) -> FormulaValue:
    """A function applied to a value, or to each of several bodies' values; a sum takes them
    together."""
    return Each(map(function, x)) if isinstance(x, Each) and name != "∑" else function(x)


def _stacked(entries: list[FormulaValue]) -> FormulaValue:
    """A vector of the entries; if these are given for several bodies, one vector for each body."""
    counts = {len(x) for x in entries if isinstance(x, Each)}
    if not counts:
        return tuple(entries)
    rows = [x if isinstance(x, Each) else Each((x,) * max(counts)) for x in entries]
    return Each(zip(*rows, strict=True))


_RULES: Rules = {
    **arithmetic(
        lambda number: int(number) if number.denominator == 1 else number,
        total=lambda terms: reduce(plus, terms),
        product=lambda factors: reduce(multiplied, factors),
        negative=minus,
        quotient=divided,
        power=_raised,
    ),
    Transposed: lambda node, at: transposed(at(node.operand)),
    Function: lambda node, at: _applied(_FUNCTIONS[node.name], at(node.argument), node.name),
    Cross: lambda node, at: crossed(at(node.left), at(node.right)),
    Derivative: _derivative,
    Dot: lambda node, at: dotted(at(node.left), at(node.right)),
    Arguments: lambda node, at: tuple(map(at, node.entries)),
    Vector: lambda node, at: _stacked(list(map(at, node.entries))),
    Matrix: lambda node, at: tuple(tuple(map(at, row)) for row in node.rows),
}


def typical(
    names: Sequence[str], given: Mapping[str, float | None] | None = None
) -> dict[str, float]:
    """A typical value for each symbol; given values are kept."""
    return {
        name: typical_value(name, (given or {}).get(name), 0, k) for k, name in enumerate(names)
    }


def occurs(name: str, x: Trig) -> bool:
    """Whether a polynomial contains a symbol, or its sine or cosine."""
    index, degrees = x.ring.index, x.poly.degrees()
    return any(n in index and degrees[index[n]] > 0 for n in (name, *waves_of(name)))


def typical_value(name: str, given: float | None, shift: int, k: int) -> float:
    """The model's value of a symbol; otherwise a value of typical size."""
    if given is not None:
        return given
    own = atom(name)
    number = (int(own.figures) if own.is_numbered else k) - 1 + shift
    if own.is_numbered and own.dots:
        return (_TYPICAL_RATES if own.dots == 1 else _TYPICAL_SECONDS)[number % 4]
    if own.is_numbered and own.letter in _TYPICAL:
        return _TYPICAL[own.letter][number % 4]
    return 9.81 if name == "g" else round(0.3 + 0.17 * (number % 5), 2)
