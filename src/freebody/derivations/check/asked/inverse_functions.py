"""Coordinates by inverse functions, θ2 = arccos((x² + y² - l1² - l2²)/(2 l1 l2)): compared in
numbers, since each function has several values and tells one of them."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import flint

from freebody.derivations.check.algebra.answer_tree import Named, Wave
from freebody.derivations.check.algebra.quotients import Value, pair
from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.derivations.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.derivations.expressions.nodes import Arguments, Expression, Function, nodes
from freebody.derivations.grammar.parser import PI
from freebody.lazy import cached_property
from freebody.scalars.rational import exactly
from freebody.scalars.trig import Trig

POSITIONS = 24
"""Where an answer is compared."""
MOST_PARTS = 360
"""Of half a turn, in a number that is read as a part of π."""
BITS = 256
"""Of the numbers."""
_LARGEST = 10**6
"""Denominator of numbers that are surely no part of π, which is read as a fraction near it."""
MOST_BRANCHES = 5
"""Functions of several values in one answer."""
NEAR = Fraction(1, 10**40)
_TWO_VALUED = ("arccos", "arcsin", "arctan", "sqrt")
_LENGTHS, _TURNS = (0.3, 2.0), (-3.1, 3.1)

Branches = Mapping[Expression, int]
"""Of the functions that have two values those whose second one is taken."""
Known = Mapping[Expression, Any]
"""Values that need not be worked out."""


@dataclass(frozen=True)
class RandomPosition:
    """A position of the robot and lengths of its links, all drawn at random."""

    values: Mapping[str, Any]

    def of(self, x: Value) -> Any:
        """The value of a polynomial, or of a quotient."""
        above, below = (self.polynomial(part) for part in pair(x))
        return above / below

    def polynomial(self, x: Trig) -> Any:
        """The value of a polynomial."""
        total = flint.arb(0)
        for powers, coefficient in x.terms():
            term = ball(coefficient)
            for name, exponent in powers.items():
                term = term * self._generator(name) ** exponent
            total = total + term
        return total

    def _generator(self, name: str) -> Any:
        function, _, angle = name.partition("_")
        if function in ("sin", "cos") and angle in self.values:
            return getattr(self.values[angle], function)()
        return self.values[name]

    def at(self, node: Expression, branches: Branches, known: Known | None = None) -> Any:
        """The value of a tree, on some branches of its functions; known: of pieces of it."""

        def wave(node: Wave, at: Callable[[Expression], Any]) -> Any:
            angle = ball(node.turn)
            for name, factor in node.angle:
                angle = angle + self.values[name] * factor
            return getattr(angle, node.function)()

        rules: Rules = {
            **arithmetic(ball),
            Named: lambda node, at: self.of(node.value),
            Wave: wave,
            Arguments: lambda node, at: tuple(map(at, node.entries)),
            Function: lambda node, at: _applied(node, at(node.argument), branches.get(node, 0)),
        }
        return evaluate(node, rules, known)


def ball(x: Fraction | int) -> Any:
    """An exact number; a part of π as that of π."""
    if x.denominator > _LARGEST and (turns := x / PI).denominator <= MOST_PARTS:
        return flint.arb.pi() * flint.arb(flint.fmpq(turns.numerator, turns.denominator))
    return flint.arb(flint.fmpq(x.numerator, x.denominator))


def _applied(node: Function, x: Any, second: int) -> Any:
    """A function's value, or its second one."""
    match node.name:
        case "arccos":
            return -x.acos() if second else x.acos()
        case "arcsin":
            return flint.arb.pi() - x.asin() if second else x.asin()
        case "arctan":
            return x.atan() + flint.arb.pi() if second else x.atan()
        case "sqrt":
            return -x.sqrt() if second else x.sqrt()
    y, x = x
    return flint.arb.atan2(y, x)


@dataclass(frozen=True)
class BranchesFound:
    """The positions at which a tree is right as it stands, and the functions that are on another
    branch at others."""

    right: frozenset[int]
    others: tuple[str, ...]


@dataclass(frozen=True)
class Branching:
    """A tree that should be a coordinate, or the sine or cosine of one."""

    setting: RightEquations
    left: Expression
    is_angle: bool
    values: Mapping[str, float] = field(default_factory=dict)
    """Of a model's parameters, where the answer is in numbers."""

    @cached_property
    def places(self) -> list[RandomPosition]:
        """Random positions, the same for each answer."""
        chance = random.Random("freebody positions")
        ring = self.setting.ring
        return [
            RandomPosition({
                name: ball(exactly(self.values.get(name, drawn)))
                for name in ring.names
                for drawn in [round(chance.uniform(*_range(name, ring.angles)), 6)]
            })
            for _ in range(POSITIONS)
        ]  # fmt: skip

    def fits(self, node: Expression, place: RandomPosition, branches: Branches) -> bool:
        """Whether a tree has the right value there."""
        try:
            gap = place.at(node, branches) - place.at(self.left, {})
        except ZeroDivisionError:
            return False
        if not gap.is_finite():
            return False
        sizes = (gap.sin(), gap.cos() - 1) if self.is_angle else (gap,)
        return all(abs(x) < ball(NEAR) for x in sizes)

    def choices(self, node: Expression) -> list[Branches]:
        """All choices of values: that of the functions as they stand, then those with the fewest
        second ones."""
        several = [x for x in nodes(node) if isinstance(x, Function) and x.name in _TWO_VALUED]
        every = itertools.product((0, 1), repeat=len(several))
        return [dict(zip(several, chosen, strict=True)) for chosen in sorted(every, key=sum)]

    def compared(self, node: Expression, most: int = POSITIONS) -> BranchesFound | None:
        """A tree at positions; None where at some it is right on no branch, or nowhere as it
        stands."""
        choices, right = self.choices(node), set[int]()
        others: dict[str, None] = {}
        for k, place in enumerate(self.places[:most]):
            fitting = next((x for x in choices if self.fits(node, place, x)), None)
            if fitting is None:
                return None
            flipped = (x for x, is_second in fitting.items() if is_second)
            second = [x.name for x in flipped if isinstance(x, Function)]
            right |= {k} if not second else set()
            others |= dict.fromkeys(second)
        return BranchesFound(frozenset(right), tuple(others)) if right else None


def _range(name: str, angles: Sequence[str]) -> tuple[float, float]:
    return _TURNS if name in angles else _LENGTHS


def functions_of(node: Expression) -> list[str]:
    """The names of the functions in a tree."""
    return [x.name for x in nodes(node) if isinstance(x, Function)]


def swapped(node: Expression) -> Iterator[tuple[str, Expression, Expression]]:
    """What is often mixed up among functions: a sentence, what is written, what should be."""
    for part in nodes(node):
        if not isinstance(part, Function):
            continue
        match part.name, part.argument:
            case "atan2", Arguments(entries=(y, x)):
                turned = replace(part.argument, entries=(x, y))
                text = "atan2 takes the sine's part first: atan2(y, x)."
                yield text, part, replace(part, argument=turned)
            case "arccos", _:
                yield "It is the arcsine of that.", part, replace(part, name="arcsin")
            case "arcsin", _:
                yield "It is the arccosine of that.", part, replace(part, name="arccos")
