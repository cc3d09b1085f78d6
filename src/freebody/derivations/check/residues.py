"""Values of polynomials at a random point of a finite field: equal polynomials agree, others differ
almost surely.

Sines and cosines are points of the circle, so that all their identities hold. Repairs of an answer
are looked for here, thousands in a moment; the verdict itself is exact.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

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
    Wave,
)
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import Trig, TrigRing

PRIME = 2**61 - 1

Turn = tuple[int, int]
"""(sin, cos) of an angle."""


def residue(value: Fraction | int) -> int:
    """A rational number in the field."""
    value = Fraction(value)
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def plus(a: Turn, b: Turn) -> Turn:
    """The sum of two angles."""
    return (a[0] * b[1] + a[1] * b[0]) % PRIME, (a[1] * b[1] - a[0] * b[0]) % PRIME


@dataclass(frozen=True)
class Point:
    """Values of all names, and of the sine and cosine of each angle."""

    values: Mapping[str, int]
    turns: Mapping[str, Turn]

    def changed(
        self, values: Mapping[str, int] | None = None, turns: Mapping[str, Turn] | None = None
    ) -> Point:
        """Another point that differs in some names or angles."""
        return Point({**self.values, **(values or {})}, {**self.turns, **(turns or {})})

    def of(self, x: Trig) -> int:
        """The value of a polynomial."""
        return sum(self.term(powers, c) for powers, c in x.terms()) % PRIME

    def term(self, powers: Mapping[str, int], coefficient: Fraction) -> int:
        """The value of one term."""
        total = residue(coefficient)
        for name, exponent in powers.items():
            total = total * pow(self.generator(name), exponent, PRIME) % PRIME
        return total

    def generator(self, name: str) -> int:
        """The value of sin_…, cos_… or a name."""
        kind, _, angle = name.partition("_")
        if kind in ("sin", "cos") and angle in self.turns:
            return self.turns[angle][kind == "cos"]
        return self.values[name]

    def turn(self, angle: Angle, constant: Fraction = Fraction(0)) -> Turn:
        """(sin, cos) of a sum of angles."""
        total: Turn = (0, 1)
        for name, factor in angle:
            s, c = self.turns[name]
            for _ in range(abs(factor)):
                total = plus(total, (s if factor > 0 else PRIME - s, c))
        if constant:
            s, c = rational_sin_cos(float(constant))
            total = plus(total, (residue(s), residue(c)))
        return total

    def at(self, node: Node, known: dict[Node, int] | None = None) -> int:
        """The value of a tree; the values of its nodes are noted in `known`."""
        value = self._at(node, known) % PRIME
        if known is not None:
            known[node] = value
        return value

    def _at(self, node: Node, known: dict[Node, int] | None) -> int:
        match node:
            case Number():
                return residue(node.value)
            case Symbol():
                return self.values[node.name] if node.is_generator else self.of(node.value)
            case Wave():
                return self.turn(node.angle, node.turn)[node.function == "cos"]
            case Sum():
                return sum(self.at(term, known) for term in node.terms)
            case Product():
                total = 1
                for factor in node.factors:
                    total = total * self.at(factor, known) % PRIME
                return total
            case Negative():
                return -self.at(node.operand, known)
            case Power():
                return pow(self.at(node.base, known), node.exponent, PRIME)
            case Quotient():
                return self.at(node.above, known) * pow(self.at(node.below, known), -1, PRIME)
        raise TypeError(type(node).__name__)


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
