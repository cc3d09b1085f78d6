"""Quotients of polynomials in answers: arithmetic, and equality by cross multiplication; and two
leaves, beside those of `nodes`, of the trees that answers are read as."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

from freebody.errors import FreebodyError
from freebody.expressions.nodes import Expression
from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.linear_equations import Ratio

Value = Trig | Ratio
"""The value of an answer: a polynomial, or a quotient that is none."""

Times = Callable[[Trig, Trig], Trig]
"""A product, within the limits of who multiplies."""


def pair(x: Value) -> tuple[Trig, Trig]:
    """The numerator and denominator of a value."""
    return (x.above, x.below) if isinstance(x, Ratio) else (x, _one(x))


def over(above: Trig, below: Trig) -> Value:
    """The quotient above / below, as a polynomial if the division is exact; below is not 0."""
    if above.is_zero:
        return above
    try:
        return above / below
    except FreebodyError:
        return Ratio(above, below)


def _multiplied(a: Trig, b: Trig) -> Trig:
    found = a * b
    return found if isinstance(found, Trig) else a - a


def plus(a: Value, b: Value, times: Times = _multiplied) -> Value:
    """Sum a + b of polynomials or quotients."""
    if isinstance(a, Trig) and isinstance(b, Trig):
        return a + b
    (p, q), (r, s) = pair(a), pair(b)
    return over(p + r, q) if q == s else over(times(p, s) + times(r, q), times(q, s))


def times(a: Value, b: Value, product: Times = _multiplied) -> Value:
    """Product a b of polynomials or quotients."""
    if isinstance(a, Trig) and isinstance(b, Trig):
        return product(a, b)
    (p, q), (r, s) = pair(a), pair(b)
    return over(product(p, r), product(q, s))


def negative(a: Value) -> Value:
    """Opposite -a of a polynomial or quotient."""
    return Ratio(-a.above, a.below) if isinstance(a, Ratio) else -a


def inverted(a: Value) -> Value:
    """Inverse 1/a of a polynomial or quotient that is not 0."""
    above, below = pair(a)
    return over(below, above)


def slope(x: Value, along: Callable[[Trig], Trig]) -> Value:
    """The derivative of a polynomial or quotient; `along` differentiates polynomials."""
    if isinstance(x, Trig):
        return along(x)
    above, below = pair(x)
    return over(along(above) * below - above * along(below), below * below)


def difference(a: Value, b: Value) -> Trig:
    """The numerator of a - b, which is 0 if they are equal."""
    (p, q), (r, s) = pair(a), pair(b)
    return p - r if q == s else _multiplied(p, s) - _multiplied(r, q)


def put(x: Trig, images: Mapping[str, Value]) -> Value:
    """A polynomial with values substituted for some generators."""
    by_below: dict[Trig, Trig] = {}
    for powers, coefficient in x.terms():
        rest = {name: k for name, k in powers.items() if name not in images}
        term: Value = x.ring.polynomial([(rest, coefficient)])
        for name in (x for x in powers if x in images):
            for _ in range(powers[name]):
                term = times(term, images[name])
        above, below = pair(term)
        by_below[below] = by_below.get(below, x - x) + above
    total: Value = x - x
    for below, above in by_below.items():
        total = plus(total, over(above, below))
    return total


def _one(x: Trig) -> Trig:
    return Trig(x.ring, x.ring.constant(1), 0)


def generator(x: Value) -> str | None:
    """The generator that a polynomial consists of; None if it is anything else."""
    terms = list(x.terms()) if isinstance(x, Trig) else []
    if len(terms) != 1 or terms[0][1] != 1 or sum(terms[0][0].values()) != 1:
        return None
    return next(iter(terms[0][0]))


Angle = tuple[tuple[str, int], ...]
"""A sum of angles: names and whole factors."""


class Named(Expression):
    """A leaf of an expression tree: a name with its value."""

    name: str
    value: Value
    is_derivative: bool = False
    """Whether it is a derivative, named as it is written."""
    is_generator: bool = False
    """Whether the name is the ring's own for the value."""


class Wave(Expression):
    """A leaf of an expression tree: the sin or cos of a sum of angles and a constant."""

    function: str
    angle: Angle
    turn: Fraction = Fraction(0)
