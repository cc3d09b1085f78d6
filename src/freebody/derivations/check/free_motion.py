"""Motions that obey the equations of motion: accelerations that follow from what drives a robot."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from freebody.derivations.check.finite_field import PRIME, Point, raised
from freebody.derivations.check.quotients import Value, over, pair
from freebody.derivations.check.right_equations import RightEquations
from freebody.derivations.closed_chains.linear import solved
from freebody.derivations.polynomials.symbols import SECOND
from freebody.scalars.trig import Trig

MOST_PASSIVE = 3
"""Joints that nothing drives whose equations are solved."""


@dataclass(frozen=True)
class FreeMotion:
    """What some generators are where the equations hold: numerators over one denominator."""

    above: Mapping[str, Trig]
    below: Trig

    @classmethod
    def of_passive_joints(cls, setting: RightEquations) -> Self | None:
        """The accelerations of joints that nothing drives, by those of the others; None of a robot
        whose joints are all driven."""
        names = setting.symbols.coordinates
        passive = setting.symbols.model.passive
        if setting.system is not None or not 0 < len(passive) <= MOST_PASSIVE:
            return None
        tau = setting.all_of("tau")
        own = [names[k] + SECOND for k in passive]
        rows = [setting.element(tau[k]) for k in passive]
        slopes = [[row.derivative(name) for name in own] for row in rows]
        rest = [[_without(row, own) * -1] for row in rows]
        above, below = solved(slopes, rest, setting.symbols)
        return cls({name: row[0] for name, row in zip(own, above, strict=True)}, below)

    def concerns(self, x: Value) -> bool:
        """Whether one of the generators occurs."""
        return any(self.above.keys() & powers.keys() for p in pair(x) for powers, _ in p.terms())

    def of(self, x: Value) -> Value:
        """A polynomial or quotient with the accelerations put in."""
        (a, m), (b, n) = map(self._put, pair(x))
        if m == n:
            return over(a, b)
        return over(a * self.below ** (n - m), b) if n > m else over(a, b * self.below ** (m - n))

    def _put(self, x: Trig) -> tuple[Trig, int]:
        """a and m of a / below^m."""
        by_degree: dict[int, Trig] = defaultdict(lambda: x - x)
        for powers, coefficient in x.terms():
            rest = {name: k for name, k in powers.items() if name not in self.above}
            term = x.ring.polynomial([(rest, coefficient)])
            degree = 0
            for name in powers.keys() & self.above.keys():
                degree += powers[name]
                for _ in range(powers[name]):
                    term = term * self.above[name]
            by_degree[degree] += term
        most = max(by_degree, default=0)
        terms = (by_degree[k] * self.below ** (most - k) for k in by_degree)
        return sum(terms, x - x), most

    def at(self, point: Point) -> Point:
        """The point with its accelerations such that the equations hold."""
        below = raised(point.of(self.below), -1)
        return point.changed({k: point.of(x) * below % PRIME for k, x in self.above.items()})


def _without(x: Trig, names: list[str]) -> Trig:
    """The terms in which none of the names occurs."""
    return x.ring.polynomial(row for row in x.terms() if not set(names) & row[0].keys())
