"""Expressions as they are printed: a small immutable tree, and plain functions that build it.

Nothing here simplifies; the exact mathematics is in `scalars.trig`. What the functions do is what a
printed line needs: sums and products are flat, a sign stands in front, a number first, zeros and
ones vanish.

Wherever an expression is expected, a number or the name of a symbol will do:
`eq("tau1", add(mul("I1", "omega1_d"), "tau2"))`.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from numbers import Rational

from freebody.expressions.nodes import (
    Arguments,
    Cross,
    Derivative,
    Dot,
    Equation,
    Expression,
    Function,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    Transposed,
    Vector,
    Words,
    nodes,
)
from freebody.expressions.printed_names import sym

Like = Expression | Rational | int | str
"""An expression, a number, or the name of a symbol."""

ZERO, ONE = Number(Fraction(0)), Number(Fraction(1))


# ---------------------------------------------------------------- building
def expr(x: Like) -> Expression:
    """A number, name or expression as an expression."""
    if isinstance(x, Expression):
        return x
    if isinstance(x, str):
        return sym(x)
    return Number(Fraction(x))


def num(value: Rational | int, decimal: bool = False) -> Expression:
    """A number, its sign in front."""
    exact = Fraction(value)
    return Number(exact, decimal) if exact >= 0 else Negative(Number(-exact, decimal))


def neg(x: Like) -> Expression:
    """The expression -x; the operand where x is itself a negative."""
    x = expr(x)
    if isinstance(x, Negative):
        return x.operand
    return num(-x.value, x.decimal) if isinstance(x, Number) else Negative(x)


def add(*terms: Like) -> Expression:
    """Sum of terms, in the order given."""
    flat: list[Expression] = []
    for term in map(expr, terms):
        flat += term.terms if isinstance(term, Sum) else (term,) if term != ZERO else ()
    return ZERO if not flat else flat[0] if len(flat) == 1 else Sum(tuple(flat))


def neg_each(x: Like) -> Expression:
    """The opposite -x of an expression; a sum is negated term by term."""
    x = expr(x)
    return add(*map(neg, x.terms)) if isinstance(x, Sum) else neg(x)


def sub(a: Like, b: Like) -> Expression:
    """The difference a - b; a sum b keeps its brackets."""
    return add(a, neg(b)) if expr(b) != ZERO else expr(a)


def mul(*factors: Like) -> Expression:
    """Product: sign and number in front, then the factors in the order given."""
    value, decimal = Fraction(1), False
    rest: list[Expression] = []
    for factor in _factors(map(expr, factors)):
        if isinstance(factor, Number):
            value, decimal = value * factor.value, decimal or factor.decimal
        else:
            rest.append(factor)
    if value == 0:
        return ZERO
    number = Number(abs(value), decimal)
    if rest and number.value == 1:
        product = rest[0] if len(rest) == 1 else Product(tuple(rest))
    else:
        product = Product((number, *rest)) if rest else number
    return product if value > 0 else Negative(product)


def _factors(factors: Iterable[Expression]) -> Iterable[Expression]:
    """Single factors of products, with a minus sign as a factor -1 of its own."""
    for factor in factors:
        if isinstance(factor, Negative):
            yield Number(Fraction(-1))
            yield from _factors((factor.operand,))
        elif isinstance(factor, Product):
            yield from factor.factors
        else:
            yield factor


def div(a: Like, b: Like) -> Expression:
    """a / b as a fraction, the sign of a in front."""
    a, b = expr(a), expr(b)
    if isinstance(a, Negative):
        return Negative(div(a.operand, b))
    return a if b == ONE else Quotient(a, b)


def power(base: Like, exponent: int) -> Expression:
    """Power base ** exponent."""
    return expr(base) if exponent == 1 else ONE if exponent == 0 else Power(expr(base), exponent)


def sin(x: Like) -> Expression:
    """Sine of an expression."""
    return Function("sin", expr(x))


def cos(x: Like) -> Expression:
    """Cosine of an expression."""
    return Function("cos", expr(x))


def sgn(x: Like) -> Expression:
    """Sign of an expression."""
    return Function("sgn", expr(x))


def d_dt(x: Like) -> Expression:
    """Time derivative, written d/dt."""
    return Derivative(expr(x), Symbol("t", "t"))


def partial(of: Like, by: Like) -> Expression:
    """Partial derivative ∂of/∂by."""
    return Derivative(expr(of), expr(by), partial=True)


def cross(a: Like, b: Like) -> Expression:
    """Cross product a × b; 0 where a or b is 0."""
    x, y = expr(a), expr(b)
    return ZERO if ZERO in (x, y) else Cross(x, y)


def dot(a: Like, b: Like) -> Expression:
    """Dot product a · b; 0 where a or b is 0."""
    x, y = expr(a), expr(b)
    return ZERO if ZERO in (x, y) else Dot(x, y)


def transposed(x: Like) -> Expression:
    """Transpose xᵀ of an expression."""
    return Transposed(expr(x))


def vector(*entries: Like) -> Expression:
    """A column vector from its components."""
    return Vector(tuple(map(expr, entries)))


def matrix(rows: Iterable[Iterable[Like]]) -> Expression:
    """A matrix from its rows."""
    return Matrix(tuple(tuple(map(expr, row)) for row in rows))


def words(text: str) -> Expression:
    """Words in an equation, upright."""
    return Words(text)


def arguments(*entries: Like) -> Expression:
    """Several arguments of one function."""
    return Arguments(tuple(map(expr, entries)))


def eq(*sides: Like) -> Equation:
    """Equation of two or more sides: a = b (= c …)."""
    return Equation(tuple(map(expr, sides)))


def chain(*sides: Like) -> Equation:
    """An equation of several sides in which equal sides stand once."""
    return eq(*dict.fromkeys(map(expr, sides)))


# ---------------------------------------------------------------- looking inside
def size(x: Expression) -> int:
    """The number of numbers and symbols in an expression."""
    return sum(isinstance(node, Number | Symbol) for node in nodes(x))


def operations(x: Expression) -> dict[str, int]:
    """The number of additions, multiplications and functions that it takes to evaluate an
    expression as it is printed."""
    count = {"additions": 0, "multiplications": 0, "functions": 0}
    for node in nodes(x):
        if isinstance(node, Sum):
            count["additions"] += len(node.terms) - 1
        elif isinstance(node, Product):
            count["multiplications"] += len(node.factors) - 1
        elif isinstance(node, Power):
            count["multiplications"] += abs(node.exponent) - 1
        elif isinstance(node, Quotient):
            count["multiplications"] += 1
        elif isinstance(node, Function):
            count["functions"] += 1
    return count
