"""Motions that obey the equations of motion: what accelerations are where these hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import Point
from freebody_textbook.check.algebra.quotients import Value, over, pair, plus, times


@dataclass(frozen=True)
class FreeMotion:
    """What some generators are where the equations hold, by the others."""

    images: Mapping[str, Value]

    def concerns(self, x: Value) -> bool:
        """Whether one of the generators that the equations determine occurs in a polynomial."""
        return any(self.images.keys() & powers.keys() for p in pair(x) for powers, _ in p.terms())

    def of(self, x: Value) -> Value:
        """A polynomial or quotient with the images put in."""
        above, below = (put(part, self.images) for part in pair(x))
        (p, q), (r, s) = pair(above), pair(below)
        return over(p * s, q * r)

    def at(self, point: Point) -> Point:
        """The point with its accelerations such that the equations hold."""
        return point.changed({name: point.of(x) for name, x in self.images.items()})


def put(x: Trig, images: Mapping[str, Value]) -> Value:
    """A polynomial with values in the place of some generators."""
    by_below: dict[Trig, Trig] = {}
    for powers, coefficient in x.terms():
        rest = {name: k for name, k in powers.items() if name not in images}
        term: Value = x.ring.polynomial([(rest, coefficient)])
        for name in powers.keys() & images.keys():
            for _ in range(powers[name]):
                term = times(term, images[name])
        above, below = pair(term)
        by_below[below] = by_below.get(below, x - x) + above
    total: Value = x - x
    for below, above in by_below.items():
        total = plus(total, over(above, below))
    return total
