"""Scalars that record the operations on them: interned nodes of a graph, simplified as they are
made.

A node is a row (op, a, b, c) of its graph. Equal rows are one node, so common subexpressions are
found by construction. An `Expr` is only a handle on a row. Nodes are folded by the rules of
`folding` and of the records of `operations`.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

from freebody.scalars.folding import add, div, mul, neg, sub
from freebody.scalars.nodes import GraphError, Nodes
from freebody.scalars.operations import ARITY, OPERATIONS


class Graph(Nodes):
    """The nodes of one trace, with handles to them."""

    __slots__ = ("input_names",)

    def __init__(self) -> None:
        super().__init__()
        self.input_names: list[str] = []

    def input(self, name: str) -> Expr:
        """Add an input to the graph."""
        self.input_names.append(name)
        return Expr(self, self.node("input", len(self.input_names) - 1))

    def constant(self, value: float) -> Expr:
        """The node of a finite number."""
        return Expr(self, self.number(_float(value)))

    def operand(self, value: Any) -> int:
        """Index of the node that stands for an Expr of this graph or a number; -1 for anything
        else."""
        if type(value) is Expr:
            if value.graph is not self:
                raise GraphError(
                    "scalars of two traces were mixed: a graph belongs to one trace. Do not keep "
                    "traced scalars in globals, closures or caches; pass them as arguments."
                )
            return value.index
        if isinstance(value, (float, int, Real)):
            return self.number(_float(value))
        return -1

    def describe(self, index: int) -> str:
        """Text of a node, for messages and listings."""
        op = self.op[index]
        if op == "const":
            return repr(self.constant_of[index])
        if op == "input":
            return self.input_names[self.a[index]]
        operands = (self.a[index], self.b[index], self.c[index])[: ARITY[op]]
        return f"{op}({', '.join(f'%{i}' for i in operands)})"


def _float(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number or a fraction, maybe of too many digits to be shown
        raise GraphError(
            "a constant beyond 1.8e308 in a traced computation: constants must be finite numbers "
            "of 64 bits."
        ) from None


class Expr:
    """A handle on a node of a graph, which behaves as a number under `+ - * / **` and the functions
    of `elementary`.

    A handle equals one of the same node. Comparing values is refused: what a trace does may depend
    on the structure of the robot, never on the value of a scalar.
    """

    __slots__ = ("graph", "index")
    __array_ufunc__ = None  # np.float64(2) * expr is ours, not an array of objects
    __array_priority__ = 1000.0

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    def __add__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, add(graph, self.index, i))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, sub(graph, self.index, i))

    def __rsub__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, sub(graph, i, self.index))

    def __mul__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, mul(graph, self.index, i))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, div(graph, self.index, i))

    def __rtruediv__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, div(graph, i, self.index))

    def __neg__(self) -> Expr:
        return Expr(self.graph, neg(self.graph, self.index))

    def __pos__(self) -> Expr:
        return self

    def __pow__(self, exponent: Any) -> Expr:
        if (
            not isinstance(exponent, (int, float))
            or exponent != int(exponent)
            or abs(exponent) > 64
        ):
            raise GraphError(
                f"x ** {exponent!r}: the exponent of a traced scalar is a whole number from -64 to "
                f"64; else there are sqrt(x) and exp(exponent * log(x)) of freebody.math."
            )
        if exponent < 0:
            return 1.0 / self**-exponent
        power, square, rest = self.graph.constant(1.0), self, int(exponent)
        while rest:
            if rest & 1:
                power = power * square
            rest >>= 1
            if rest:
                square = square * square
        return power

    def __abs__(self) -> Expr:
        return self.elementary("absolute", (self,))

    def elementary(self, name: str, operands: tuple[Any, ...]) -> Expr:
        """The node of an elementary function of traced scalars and numbers; NotImplemented for
        other operands."""
        graph = self.graph
        indices = [graph.operand(x) for x in operands]
        if min(indices) < 0:
            return NotImplemented
        return Expr(graph, OPERATIONS[name].node(graph, *indices))

    def __eq__(self, other: object) -> bool:
        if type(other) is Expr and other.graph is self.graph and other.index == self.index:
            return True
        raise _branch("==")

    def __hash__(self) -> int:
        return hash((id(self.graph), self.index))

    def __bool__(self) -> bool:
        raise _branch("bool()")

    def __lt__(self, other: Any) -> bool:
        raise _branch("a comparison")

    __le__ = __gt__ = __ge__ = __lt__

    def __float__(self) -> float:
        raise _branch("float()")

    def __repr__(self) -> str:
        return f"Expr(%{self.index} = {self.graph.describe(self.index)})"


def _branch(what: str) -> GraphError:
    return GraphError(
        f"{what} of a traced scalar: it has no value yet. Branch on structure (joint kinds, the "
        f"tree, a constant parameter), never on values; freebody.math chooses by value, with "
        f"where(less(a, b), x, y), minimum, maximum, absolute, and has the functions that Python's "
        f"math and NumPy have for numbers."
    )
