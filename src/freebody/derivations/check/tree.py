"""What an answer says, as a tree; each node knows which piece of the text it stands for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from freebody.scalars.trig import Trig

Angle = tuple[tuple[str, int], ...]
"""A sum of angles: names and whole factors."""


@dataclass(frozen=True, eq=False)
class Node:
    """A piece of an answer, text[start:end]."""

    start: int
    end: int

    @property
    def span(self) -> tuple[int, int]:
        """Where it stands."""
        return self.start, self.end

    @property
    def parts(self) -> tuple[Node, ...]:
        """What it is made of."""
        return ()

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        """The same with other parts."""
        return self


@dataclass(frozen=True, eq=False)
class Number(Node):
    """An exact number."""

    value: Fraction


@dataclass(frozen=True, eq=False)
class Symbol(Node):
    """A name and what it stands for."""

    name: str
    value: Trig
    is_generator: bool = False
    """Whether the name is the ring's own for the value."""


@dataclass(frozen=True, eq=False)
class Wave(Node):
    """sin or cos of a sum of angles and a constant."""

    function: str
    angle: Angle
    turn: Fraction = Fraction(0)


@dataclass(frozen=True, eq=False)
class Sum(Node):
    """Terms added up, those subtracted as `Negative`."""

    terms: tuple[Node, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        return self.terms

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        return replace(self, terms=parts)


@dataclass(frozen=True, eq=False)
class Product(Node):
    """Factors."""

    factors: tuple[Node, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        return self.factors

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        return replace(self, factors=parts)


@dataclass(frozen=True, eq=False)
class Negative(Node):
    """- operand."""

    operand: Node

    @property
    def parts(self) -> tuple[Node, ...]:
        return (self.operand,)

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        return replace(self, operand=parts[0])


@dataclass(frozen=True, eq=False)
class Power(Node):
    """base to a whole exponent, not negative."""

    base: Node
    exponent: int

    @property
    def parts(self) -> tuple[Node, ...]:
        return (self.base,)

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        return replace(self, base=parts[0])


@dataclass(frozen=True, eq=False)
class Quotient(Node):
    """above / below."""

    above: Node
    below: Node

    @property
    def parts(self) -> tuple[Node, ...]:
        return self.above, self.below

    def with_parts(self, parts: tuple[Node, ...]) -> Node:
        return replace(self, above=parts[0], below=parts[1])


@dataclass(frozen=True, eq=False)
class Table(Node):
    """Rows of entries: a vector or matrix. Only a whole side of an equation."""

    rows: tuple[tuple[Node, ...], ...]


def nodes(node: Node) -> Iterator[Node]:
    """A node and all below it."""
    yield node
    for part in node.parts:
        yield from nodes(part)


def replaced(node: Node, new: dict[Node, Node]) -> Node:
    """The tree with some nodes replaced by others."""
    if node in new:
        return new[node]
    parts = tuple(replaced(part, new) for part in node.parts)
    return (
        node
        if all(a is b for a, b in zip(parts, node.parts, strict=True))
        else node.with_parts(parts)
    )
