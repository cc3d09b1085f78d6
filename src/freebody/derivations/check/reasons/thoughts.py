"""The right answer as it would be under a thought, at a point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from freebody.derivations.check.algebra.finite_field import Point, Turn
from freebody.derivations.check.asked.asked_quantities import Targets
from freebody.derivations.check.asked.quantity import AskedQuantity
from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.scalars.trig import Trig

Thought = tuple[str, int]
"""A sentence, and what the right answer would be."""


@dataclass(frozen=True)
class Thoughts:
    """What the thoughts about one quantity are made of."""

    setting: RightEquations
    targets: Targets
    target: AskedQuantity
    right: Trig
    point: Point

    def scaled(self, factor: int | Fraction, meant: Callable[[Mapping[str, int]], bool]) -> int:
        """The right answer with a factor at some of its terms."""
        total = 0
        for powers, coefficient in self.right.terms():
            own = factor if meant(powers) else 1
            if own:
                total += self.point.term(powers, coefficient * own)
        return total

    def at(
        self, values: Mapping[str, int] | None = None, turns: Mapping[str, Turn] | None = None
    ) -> int:
        """The right answer with other values or angles."""
        return self.point.changed(values, turns).of(self.right)

    def links(self, pattern: str) -> list[int]:
        """Numbers of the links whose parameter occurs in the right answer."""
        used = {name for powers, _ in self.right.terms() for name in powers}
        return [k for k in range(1, self.setting.joints + 1) if pattern.format(k) in used]
