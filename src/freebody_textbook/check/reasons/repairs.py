"""The small changes of an answer that make it right: each names a mistake, where it stands and what
should be there. All single ones are tried, and then pairs; the cheapest that explains wins."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations

from freebody.expressions.nodes import Sum, nodes, replaced
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.answer_tree import Named
from freebody_textbook.check.algebra.finite_field import PRIME
from freebody_textbook.check.algebra.finite_field_tree import Workspace
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reasons.small_changes import RelatedNames, Repair, SmallChanges

MOST_NODES = 2500
"""Pieces of an answer up to which every one is tried."""

_PAIR_COST, _PAIR_TOTAL = 2.5, 5.0
_TRIPLE_COST, _TRIPLE_MOST = 2.0, 300


class Repairs(SmallChanges):
    """The search for changes of an answer that make up for its difference from the right one."""

    def __init__(self, setting: RightEquations, work: Workspace, right: int, related: RelatedNames):
        super().__init__(setting, work, right, related)
        self.tried: list[Repair] = []

    def single(self, below: float = math.inf) -> Repair | None:
        """The cheapest change that alone makes the answer right, of those that cost less."""
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
        """The cheapest two or three changes that together make it right; `insertions`: terms that
        may be missing."""
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
        """Groups begun, with two more changes that fill the gap."""
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
        """Whether changes that may touch one another do make the answer right."""
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
        """The value of the whole after a change, of which only the changed piece is computed
        anew."""
        value = self.work.point.at(repair.new, self.work.values)
        return self.work.with_value(repair.node, value)


def _with_change(repair: Repair, change: int) -> Repair:
    return Repair(repair.kind, repair.cost, repair.node, repair.new, change, repair.factor)
