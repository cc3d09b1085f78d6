"""An answer's tree at a random point of a finite field: what the whole becomes when one piece is
replaced."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.derivations.check.residues import PRIME, Point
from freebody.derivations.check.tree import Negative, Node, Power, Product, Quotient, Sum, nodes
from freebody.lazy import cached_property


class Workspace:
    """A tree with the values of its nodes."""

    def __init__(self, root: Node, point: Point):
        self.root, self.point = root, point
        self.values: dict[Node, int] = {}
        self.value = point.at(root, self.values)
        self.parents: dict[Node, Node] = {part: node for node in nodes(root) for part in node.parts}

    @cached_property
    def cofactors(self) -> dict[Node, int]:
        """Of each factor of a product, the product of the others."""
        found: dict[Node, int] = {}
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

    def with_value(self, node: Node, value: int) -> int:
        """The value of the whole if this node had another one."""
        while node is not self.root:
            parent = self.parents[node]
            value = self._above(parent, node, value)
            node = parent
        return value % PRIME

    def _above(self, parent: Node, node: Node, value: int) -> int:
        match parent:
            case Sum():
                return self.values[parent] - self.values[node] + value
            case Product():
                return self.cofactors[node] * value % PRIME
            case Negative():
                return -value
            case Power():
                return pow(value % PRIME, parent.exponent, PRIME)
            case Quotient() if node is parent.above:
                return value * pow(self.values[parent.below], -1, PRIME) % PRIME
            case Quotient():
                return (
                    self.values[parent.above] * pow(value % PRIME, -1, PRIME)
                    if value % PRIME
                    else 0
                )
        raise TypeError(type(parent).__name__)

    def is_linear_in(self, node: Node) -> bool:
        """Whether the whole depends linearly on this node: it is below no power or fraction bar."""
        while node is not self.root:
            parent = self.parents[node]
            if isinstance(parent, Power) or (isinstance(parent, Quotient) and node is parent.below):
                return False
            node = parent
        return True

    def slope(self, node: Node) -> int:
        """What the whole is multiplied with where it is linear in a node."""
        return (self.with_value(node, self.values[node] + 1) - self.value) % PRIME

    def addends(self) -> Iterator[Node]:
        """The terms of all sums, and the whole; brackets in brackets too."""
        yield self.root
        for node in self.values:
            if isinstance(node, Sum):
                yield from node.terms

    def addend_of(self, node: Node) -> Node:
        """The smallest term of a sum that a node is in; the whole where there is no sum around
        it."""
        while node is not self.root and not isinstance(self.parents[node], Sum):
            node = self.parents[node]
        return node
