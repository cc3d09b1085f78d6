"""The exact polynomial that a tree stands for, within limits that keep hostile input harmless."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NoReturn

from freebody.derivations.check.source import Source
from freebody.derivations.check.tree import (
    Angle,
    Negative,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    Table,
    Wave,
)
from freebody.errors import FreebodyError
from freebody.scalars.trig import Trig, TrigRing

MOST_TERMS, MOST_WORK = 20_000, 2_000_000
"""Terms of a product multiplied out, and products of two terms on the way there."""

HIGHEST_DEGREE, LARGEST_EXPONENT, MOST_TURNS, MOST_BITS = 60, 12, 12, 500


@dataclass
class Reader:
    """Trees into polynomials of a ring."""

    source: Source
    ring: TrigRing
    work: int = 0
    rules: dict[type, Callable[..., Trig]] = field(init=False)

    def __post_init__(self) -> None:
        self.rules = {
            Number: lambda node: self.constant(node.value),
            Symbol: lambda node: node.value,
            Wave: lambda node: self._wave(node),
            Sum: self._sum,
            Product: self._product,
            Negative: lambda node: -self.read(node.operand),
            Power: self._power,
            Quotient: self._quotient,
            Table: self._table,
        }

    def read(self, node: Node) -> Trig:
        """The polynomial of a tree."""
        return self.rules[type(node)](node)

    def constant(self, value: Fraction) -> Trig:
        """A number."""
        return Trig(self.ring, self.ring.constant(value), 0)

    def _wave(self, node: Wave) -> Trig:
        angle = self.constant(node.turn)
        for name, factor in node.angle:
            angle = angle + self.ring[name] * factor
        x = angle.sin() if node.function == "sin" else angle.cos()
        return x if isinstance(x, Trig) else self.constant(Fraction(x))

    def _sum(self, node: Sum) -> Trig:
        total = self.read(node.terms[0])
        for term in node.terms[1:]:
            total = total + self.read(term)
        return self._checked(total, node)

    def _product(self, node: Product) -> Trig:
        total = self.read(node.factors[0])
        for factor in node.factors[1:]:
            total = self._times(total, self.read(factor), node)
        return total

    def _power(self, node: Power) -> Trig:
        base = self.read(node.base)
        total = self.constant(Fraction(1))
        for _ in range(node.exponent):
            total = self._times(total, base, node)
        return total

    def _quotient(self, node: Quotient) -> Trig:
        above, below = self.read(node.above), self.read(node.below)
        if below.is_zero:
            self.source.fail("division by zero", node.below.span)
        try:
            return self._checked(above / below, node)
        except FreebodyError:
            self.source.fail(
                f"division by {self.source[node.below.span]}: the answer must be a polynomial in "
                f"the symbols, "
                "with numbers only below a fraction bar",
                node.below.span,
            )

    def _table(self, node: Table) -> NoReturn:
        self.source.fail("a vector or matrix stands where one expression is expected", node.span)

    def _times(self, a: Trig, b: Trig, node: Node) -> Trig:
        self.work += len(a) * len(b)
        if len(a) and len(b) and a.poly.total_degree() + b.poly.total_degree() > HIGHEST_DEGREE:
            self.source.fail(f"more than {HIGHEST_DEGREE} symbols are multiplied here", node.span)
        if self.work > MOST_WORK:
            self.source.fail("multiplied out, this has too many terms to compare", node.span)
        product = a * b
        return self._checked(
            product if isinstance(product, Trig) else self.constant(Fraction(0)), node
        )

    def _checked(self, x: Trig, node: Node) -> Trig:
        if len(x) > MOST_TERMS:
            self.source.fail("multiplied out, this has too many terms to compare", node.span)
        if (
            len(x)
            and max(abs(x.leading_coefficient.numerator), x.leading_coefficient.denominator)
            >> MOST_BITS
        ):
            self.source.fail("this number is too large", node.span)
        return x

    def angle(self, node: Node) -> tuple[Angle, Fraction]:
        """A tree as sum of whole multiples of angles and a constant."""
        multiples: list[tuple[str, int]] = []
        turn = Fraction(0)
        for powers, coefficient in self.read(node).terms():
            if not powers:
                turn = coefficient
                continue
            name = next(iter(powers))
            if powers != {name: 1} or name not in self.ring.angles:
                self.source.fail(
                    "sin and cos need a sum of angles: close the bracket behind the angle, "
                    "and put powers before it, cos²(θ) or cos^2(theta)",
                    node.span,
                )
            if coefficient.denominator != 1:
                self.source.fail(
                    "sin and cos of a fraction of an angle are not used here", node.span
                )
            multiples.append((name, int(coefficient)))
        if sum(abs(k) for _, k in multiples) > MOST_TURNS or abs(turn) > 1000:
            self.source.fail("a multiple of an angle this large is not read", node.span)
        return tuple(sorted(multiples, key=lambda row: self.ring.angles.index(row[0]))), turn
