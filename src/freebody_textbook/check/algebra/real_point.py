"""Values of polynomials in real numbers, for answers that are numbers: what a thought makes of the
right answer agrees with one that is rounded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import TrigRing
from freebody_textbook.check.algebra.finite_field import Point
from freebody_textbook.check.algebra.quotients import Value, pair


@dataclass(frozen=True)
class RealPoint(Point):
    """A state; what is not given is NaN, which agrees with nothing."""

    values: Mapping[str, Any]
    turns: Mapping[str, Any]
    slack: float = 0.0
    """By how much two numbers may differ."""

    @classmethod
    def of_state(cls, ring: TrigRing, state: Mapping[str, float]) -> RealPoint:
        """The point where names have these values; cos 90° is 0."""
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
