"""Values of polynomials at a random point of a finite field: equal polynomials agree, others differ
almost surely.

Sines and cosines are points of the circle, so that all their identities hold. Repairs of an answer
are looked for here, thousands in a moment; the verdict itself is exact.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce

from freebody.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.expressions.nodes import Expression
from freebody.lazy import cached_property
from freebody.scalars.generators import WAVES, function_of, symbol_of
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import TrigRing
from freebody_textbook.check.algebra.answer_tree import Angle, Named, Wave
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.closed_chains.linear import Ratio

PRIME = 2**61 - 1

SineAndCosine = tuple[int, int]
"""(sin, cos) of an angle."""


def residue(value: Fraction | int) -> int:
    """A rational number in the field."""
    value = Fraction(value)
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def raised(base: int, exponent: int) -> int:
    """A power; of 0 a negative one is 0, as no answer that divides by it is right."""
    return pow(base, exponent, PRIME) if base % PRIME or exponent >= 0 else 0


def plus(a: SineAndCosine, b: SineAndCosine) -> SineAndCosine:
    """The sum of two angles."""
    return (a[0] * b[1] + a[1] * b[0]) % PRIME, (a[1] * b[1] - a[0] * b[0]) % PRIME


@dataclass(frozen=True)
class Point:
    """Values of all names, and of the sine and cosine of each angle."""

    values: Mapping[str, int]
    turns: Mapping[str, SineAndCosine]

    def changed(
        self,
        values: Mapping[str, int] | None = None,
        turns: Mapping[str, SineAndCosine] | None = None,
    ) -> Point:
        """Another point that differs in some names or angles."""
        return replace(
            self, values={**self.values, **(values or {})}, turns={**self.turns, **(turns or {})}
        )

    def agree(self, a: int, b: int) -> bool:
        """Whether two values are equal."""
        return (a - b) % PRIME == 0

    def number(self, value: Fraction | int) -> int:
        """A rational number."""
        return residue(value)

    def plus(self, a: SineAndCosine, b: SineAndCosine) -> SineAndCosine:
        """The sum of two angles."""
        return plus(a, b)

    def of(self, x: Value) -> int:
        """The value of a polynomial or a quotient of two."""
        if isinstance(x, Ratio):
            return self.of(x.above) * raised(self.of(x.below), -1) % PRIME
        return sum(self.term(powers, c) for powers, c in x.terms()) % PRIME

    def term(self, powers: Mapping[str, int], coefficient: Fraction) -> int:
        """The value of one term."""
        total = residue(coefficient)
        for name, exponent in powers.items():
            total = total * pow(self.generator(name), exponent, PRIME) % PRIME
        return total

    def generator(self, name: str) -> int:
        """The value of sin_…, cos_… or a name."""
        function, angle = function_of(name), symbol_of(name)
        if function not in WAVES or angle not in self.turns:
            return self.values[name]
        return self.turns[angle][WAVES.index(function)]

    def turn(self, angle: Angle, constant: Fraction = Fraction(0)) -> SineAndCosine:
        """(sin, cos) of a sum of angles."""
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
        """The value of a tree; `known`: the values of some of its nodes."""
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
    """A random point of a ring."""
    chance = random.Random(f"freebody {seed}")
    values = {name: chance.randrange(2, PRIME) for name in ring.names}
    turns = {}
    for name in ring.angles:
        t = chance.randrange(2, PRIME)
        scale = pow(1 + t * t, -1, PRIME)
        turns[name] = (2 * t * scale % PRIME, (1 - t * t) * scale % PRIME)
    return Point(values, turns)


def rational(value: int, largest: int = 1000) -> Fraction | None:
    """The fraction with small numerator and denominator that a residue stands for, if there is
    one."""
    a, b, u, v = PRIME, value % PRIME, 0, 1
    while b > largest:
        q = a // b
        a, b, u, v = b, a - q * b, v, u - q * v
    if v == 0 or abs(v) > largest:
        return None
    return Fraction(b, v)
