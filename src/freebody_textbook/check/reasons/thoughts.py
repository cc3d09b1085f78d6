"""Misconceptions as a sentence with the resulting wrong answer; the quantity, point and bodies that
they are evaluated with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from freebody.expressions.grammar.atoms import atom
from freebody.lazy import cached_property
from freebody.scalars.generators import generators_in
from freebody.spatial import Vector, times, transposed
from freebody_textbook.check.algebra.finite_field import (
    PRIME,
    Point,
    RealPoint,
    SineAndCosine,
    random_point,
)
from freebody_textbook.check.algebra.quotients import Value, over, pair
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint, BodyKey, State
from freebody_textbook.check.reasons.free_body_beliefs import FreeBelief, FreeBodyMotion

PartOfIndex = Callable[[Mapping[str, int]], bool]
"""Which terms are meant, by their powers."""
Changed = tuple[Mapping[str, object], Any]
"""Values for the places of a sentence, and the right answer under the thought."""


@dataclass(frozen=True)
class Component:
    """One entry of a body's vector, in the axes of body `axes` (-1: the world's)."""

    key: BodyKey
    entry: int
    axes: int = -1

    def of(
        self, bodies: BodiesAtPoint, found: Mapping[BodyKey, Vector], axes: int | None = None
    ) -> Any:
        """The entry's value, from vectors in world axes; axes: of the body in whose axes it is, by
        default its own choice."""
        axes, v = self.axes if axes is None else axes, found[self.key]
        return (v if axes < 0 else times(transposed(bodies.bodies[axes].R), v))[self.entry]


@dataclass(frozen=True)
class FreeSides:
    """Both sides of an equation of a free body, whose motion depends on a belief."""

    motion: FreeBodyMotion
    yours: Value
    right: Value

    def gap(self, point: Point, belief: FreeBelief) -> int:
        """The difference of both sides when the body moves according to a belief."""
        there = self.motion.motion((self.yours, self.right), belief).at(point)
        return there.of(self.right) - there.of(self.yours)


@dataclass(frozen=True)
class Subject:
    """The quantity that misconceptions are about, at a point."""

    bodies: BodiesAtPoint
    """The bodies of the mechanism, at the point."""
    targets: Targets
    target: AskedQuantity
    right: Value
    terms: frozenset[int] | None = None
    """The values of the terms of an equation between quantities, of which the right answer is one
    side."""
    free: FreeSides | None = None
    """Both sides of an equation of a body that nothing holds."""

    @property
    def setting(self) -> RightEquations:
        """The correct equations with which the answer is compared."""
        return self.bodies.setting

    @property
    def point(self) -> Point:
        """The point at which misconceptions are evaluated."""
        return self.bodies.point

    @property
    def is_equation(self) -> bool:
        """Whether the correct answer is a side of the user's own equation, rather than a
        quantity."""
        return self.terms is not None

    @cached_property
    def value(self) -> Any:
        """The correct answer's value at the point."""
        return self.point.of(self.right)

    @cached_property
    def rows(self) -> list[tuple[Mapping[str, int], Any]]:
        """The terms of the correct answer (of a quotient's numerator): powers, and value at the
        point."""
        above, _ = pair(self.right)
        return [(powers, self.point.term(powers, k)) for powers, k in above.terms()]

    @cached_property
    def names(self) -> set[str]:
        """The generators in the correct answer."""
        return generators_in(*pair(self.right))

    def scaled(self, factor: int | Fraction, meant: PartOfIndex) -> Any:
        """The correct answer with some of its terms multiplied by a factor."""
        k = self.point.number(factor)
        other = sum(value for powers, value in self.rows if not meant(powers))
        above = other + k * sum(value for powers, value in self.rows if k and meant(powers))
        return above * self._below

    @cached_property
    def _below(self) -> Any:
        """The reciprocal of a quotient's denominator; 1 for a polynomial."""
        _, below = pair(self.right)
        return self.point.of(over(below / below, below))

    def at(
        self,
        values: Mapping[str, Any] | None = None,
        turns: Mapping[str, SineAndCosine] | None = None,
    ) -> Any:
        """The correct answer with other values or angles."""
        return self.point.changed(values, turns).of(self.right)

    # ------------------------------------------------------------ what it is
    @cached_property
    def reference(self) -> tuple[BodiesAtPoint, Any]:
        """Bodies and the correct answer's value at a random point, where no other quantity has the
        same value."""
        if not isinstance(self.point, RealPoint):
            return self.bodies, self.value
        b = BodiesAtPoint(self.setting, random_point(self.setting.ring))
        return b, b.point.of(self.right)

    @cached_property
    def torque(self) -> tuple[str, State, int] | None:
        """(name in the equations, state, body) of a torque or one of its parts; None for other
        quantities."""
        if self.is_equation or not self.bodies.is_told:
            return None
        b, value = self.reference
        return next(
            (
                (name, self.bodies.states(j)[name], i)
                for i, body in enumerate(b.bodies)
                if self.target.index[:1] == (body.place + 1,)
                for j in ([k - 1 for k in self.target.index[1:2]] or [-1])
                for name, state in b.states(j).items()
                if b.point.agree(b.acting(state)["tau", i][0] + b.driven(i, state), value)
            ),
            None,
        )

    @property
    def part(self) -> str:
        """The name in the equations of a torque, "tau", or of its part, "M", "c" or "g"; "" of
        other quantities."""
        return "" if self.torque is None else self.torque[0]

    @cached_property
    def components(self) -> list[Component]:
        """Entries of bodies' vectors, or kinetic energies, that equal the quantity."""
        if not self.bodies.is_told or self.right.is_zero or self.torque is not None:
            return []
        bodies, value = self.reference
        known = {**bodies.moved(), **bodies.acting(bodies.moving)}
        every = [
            Component(key, k, axes)
            for key, v in known.items()
            if key[0] != "tau"
            for axes in (-1, *[key[1]] * (len(v) == 3))
            for k in range(len(v))
        ]
        if self.terms is not None:
            own = [x for x in every if x.key[0] in "fn"]
            return [x for x in own if x.of(bodies, known) % PRIME in self.terms]
        return [x for x in every if bodies.point.agree(x.of(bodies, known), value)]

    @cached_property
    def about(self) -> list[int]:
        """Bodies to which the quantity belongs."""
        b = self.bodies
        if not b.is_told:
            return []
        if self.torque is None:
            return sorted({x.key[1] for x in self.components} - {-1}) or [0] * bool(self.components)
        return [self.torque[2]]

    @cached_property
    def is_energy(self) -> bool:
        """Whether the quantity's terms with rates form a kinetic energy."""
        if (
            not self.bodies.is_told
            or self.is_equation
            or any(atom(x).dots == 2 for x in self.names)
        ):
            return False
        moving = sum(value for powers, value in self.rows if any(atom(x).dots == 1 for x in powers))
        return self._is("T") or self.point.agree(moving, self.bodies.moved()["T", -1][0])

    @cached_property
    def accelerates(self) -> bool:
        """Whether the quantity is a torque, a force or an acceleration."""
        if not self.bodies.is_told:
            return any(atom(x).dots == 2 for x in self.names)
        if self.torque is not None:
            return self.torque[0] in ("tau", "c")
        return any(self._is(x) for x in ("f", "n", "fc", "nc", "wd", "vd", "vcd", "vd tip"))

    def _is(self, letter: str) -> bool:
        return not self.is_equation and any(x.key[0] == letter for x in self.components)


Change = Callable[[Subject], Iterator[Changed]]
"""The right answer under a thought, once for each thing of which it can be thought."""


def each_and_all(rows: Sequence[Any]) -> Iterator[Sequence[Any]]:
    """Groups of rows that a mistake may affect: each row alone, and all together."""
    yield from ([x] for x in rows)
    yield from [rows] * (len(rows) > 1)
