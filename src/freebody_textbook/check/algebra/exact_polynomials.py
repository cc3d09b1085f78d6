"""The exact polynomial, or quotient of two, of an expression tree, with limits that keep malicious
input harmless."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce

from freebody.expressions.evaluate import NoValue, Rules, arithmetic, evaluate
from freebody.expressions.grammar.parser import PI
from freebody.expressions.grammar.source import Source
from freebody.expressions.nodes import Expression, Function, Matrix, Power, Quotient
from freebody.scalars.trig import Trig, TrigRing
from freebody_textbook.check.algebra.quotients import (
    Angle,
    Named,
    Value,
    Wave,
    inverted,
    negative,
    pair,
    plus,
    times,
)
from freebody_textbook.closed_chains.linear_equations import Ratio

MOST_TERMS, MOST_WORK = 20_000, 2_000_000
"""Terms of a product multiplied out, and products of two terms on the way there."""

HIGHEST_DEGREE, LARGEST_EXPONENT, MOST_TURNS, MOST_BITS = 60, 12, 12, 500


@dataclass
class PolynomialReader:
    """Converts expression trees into polynomials of a ring."""

    source: Source
    ring: TrigRing
    work: int = 0
    rules: Rules = field(init=False)

    def __post_init__(self) -> None:
        self.rules = {
            **arithmetic(
                self.constant,
                total=lambda terms: _checked(reduce(self._plus, terms)),
                product=self._product,
                negative=negative,
            ),
            Power: lambda node, at: self._power(node, at(node.base)),
            Quotient: lambda node, at: self._quotient(node, at(node.above), at(node.below)),
            Named: lambda node, at: node.value,
            Wave: lambda node, at: self._wave(node),
            Matrix: _no_matrix,
            Function: _no_function,
        }

    def read(self, node: Expression) -> Trig:
        """The polynomial of an expression tree."""
        found = self.quotient(node)
        if isinstance(found, Trig):
            return found
        self.source.fail(
            "this quotient is not a polynomial, and a polynomial is needed: write only numbers "
            "below a fraction bar",
            node.span,
        )

    def quotient(self, node: Expression) -> Value:
        """The polynomial of an expression tree, or the quotient of two."""
        try:
            return evaluate(node, self.rules)
        except NoValue as problem:
            self.source.fail(problem.problem, (problem.node or node).span)

    def constant(self, value: Fraction) -> Trig:
        """The constant polynomial of a number."""
        return Trig(self.ring, self.ring.constant(value), 0)

    def _wave(self, node: Wave) -> Trig:
        angle = self.constant(node.turn)
        for name, factor in node.angle:
            angle = angle + self.ring[name] * factor
        x = angle.sin() if node.function == "sin" else angle.cos()
        return x if isinstance(x, Trig) else self.constant(Fraction(x))

    def _plus(self, a: Value, b: Value) -> Value:
        return plus(a, b, self._times)

    def _product(self, factors: Iterable[Value]) -> Value:
        found = list(factors) or [self.constant(Fraction(1))]
        return _checked(reduce(lambda a, b: times(a, b, self._times), found))

    def _power(self, node: Power, base: Value) -> Value:
        found = self._product([base] * abs(node.exponent))
        return found if node.exponent >= 0 else self._inverted(node.base, found)

    def _quotient(self, node: Quotient, above: Value, below: Value) -> Value:
        return self._product([above, self._inverted(node.below, below)])

    def _inverted(self, node: Expression, x: Value) -> Value:
        if x.is_zero:
            raise NoValue("division by zero", node)
        return inverted(x)

    def _times(self, a: Trig, b: Trig) -> Trig:
        self.work += len(a) * len(b)
        if len(a) and len(b) and a.poly.total_degree() + b.poly.total_degree() > HIGHEST_DEGREE:
            raise NoValue(f"more than {HIGHEST_DEGREE} symbols are multiplied here")
        if self.work > MOST_WORK:
            raise NoValue("multiplied out, this has too many terms to compare")
        product = a * b
        return _check(product if isinstance(product, Trig) else self.constant(Fraction(0)))

    def angle(self, node: Expression) -> tuple[Angle, Fraction] | None:
        """An expression tree as a sum of integer multiples of angles and a constant turn; None if a
        multiple is not an integer."""
        multiples: list[tuple[str, int]] = []
        turn = Fraction(0)
        for powers, coefficient in self.read(node).terms():
            if not powers:
                turn = coefficient
                continue
            name = next(iter(powers))
            if powers != {name: 1} or name not in self.ring.angles:
                self.source.fail(
                    "sin and cos need a sum of angles: close the bracket after the angle, "
                    "and put powers before it, cos²(θ) or cos^2(theta)",
                    node.span,
                )
            if coefficient in (PI / 180, 180 / PI):
                self.source.fail("angles are in radians here: leave π/180 out", node.span)
            if coefficient.denominator != 1:
                return None
            multiples.append((name, int(coefficient)))
        if sum(abs(k) for _, k in multiples) > MOST_TURNS or abs(turn) > 1000:
            self.source.fail("a multiple of an angle this large is not read", node.span)
        return tuple(sorted(multiples, key=lambda row: self.ring.angles.index(row[0]))), turn


def _no_function(node: Function, at: object) -> Trig:
    raise NoValue(
        f"{node.name} does not occur in these equations: write them with sin and cos; by it "
        "coordinates are told, as in θ2 = arccos(…)",
        node,
    )


def _no_matrix(node: Matrix, at: object) -> Trig:
    raise NoValue("a vector or matrix stands where one expression is expected", node)


def _checked(x: Value) -> Value:
    for part in pair(x) if isinstance(x, Ratio) else (x,):
        _check(part)
    return x


def _check(x: Trig) -> Trig:
    if len(x) > MOST_TERMS:
        raise NoValue("multiplied out, this has too many terms to compare")
    if len(x) and (
        max(abs(x.leading_coefficient.numerator), x.leading_coefficient.denominator) >> MOST_BITS
    ):
        raise NoValue("this number is too large")
    return x
