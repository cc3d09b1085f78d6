"""Motions that obey the equations of motion: what accelerations are where these hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from freebody.derivations.check.algebra.finite_field import Point
from freebody.derivations.check.algebra.quotients import Value, over, pair, plus, times
from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.derivations.closed_chains.linear import solved
from freebody.derivations.polynomials.symbols import SECOND
from freebody.scalars.trig import Trig

MOST_PASSIVE = 3
"""Joints that nothing drives whose equations are solved."""


@dataclass(frozen=True)
class FreeMotion:
    """What some generators are where the equations hold, by the others; `note`, what is said of an
    answer that holds with them put in."""

    images: Mapping[str, Value]
    note: str = ""

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
        images = {name: over(row[0], below) for name, row in zip(own, above, strict=True)}
        joints = " and ".join(f"joint {k + 1}" for k in passive)
        return cls(images, f"It holds with what follows from no drive at {joints}.")

    def concerns(self, x: Value) -> bool:
        """Whether one of the generators occurs."""
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


def _without(x: Trig, names: list[str]) -> Trig:
    """The terms in which none of the names occurs."""
    return x.ring.polynomial(row for row in x.terms() if not set(names) & row[0].keys())
