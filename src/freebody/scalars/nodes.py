"""The nodes of one trace, as rows of parallel lists."""

from __future__ import annotations

import math
from typing import Any

from freebody.errors import FreebodyError

ZERO, ONE = 0, 1
"""Nodes that every graph begins with."""


class GraphError(FreebodyError, TypeError):
    """Raised where a traced scalar is used in a way that a graph cannot record."""


class Nodes:
    """Nodes as rows (op, a, b, c): an operation and the indices of its operands, -1 where there is
    none. Equal rows are one node.

    An input has in `a` its position among the inputs, a constant its position in `values`.
    """

    __slots__ = ("a", "b", "c", "constant_of", "interned", "op", "values")

    def __init__(self) -> None:
        self.op: list[str] = []
        self.a: list[int] = []
        self.b: list[int] = []
        self.c: list[int] = []
        self.values: list[float] = []
        self.interned: dict[Any, int] = {}
        self.constant_of: dict[int, float] = {}
        self.number(0.0)
        self.number(1.0)

    def __len__(self) -> int:
        return len(self.op)

    def node(self, op: str, a: int, b: int = -1, c: int = -1) -> int:
        """The index of the node of an operation, without simplification."""
        key = (op, a, b, c)
        index = self.interned.get(key)
        if index is None:
            index = self.interned[key] = len(self.op)
            self.op.append(op)
            self.a.append(a)
            self.b.append(b)
            self.c.append(c)
        return index

    def number(self, value: float) -> int:
        """The index of the node of a finite number."""
        index = self.interned.get(value)
        if index is None:
            if not math.isfinite(value):
                raise GraphError(
                    f"the constant {value} in a traced computation: constants must be finite."
                )
            value += 0.0  # -0.0 becomes 0.0
            index = self.interned[value] = self.node("const", len(self.values))
            self.values.append(value)
            self.constant_of[index] = value
        return index
