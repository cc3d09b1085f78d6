"""Linear equations over polynomials: minors, null vectors, quotients in lowest terms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import Any

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.arithmetic import PolynomialRows, determinant
from freebody.expressions.polynomials.factors import factored
from freebody.expressions.polynomials.symbols import Symbols
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.scalars.trig import Trig

_WIDE = 24
"""Numbers and symbols up to which a numerator is written over its denominator."""
_FACTORED = 120
"""Terms up to which numerator and denominator are factored to find what cancels."""


@dataclass(frozen=True)
class Ratio:
    """A quotient above / below of polynomials; `below` is 1 if it is a polynomial."""

    above: Trig
    below: Trig

    @property
    def is_zero(self) -> bool:
        """Whether the quotient is 0."""
        return self.above.is_zero

    @property
    def is_polynomial(self) -> bool:
        """Whether there is no denominator."""
        return self.below == 1

    def form(self, layout: Layout) -> Expression:
        """Printed form of the quotient, numerator and denominator factored, with the sign in
        front."""
        above = product(self.above, layout)
        if self.is_polynomial:
            return above
        below = product(self.below, layout)
        if _is_negative(below):
            above, below = product(-self.above, layout), ex.neg_each(below)
        return quotient(above, below)

    def evaluate(self, values: Mapping[str, Any]) -> Any:
        """The quotient's value; infinite or NaN where the denominator vanishes."""
        return self.above.evaluate(values) / self.below.evaluate(values)

    def __str__(self) -> str:
        return str(self.above) if self.is_polynomial else f"({self.above})/({self.below})"


def quotient(above: Expression, below: Expression) -> Expression:
    """A fraction for print; a long numerator is written after 1 / below, so that the line can be
    broken."""
    if isinstance(above, ex.Sum) and all(isinstance(term, ex.Negative) for term in above.terms):
        return ex.neg(quotient(ex.neg_each(above), below))
    if isinstance(above, ex.Negative):
        return ex.neg(quotient(above.operand, below))
    return ex.div(above, below) if ex.size(above) <= _WIDE else ex.mul(ex.div(ex.ONE, below), above)


def _is_negative(x: Expression) -> bool:
    return isinstance(x.terms[0] if isinstance(x, ex.Sum) else x, ex.Negative)


def ratio(above: Trig, below: Trig) -> Ratio:
    """A quotient of polynomials, reduced by the factors that are found."""
    ring = above.ring
    one = Trig(ring, ring.constant(1), 0)
    if above.is_zero:
        return Ratio(above, one)
    above, below = _cancelled(above, below)
    if below.is_constant:
        return Ratio(above / below, one)
    number = _content(above, below)
    return Ratio(above / number, below / number)


def _content(*values: Trig) -> Fraction:
    """The number by which coefficients are divided to become integers without common divisor."""
    coefficients = [c for x in values for _, c in x.terms()]
    return Fraction(
        math.gcd(*(c.numerator for c in coefficients)),
        math.lcm(*(c.denominator for c in coefficients)),
    )


def _cancelled(above: Trig, below: Trig) -> tuple[Trig, Trig]:
    shared = common([above, below])
    above, below = above / shared, below / shared
    if below.is_constant or len(above) + len(below) > _FACTORED:
        return above, below
    (_, one), (_, other) = factored(above), factored(below)
    for factor, exponent in other:
        times = min(exponent, next((e for f, e in one if f == factor), 0))
        for _ in range(times):
            above, below = _over(above, factor, one), _over(below, factor, other)
            one, other = _less(one, factor), _less(other, factor)
    return above, below


def _over(x: Trig, factor: Trig, factors: list[tuple[Trig, int]]) -> Trig:
    """The quotient x / factor, from the factors of x, as polynomial division does not use s² = 1 -
    c²."""
    rest = [f for f, e in _less(factors, factor) for _ in range(e)]
    ring = x.ring
    product_of_rest = reduce(lambda a, b: a * b, rest, Trig(ring, ring.constant(1), 0))
    whole = product_of_rest * factor
    return product_of_rest * (x.leading_coefficient / whole.leading_coefficient)


def _less(factors: list[tuple[Trig, int]], factor: Trig) -> list[tuple[Trig, int]]:
    return [(f, e - (f == factor)) for f, e in factors]


def product(x: Trig, layout: Layout) -> Expression:
    """A polynomial as a product of factors where that is shorter than the sum."""
    plain = layout.form(x)
    if x.is_zero or len(x) > _FACTORED:
        return plain
    number, factors = factored(x)
    if sum(e for _, e in factors) < 2:
        return plain
    oriented = []
    for factor, exponent in sorted(factors, key=lambda row: len(row[0])):
        if layout.order.decimal:  # measured numbers: no whole ones of ten digits
            largest = max(abs(c) for _, c in factor.terms())
            factor, number = factor / largest, number * largest**exponent
        flip = layout.is_negative(factor)
        number = -number if flip and exponent % 2 else number
        oriented.append(ex.power(layout.form(-factor if flip else factor), exponent))
    front = layout.form(Trig(x.ring, x.ring.constant(number), 0))
    return min((plain, ex.mul(front, *oriented)), key=ex.size)


def common(values: Iterable[Trig]) -> Trig:
    """A common divisor of polynomials, with first coefficient 1."""
    nonzero = [x for x in values if not x.is_zero]
    poly = reduce(lambda a, b: a.gcd(b), (x.poly for x in nonzero))
    ring = nonzero[0].ring
    mask = reduce(lambda a, b: a | b, (x.mask for x in nonzero))
    found = Trig(ring, poly, mask)
    return found / found.leading_coefficient


def without_common(row: Sequence[Trig]) -> list[Trig]:
    """A row of coefficients divided by their common divisor."""
    if all(x.is_zero for x in row):
        return list(row)
    shared = common(row)
    rest = [x / shared for x in row]
    number = abs(next(x.leading_coefficient for x in rest if not x.is_zero))
    return [x / number for x in rest]


def solved(
    A: Sequence[Sequence[Trig]], right: Sequence[Sequence[Trig]], s: Symbols
) -> tuple[PolynomialRows, Trig]:
    """(X, Δ) with A X = Δ right, Δ = det A: Cramer's rule, column by column."""
    n = len(A)
    columns = [
        [
            determinant(
                [[right[r][j] if k == i else A[r][k] for k in range(n)] for r in range(n)], s
            )
            for i in range(n)
        ]
        for j in range(len(right[0]) if right else 0)
    ]
    return [[column[i] for column in columns] for i in range(n)], determinant(A, s)


def left_null(S: Sequence[Sequence[Trig]], s: Symbols) -> PolynomialRows | None:
    """Rows w with w S = 0, as many as S (m, p) has more rows than columns; None where its rank is
    below p."""
    m, p = len(S), len(S[0])
    base, delta = _independent(S, s)
    if delta is None:
        return None
    found = []
    for k in (k for k in range(m) if k not in base):
        weights, _ = solved(
            [[S[r][j] for r in base] for j in range(p)], [[S[k][j]] for j in range(p)], s
        )
        row = [s.zero()] * m
        row[k] = delta
        for r, (weight,) in zip(base, weights, strict=True):
            row[r] = -weight
        found.append(without_common(row))
    return found


def _independent(S: Sequence[Sequence[Trig]], s: Symbols) -> tuple[tuple[int, ...], Trig | None]:
    """The p rows with a nonzero determinant that has the fewest terms, and that determinant."""
    best: tuple[tuple[int, ...], Trig | None] = ((), None)
    for rows in combinations(range(len(S)), len(S[0])):
        delta = determinant([S[r] for r in rows], s)
        if not delta.is_zero and (best[1] is None or len(delta) < len(best[1])):
            best = (rows, delta)
    return best
