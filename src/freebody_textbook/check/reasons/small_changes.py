"""Small changes of an answer and the search for those that correct it: each names a mistake, its
place and the correction.

A change is a sign, a factor, a term too many or missing, sin for cos, an angle, a length, an index,
a power. Each has a cost, small for what people get wrong often. All single ones are tried, and then
pairs; the cheapest that explains wins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.nodes import (
    Arguments,
    Expression,
    Function,
    Negative,
    Number,
    Power,
    Product,
    Sum,
    nodes,
    replaced,
)
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import PRIME, Workspace, rational
from freebody_textbook.check.algebra.quotients import Angle, Named, Value, Wave, generator
from freebody_textbook.check.asked.right_equations import RightEquations

_FACTORS = (0, -1, 2, Fraction(1, 2), -2, Fraction(-1, 2), 3, Fraction(1, 3), 4, Fraction(1, 4))

_TAKEN_FOR = {"arccos": "arcsin", "arcsin": "arccos"}
"""Inverse functions that are often mixed up."""

RelatedNames = Callable[[str], Mapping[str, Value]]
"""Quantities that one may mix up with one: the other entries of its family."""


@dataclass(frozen=True, eq=False)
class Repair:
    """A change that replaces `node` by `new`. factor: for a scaled term, its factor."""

    kind: str
    cost: float
    node: Expression
    new: Expression
    change: int = 0
    factor: Fraction = Fraction(1)


class SmallChanges:
    """The small changes of an expression; `gap` is the correct value minus its value."""

    def __init__(self, setting: RightEquations, work: Workspace, right: int, related: RelatedNames):
        self.setting, self.work, self.related = setting, work, related
        self.gap = (right - work.value) % PRIME

    def scaled(self) -> Iterator[Repair]:
        """Changes that multiply a term by the number that corrects it, which is computed."""
        for node in self.work.addends():
            slope = (self.work.slopes[node] or 0) * self.work.values[node] % PRIME
            factor = rational(1 + self.gap * pow(slope, -1, PRIME)) if slope else None
            if factor is not None:
                yield _scaling(node, factor, self._depth(node))

    def _depth(self, node: Expression) -> int:
        """The depth of brackets around a term."""
        depth = 0
        while node is not self.work.root:
            node = self.work.parents[node]
            depth += isinstance(node, Sum)
        return max(0, depth - 1)

    def _factors(self) -> Iterator[Repair]:
        """Changes that multiply a term by a common factor, for use in pairs and below powers."""
        for node in self.work.addends():
            for factor in _FACTORS:
                yield _scaling(node, Fraction(factor))

    def discrete(self) -> Iterator[Repair]:
        """All changes that can be enumerated, without those by a computed factor."""
        yield from self._factors()
        yield from self._lacking()
        for node in list(self.work.values):
            match node:
                case Wave():
                    yield from self._waves(node)
                case Named():
                    yield from self._symbols(node)
                case Power():
                    yield from _powers(node)
                case Function():
                    yield from _functions(node)
            yield from self._inserted(node)

    @cached_property
    def angles(self) -> list[Angle]:
        """Sums of angles that may be intended."""
        names = [x for x in self.setting.ring.angles if x not in self.setting.foreign][:6]
        return [
            tuple((x, 1) for x in subset)
            for size in range(1, len(names) + 1)
            for subset in combinations(names, size)
        ]

    def _waves(self, node: Wave) -> Iterator[Repair]:
        """Changes of a sine or cosine: the other function, or another angle."""
        other = "sin" if node.function == "cos" else "cos"
        span = node.span
        yield Repair("function", 1.0, node, Wave(other, node.angle, node.turn, span=span))
        for angle in self.angles:
            if angle == node.angle:
                continue
            near = _is_chain(angle)
            yield Repair(
                "angle",
                1.4 if near else 2.4,
                node,
                Wave(node.function, angle, node.turn, span=span),
            )
            yield Repair("angle", 3.5, node, Wave(other, angle, node.turn, span=span))
        if len(node.angle) > 1:
            for k in range(len(node.angle)):
                flipped = tuple((x, -e if j == k else e) for j, (x, e) in enumerate(node.angle))
                yield Repair("angle", 1.6, node, Wave(node.function, flipped, node.turn, span=span))
        if node.turn:
            yield Repair("angle", 1.5, node, Wave(node.function, node.angle, span=span))
        yield Repair("extra factor", 3.0, node, Number(Fraction(1), span=span))

    def _symbols(self, node: Named) -> Iterator[Repair]:
        """Changes of a symbol: another symbol, its square, or none."""
        name = generator(node.value)
        if name is None:
            for other, value in self.related(node.name).items():
                yield Repair("index", 1.0, node, Named(other, value, span=node.span))
            return
        for other in self._names:
            if other != name:
                kind, cost = _likeness(name, other)
                yield Repair(kind, cost, node, self._symbol(node, other))
        if atom(name).dots:
            yield from self._rate_sums(node, name)
        if not isinstance(self.work.parents.get(node), Power):
            yield Repair("exponent", 2.0, node, Power(node, 2, span=node.span))
        yield Repair("extra factor", 3.0, node, Number(Fraction(1), span=node.span))

    def _symbol(self, place: Expression, name: str) -> Named:
        """A node for a generator, at another node's place in the text."""
        return Named(name, self._generators[name], is_generator=True, span=place.span)

    @cached_property
    def _generators(self) -> dict[str, Trig]:
        return {name: self.setting.ring[name] for name in self._names}

    @cached_property
    def _names(self) -> list[str]:
        """Generators that occur in correct answers."""
        ring = self.setting.ring
        return [
            x
            for x in ring.names
            if x not in ring.angles and x not in self.setting.foreign and not function_of(x)
        ]

    def _rate_sums(self, node: Named, name: str) -> Iterator[Repair]:
        """Changes of a rate to a sum of rates, as in absolute angular velocities."""
        ending = atom(name).ending
        for angle in self.angles:
            if len(angle) > 1 and _is_chain(angle):
                rates = [x + ending for x, _ in angle]
                terms = tuple(self._symbol(node, x) for x in rates)
                yield Repair("rate", 2.0, node, Sum(terms, span=node.span))

    def _lacking(self) -> Iterator[Repair]:
        """Changes that add a missing factor to a term."""
        for node in self.work.addends():
            for name in self._names:
                lacking = (node, self._symbol(node, name))
                yield Repair("missing factor", 3.0, node, Product(lacking, span=node.span))
            for angle in self.angles:
                if _is_chain(angle):
                    for function in ("sin", "cos"):
                        wave = Wave(function, angle, span=node.span)
                        yield Repair(
                            "missing factor", 3.5, node, Product((node, wave), span=node.span)
                        )

    def _inserted(self, node: Expression) -> Iterator[Repair]:
        """Changes that add a missing symbol to a bracket, or to a factor that may have been a
        bracket."""
        parent = self.work.parents.get(node)
        is_factor = isinstance(parent, Product | Power) and isinstance(node, Named)
        if not (isinstance(node, Sum) and parent is not None) and not is_factor:
            return
        for name in self._names:
            symbol = self._symbol(node, name)
            yield Repair("missing", 2.5, node, Sum((node, symbol), span=node.span))
            yield Repair(
                "missing", 2.6, node, Sum((node, Negative(symbol, span=node.span)), span=node.span)
            )


def _scaling(node: Expression, factor: Fraction, depth: int = 0) -> Repair:
    """The change that multiplies a term by a number, or removes it if that is 0. Depth in brackets
    adds a little to the cost."""
    new = Product((Number(factor, span=node.span), node), span=node.span)
    size = max(abs(factor.numerator), factor.denominator)
    if factor == 0:
        return Repair("extra", 1.1 + depth / 10, node, new, factor=factor)
    if factor == -1:
        cost = 1.0 if isinstance(node, Negative) else 1.01  # of x² - y² rather the minus
        return Repair("sign", cost + depth / 10, node, new, factor=factor)
    cost = 1.2 if factor in (2, Fraction(1, 2)) else 2.0 + size / 20
    return Repair("factor", cost + depth / 10, node, new, factor=factor)


def _powers(node: Power) -> Iterator[Repair]:
    """Changes of an exponent by one."""
    for exponent in (node.exponent - 1, node.exponent + 1):
        new = node.base if exponent == 1 else Power(node.base, exponent, span=node.span)
        if exponent > 0:  # of x⁰ none is lower
            yield Repair("exponent", 1.8, node, new)


def _functions(node: Function) -> Iterator[Repair]:
    """Changes to another inverse function, or to swapped arguments."""
    if isinstance(node.argument, Arguments):
        turned = replace(node.argument, entries=node.argument.entries[::-1])
        yield Repair("arguments", 0.8, node, replace(node, argument=turned))
    if node.name in _TAKEN_FOR:
        yield Repair("inverse", 0.9, node, replace(node, name=_TAKEN_FOR[node.name]))


def _is_chain(angle: Angle) -> bool:
    """Whether the angles of a sum belong to consecutive joints."""
    numbers = [int(atom(x).figures or 0) for x, _ in angle]
    return numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def _likeness(name: str, other: str) -> tuple[str, float]:
    """(kind of mistake, cost) of writing one name for another."""
    a, b = atom(name), atom(other)
    if not (a.is_numbered and b.is_numbered):
        return "symbol", 4.0
    if (a.letter, a.dots) == (b.letter, b.dots):
        return "index", 1.0
    if {a.letter, b.letter} == {"l", "lc"}:
        return "length", 1.0 if a.index == b.index else 2.0
    if a.dots and b.dots:
        return "rate", 1.5 if a.index == b.index else 2.2
    return "symbol", 3.0 if a.index == b.index else 4.0


MOST_NODES = 2500
"""Pieces of an answer up to which every one is tried."""

_PAIR_COST, _PAIR_TOTAL = 2.5, 5.0
_TRIPLE_COST, _TRIPLE_MOST = 2.0, 300


class Repairs(SmallChanges):
    """Searches for changes that remove an answer's difference from the correct one."""

    def __init__(self, setting: RightEquations, work: Workspace, right: int, related: RelatedNames):
        super().__init__(setting, work, right, related)
        self.tried: list[Repair] = []

    def single(self, below: float = math.inf) -> Repair | None:
        """The cheapest single change that corrects the answer at a cost below `below`; None if
        there is none."""
        found: list[Repair] = list(self.scaled())
        if len(self.work.values) <= MOST_NODES:
            for repair in self.discrete():
                if repair.cost >= below:
                    continue
                change = (self._value(repair) - self.work.value) % PRIME
                if change == self.gap:
                    found.append(repair)
                elif repair.cost <= _PAIR_COST and change:
                    self.tried.append(_with_change(repair, change))
        size = {node: k for k, node in enumerate(self.work.values)}  # inner nodes come first
        return min(found, key=lambda r: (r.cost, size[r.node]), default=None)

    def several(self, insertions: Iterable[tuple[Trig, int]] = ()) -> tuple[Repair, ...]:
        """The cheapest two or three changes that together correct the answer; `insertions`: terms
        that may be missing."""
        whole = self.work.root
        for term, value in insertions:
            new = Sum((whole, Named("", term, span=whole.span)), span=whole.span)
            self.tried.append(Repair("missing", 2.0, whole, new, value))
        by_change: dict[int, list[Repair]] = {}
        for repair in self.tried:
            by_change.setdefault(repair.change, []).append(repair)
        pairs = list(self._completed(by_change, [()], _PAIR_COST))
        if not pairs:
            cheap = [r for r in self.tried if r.cost <= _TRIPLE_COST]
            if len(cheap) <= _TRIPLE_MOST:
                pairs = list(self._completed(by_change, [(r,) for r in cheap], _TRIPLE_COST))
        for group in sorted(pairs, key=lambda group: sum(r.cost for r in group))[:20]:
            if self._verified(group):
                return group
        return ()

    def _completed(
        self, by_change: Mapping[int, list[Repair]], begun: list[tuple[Repair, ...]], most: float
    ) -> Iterator[tuple[Repair, ...]]:
        """Groups extended by two more changes that remove the remaining difference."""
        first = {id(r): k for k, r in enumerate(self.tried)}
        for group in begun:
            rest = self.gap - sum(r.change for r in group)
            for repair in self.tried:
                if repair.cost > most or (group and first[id(repair)] <= first[id(group[-1])]):
                    continue
                for other in by_change.get((rest - repair.change) % PRIME, ()):
                    whole = (*group, repair, other)
                    if (
                        other.cost <= most
                        and first[id(other)] > first[id(repair)]
                        and sum(r.cost for r in whole) <= _PAIR_TOTAL + len(group)
                    ):
                        yield whole

    def _verified(self, group: tuple[Repair, ...]) -> bool:
        """Whether changes that may overlap really correct the answer together."""
        inserted = [r for r in group if r.kind == "missing" and r.node is self.work.root]
        others = [r for r in group if r not in inserted]
        if len({r.node for r in others}) < len(others):
            return False
        for a, b in combinations(others, 2):
            if a.node in set(nodes(b.node)) or b.node in set(nodes(a.node)):
                return False
        tree = replaced(self.work.root, {r.node: r.new for r in others})
        value = self.work.point.at(tree) + sum(r.change for r in inserted)
        return (value - self.work.value - self.gap) % PRIME == 0

    def _value(self, repair: Repair) -> int:
        """The value of the whole expression after a change; only the changed part is evaluated
        again."""
        value = self.work.point.at(repair.new, self.work.values)
        return self.work.with_value(repair.node, value)


def _with_change(repair: Repair, change: int) -> Repair:
    return Repair(repair.kind, repair.cost, repair.node, repair.new, change, repair.factor)
