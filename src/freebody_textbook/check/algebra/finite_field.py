"""Values of polynomials at a random point of a finite field: equal polynomials agree, others differ
almost surely.

Sines and cosines are points of the circle, so that all their identities hold. Repairs of an answer
are looked for here, thousands in a moment; the verdict itself is exact.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from typing import Any

from freebody.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.expressions.nodes import Expression, Negative, Power, Product, Quotient, Sum, nodes
from freebody.lazy import cached_property
from freebody.scalars.generators import WAVES, function_of, symbol_of
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import TrigRing
from freebody_textbook.check.algebra.quotients import Angle, Named, Value, Wave, pair
from freebody_textbook.closed_chains.linear_equations import Ratio

PRIME = 2**61 - 1
_POINTS_OF_SQUARE = 40
"""Points at which a square is told from other trees."""

SineAndCosine = tuple[int, int]
"""Sine and cosine of an angle, in the field."""


def residue(value: Fraction | int) -> int:
    """The residue of a rational number modulo PRIME."""
    value = Fraction(value)
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def raised(base: int, exponent: int) -> int:
    """The power base^exponent modulo PRIME; a negative power of 0 is 0, since no correct answer
    divides by 0."""
    return pow(base, exponent, PRIME) if base % PRIME or exponent >= 0 else 0


def plus(a: SineAndCosine, b: SineAndCosine) -> SineAndCosine:
    """The sine and cosine, modulo PRIME, of the sum of two angles."""
    return (a[0] * b[1] + a[1] * b[0]) % PRIME, (a[1] * b[1] - a[0] * b[0]) % PRIME


@dataclass(frozen=True)
class Point:
    """A point of the finite field: values of all names, and of the sine and cosine of each
    angle."""

    values: Mapping[str, int]
    turns: Mapping[str, SineAndCosine]

    def changed(
        self,
        values: Mapping[str, int] | None = None,
        turns: Mapping[str, SineAndCosine] | None = None,
    ) -> Point:
        """A copy of the point with other values of some names or angles."""
        return replace(
            self, values={**self.values, **(values or {})}, turns={**self.turns, **(turns or {})}
        )

    def agree(self, a: int, b: int) -> bool:
        """Whether two field values are equal."""
        return (a - b) % PRIME == 0

    def number(self, value: Fraction | int) -> int:
        """The residue of a rational number."""
        return residue(value)

    def plus(self, a: SineAndCosine, b: SineAndCosine) -> SineAndCosine:
        """Sine and cosine at the point of the sum of two angles."""
        return plus(a, b)

    def of(self, x: Value) -> int:
        """The value at the point of a polynomial or a quotient of two."""
        if isinstance(x, Ratio):
            return self.of(x.above) * raised(self.of(x.below), -1) % PRIME
        return sum(self.term(powers, c) for powers, c in x.terms()) % PRIME

    def term(self, powers: Mapping[str, int], coefficient: Fraction) -> int:
        """The value at the point of one term of a polynomial."""
        total = residue(coefficient)
        for name, exponent in powers.items():
            total = total * pow(self.generator(name), exponent, PRIME) % PRIME
        return total

    def generator(self, name: str) -> int:
        """The value at the point of a ring generator: sin_…, cos_… or a name."""
        function, angle = function_of(name), symbol_of(name)
        if function not in WAVES or angle not in self.turns:
            return self.values[name]
        return self.turns[angle][WAVES.index(function)]

    def turn(self, angle: Angle, constant: Fraction = Fraction(0)) -> SineAndCosine:
        """(sin, cos) at the point of a sum of angles and a constant."""
        total: SineAndCosine = (0, 1)
        for name, factor in angle:
            s, c = self.turns[name]
            for _ in range(abs(factor)):
                total = plus(total, (s if factor > 0 else PRIME - s, c))
        if constant:
            s, c = rational_sin_cos(float(constant))
            total = plus(total, (residue(s), residue(c)))
        return total

    def at(self, node: Expression, known: Mapping[Expression, int] | None = None) -> int:
        """The value at the point of an expression tree; known: values of some of its nodes."""
        return evaluate(node, self._rules, known) % PRIME

    @cached_property
    def _rules(self) -> Rules:
        return {
            **arithmetic(
                residue,
                total=sum,
                product=lambda factors: reduce(lambda a, b: a * b % PRIME, factors),
                quotient=lambda a, b: a * raised(b, -1),
                power=raised,
            ),
            Named: lambda node, at: (
                self.values[node.name] if node.is_generator else self.of(node.value)
            ),
            Wave: lambda node, at: self.turn(node.angle, node.turn)[node.function == "cos"],
        }


def random_point(ring: TrigRing, seed: int = 0) -> Point:
    """A random point of the finite field for a ring's names."""
    chance = random.Random(f"freebody {seed}")
    values = {name: chance.randrange(2, PRIME) for name in ring.names}
    turns = {}
    for name in ring.angles:
        t = chance.randrange(2, PRIME)
        scale = pow(1 + t * t, -1, PRIME)
        turns[name] = (2 * t * scale % PRIME, (1 - t * t) * scale % PRIME)
    return Point(values, turns)


def is_square(ring: TrigRing, node: Expression) -> bool:
    """Whether an expression without functions is a number times a square: its values at random
    points are then all quadratic residues or all non-residues."""
    values = (random_point(ring, k).at(node) for k in range(_POINTS_OF_SQUARE))
    return len({pow(x, (PRIME - 1) // 2, PRIME) for x in values if x}) == 1


def rational(value: int) -> Fraction | None:
    """The fraction with numerator and denominator of at most 1000 that has a given residue; None if
    there is none."""
    largest = 1000
    a, b, u, v = PRIME, value % PRIME, 0, 1
    while b > largest:
        q = a // b
        a, b, u, v = b, a - q * b, v, u - q * v
    if v == 0 or abs(v) > largest:
        return None
    return Fraction(b, v)


@dataclass(frozen=True)
class RealPoint(Point):
    """A point with real values, the numbers of a state; names without a value are NaN, which equals
    nothing."""

    values: Mapping[str, Any]
    turns: Mapping[str, Any]
    slack: float = 0.0
    """Largest difference of two numbers that count as equal."""

    @classmethod
    def of_state(cls, ring: TrigRing, state: Mapping[str, float]) -> RealPoint:
        """The point with a state's values of the names; cos 90° is exactly 0."""
        values = {name: state.get(name, math.nan) for name in ring.names}
        turns = {
            name: tuple(map(float, rational_sin_cos(x))) if math.isfinite(x) else (x, x)
            for name in ring.angles
            for x in (values[name],)
        }
        return cls(values, turns)

    def agree(self, a: Any, b: Any) -> bool:
        return abs(a - b) <= self.slack

    def number(self, value: Fraction | int) -> Any:
        return float(value)

    def plus(self, a: Any, b: Any) -> Any:
        return a[0] * b[1] + a[1] * b[0], a[1] * b[1] - a[0] * b[0]

    def of(self, x: Value) -> Any:
        above, below = (
            math.fsum(self.term(powers, c) for powers, c in part.terms()) for part in pair(x)
        )
        return above / below if below else math.nan

    def term(self, powers: Mapping[str, int], coefficient: Fraction) -> Any:
        factors = [self.generator(x) for x in powers]
        if 0.0 in factors:  # whatever the others are
            return 0.0
        return float(coefficient) * math.prod(
            x**k for x, k in zip(factors, powers.values(), strict=True)
        )


class Workspace:
    """An expression tree with the values of all its nodes at a point."""

    def __init__(self, root: Expression, point: Point):
        self.root, self.point = root, point
        self.values: dict[Expression, int] = {}
        """The value of each node, those inside others first."""
        for node in _inner_first(root):
            self.values[node] = point.at(node, self.values)
        self.value = self.values[root]
        self.parents: dict[Expression, Expression] = {
            part: node for node in nodes(root) for part in node.parts
        }

    @cached_property
    def cofactors(self) -> dict[Expression, int]:
        """Cofactor of each factor in a product: the product of the others."""
        found: dict[Expression, int] = {}
        for node in self.values:
            if isinstance(node, Product):
                before = 1
                for factor in node.factors:
                    found[factor] = before
                    before = before * self.values[factor] % PRIME
                after = 1
                for factor in reversed(node.factors):
                    found[factor] = found[factor] * after % PRIME
                    after = after * self.values[factor] % PRIME
        return found

    @cached_property
    def slopes(self) -> dict[Expression, int | None]:
        """Derivative of the whole expression by each node's value; None below a power or in a
        denominator, where it is not linear."""
        found: dict[Expression, int | None] = {self.root: 1}
        for node in nodes(self.root):
            whole = found[node]
            for part in node.parts:
                own = None if whole is None else self._slope(node, part)
                if whole is None or own is None:
                    found[part] = None
                else:
                    found[part] = whole * own % PRIME
        return found

    def _slope(self, node: Expression, part: Expression) -> int | None:
        """Derivative of a node's value by the value of one of its parts; None if it is not
        linear."""
        match node:
            case Sum():
                return 1
            case Negative():
                return -1
            case Product():
                return self.cofactors[part]
            case Quotient() if part is node.above:
                return pow(self.values[node.below], -1, PRIME)
        return None

    def with_value(self, node: Expression, value: int) -> int:
        """The value of the whole expression if a node had another value."""
        while (slope := self.slopes[node]) is None:
            parent = self.parents[node]
            value = self._above(parent, node, value) % PRIME
            node = parent
        return (self.value + slope * (value - self.values[node])) % PRIME

    def _above(self, parent: Expression, node: Expression, value: int) -> int:
        """The value of `parent` if `node`, one of its parts, had `value`."""
        slope = self._slope(parent, node)
        if slope is not None:
            return self.values[parent] + slope * (value - self.values[node])
        match parent:
            case Power():
                return raised(value, parent.exponent)
            case Quotient():
                return self.values[parent.above] * raised(value, -1)
        raise TypeError(type(parent).__name__)

    def addends(self) -> Iterator[Expression]:
        """The terms of all sums, also of sums in brackets, and the whole expression."""
        yield self.root
        for node in self.values:
            if isinstance(node, Sum):
                yield from node.terms

    def addend_of(self, node: Expression) -> Expression:
        """The smallest term of a sum that contains a node; the whole expression if no sum contains
        it."""
        while node is not self.root and not isinstance(self.parents[node], Sum):
            node = self.parents[node]
        return node


class _Nowhere(Point):
    """A point at which every value is 0, for analysing only the structure of an expression."""

    def at(self, node: Expression, known: object = None) -> int:
        return 0


def without_values(tree: Expression) -> Workspace:
    """The structure of an expression, its nodes and their parents, without values."""
    return Workspace(tree, _Nowhere({}, {}))


def _inner_first(node: Expression) -> Iterator[Expression]:
    for part in node.parts:
        yield from _inner_first(part)
    yield node
