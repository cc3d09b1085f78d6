"""An answer's tree at a random point of a finite field: what the whole becomes when one piece is
replaced."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.expressions.nodes import Expression, Negative, Power, Product, Quotient, Sum, nodes
from freebody.lazy import cached_property
from freebody_textbook.check.algebra.finite_field import PRIME, Point, raised


class Workspace:
    """A tree with the values of its nodes."""

    def __init__(self, root: Expression, point: Point):
        self.root, self.point = root, point
        self.values: dict[Expression, int] = {}
        """Of each node, those inside others first."""
        for node in _inner_first(root):
            self.values[node] = point.at(node, self.values)
        self.value = self.values[root]
        self.parents: dict[Expression, Expression] = {
            part: node for node in nodes(root) for part in node.parts
        }

    @cached_property
    def cofactors(self) -> dict[Expression, int]:
        """Of each factor of a product, the product of the others."""
        found: dict[Expression, int] = {}
        for node in self.values:
            if isinstance(node, Product):
                before = 1
                for factor in node.factors:
                    found[factor] = before
                    before = before * self.values[factor] % PRIME
                after = 1
                for factor in reversed(node.factors):
                    found[factor] = found[factor] * after % PRIME
                    after = after * self.values[factor] % PRIME
        return found

    @cached_property
    def slopes(self) -> dict[Expression, int | None]:
        """Of each node what the whole changes by when it is 1 more; None below a power or a
        fraction bar, where the whole is not linear in it."""
        found: dict[Expression, int | None] = {self.root: 1}
        for node in nodes(self.root):
            whole = found[node]
            for part in node.parts:
                own = None if whole is None else self._slope(node, part)
                if whole is None or own is None:
                    found[part] = None
                else:
                    found[part] = whole * own % PRIME
        return found

    def _slope(self, node: Expression, part: Expression) -> int | None:
        """What a node changes by when one of its parts is 1 more."""
        match node:
            case Sum():
                return 1
            case Negative():
                return -1
            case Product():
                return self.cofactors[part]
            case Quotient() if part is node.above:
                return pow(self.values[node.below], -1, PRIME)
        return None

    def with_value(self, node: Expression, value: int) -> int:
        """The value of the whole if this node had another one."""
        while (slope := self.slopes[node]) is None:
            parent = self.parents[node]
            value = self._above(parent, node, value) % PRIME
            node = parent
        return (self.value + slope * (value - self.values[node])) % PRIME

    def _above(self, parent: Expression, node: Expression, value: int) -> int:
        """The value of a node if one of its parts had another one."""
        slope = self._slope(parent, node)
        if slope is not None:
            return self.values[parent] + slope * (value - self.values[node])
        match parent:
            case Power():
                return raised(value, parent.exponent)
            case Quotient():
                return self.values[parent.above] * raised(value, -1)
        raise TypeError(type(parent).__name__)

    def addends(self) -> Iterator[Expression]:
        """The terms of all sums, and the whole; brackets in brackets too."""
        yield self.root
        for node in self.values:
            if isinstance(node, Sum):
                yield from node.terms

    def addend_of(self, node: Expression) -> Expression:
        """The smallest term of a sum that a node is in; the whole where there is no sum around
        it."""
        while node is not self.root and not isinstance(self.parents[node], Sum):
            node = self.parents[node]
        return node


class _Nowhere(Point):
    """No point: only what a tree is made of is asked for."""

    def at(self, node: Expression, known: object = None) -> int:
        return 0


def without_values(tree: Expression) -> Workspace:
    """The pieces of a tree and what they stand in."""
    return Workspace(tree, _Nowhere({}, {}))


def _inner_first(node: Expression) -> Iterator[Expression]:
    for part in node.parts:
        yield from _inner_first(part)
    yield node
