"""Scalars that record what is done to them: interned nodes of a graph, folded as they are made.

A node is a row (op, a, b) of its graph. Equal rows are one node, so common subexpressions are found by
construction. An `Expr` is only a handle on a row. Each operation has a function that holds its folding rules,
one a line, in the table `FOLD`; the last line makes the node.

The normal form that the rules keep:
- a negation is pulled out of products, quotients and odd functions, and vanishes into the next sum, so that
  common subexpressions are found across signs; constant factors are positive, `x - y` has the older node
  first;
- the operands of `+` and `*` are ordered, a constant first;
- `-0.0` is `0.0`, and constants are finite.

Folding `0 * x`, `0 / x` and `x - x` to 0 holds for finite values only; compiled kernels return NaN for every output of
a sample with an input that is not finite, whatever was folded away.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from numbers import Real
from typing import Any

from freebody.errors import FreebodyError

ARITY = {
    "input": 0,
    "const": 0,
    "neg": 1,
    "sqrt": 1,
    "sin": 1,
    "cos": 1,
    "sign": 1,
    "add": 2,
    "sub": 2,
    "mul": 2,
    "div": 2,
}
"""Number of operands of each operation."""

ZERO, ONE = 0, 1
"""Nodes that every graph begins with."""


class GraphError(FreebodyError, TypeError):
    """A traced scalar used in a way that a graph cannot record."""


class Graph:
    """The nodes of one trace: parallel lists `op`, `a`, `b`, operands by index, -1 where there is none.

    An input has in `a` its position among the inputs, a constant its position in `values`.
    """

    __slots__ = ("a", "b", "constant_of", "input_names", "interned", "op", "values")

    def __init__(self) -> None:
        self.op: list[str] = []
        self.a: list[int] = []
        self.b: list[int] = []
        self.values: list[float] = []
        self.input_names: list[str] = []
        self.interned: dict[Any, int] = {}
        self.constant_of: dict[int, float] = {}
        _constant(self, 0.0)
        _constant(self, 1.0)

    def __len__(self) -> int:
        return len(self.op)

    def input(self, name: str) -> Expr:
        """A new input."""
        self.input_names.append(name)
        return Expr(self, _node(self, "input", len(self.input_names) - 1, -1))

    def constant(self, value: float) -> Expr:
        """The node of a finite number."""
        return Expr(self, _constant(self, float(value)))

    def operand(self, value: Any) -> int:
        """Index of the node that stands for an Expr of this graph or a number; -1 for anything else."""
        if type(value) is Expr:
            if value.graph is not self:
                raise GraphError(
                    "scalars of two traces were mixed: a graph belongs to one trace. Do not keep traced scalars in "
                    "globals, closures or caches; pass them as arguments."
                )
            return value.index
        if isinstance(value, (float, int, Real)):
            return _constant(self, float(value))
        return -1

    def describe(self, index: int) -> str:
        """One node as text, for messages and printing."""
        op = self.op[index]
        if op == "const":
            return repr(self.constant_of[index])
        if op == "input":
            return self.input_names[self.a[index]]
        operands = (self.a[index], self.b[index])[: ARITY[op]]
        return f"{op}({', '.join(f'%{i}' for i in operands)})"


class Expr:
    """Handle on one node of a graph; behaves as a number under `+ - * / **`, `sin cos sqrt sign`.

    Two handles are equal if they stand for the same node. Comparing values is refused: what a trace does may
    depend on the structure of the robot, never on the value of a scalar.
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
        return NotImplemented if i < 0 else Expr(graph, _add(graph, self.index, i))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, _sub(graph, self.index, i))

    def __rsub__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, _sub(graph, i, self.index))

    def __mul__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, _mul(graph, self.index, i))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, _div(graph, self.index, i))

    def __rtruediv__(self, other: Any) -> Expr:
        graph = self.graph
        i = graph.operand(other)
        return NotImplemented if i < 0 else Expr(graph, _div(graph, i, self.index))

    def __neg__(self) -> Expr:
        return Expr(self.graph, _neg(self.graph, self.index))

    def __pos__(self) -> Expr:
        return self

    def __pow__(self, exponent: Any) -> Expr:
        if not isinstance(exponent, (int, float)) or exponent != int(exponent) or abs(exponent) > 64:
            raise GraphError(
                f"x ** {exponent!r}: the exponent of a traced scalar is a whole number from -64 to 64."
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

    def sin(self) -> Expr:
        """Sine."""
        return Expr(self.graph, _sin(self.graph, self.index))

    def cos(self) -> Expr:
        """Cosine."""
        return Expr(self.graph, _cos(self.graph, self.index))

    def sqrt(self) -> Expr:
        """Square root; NaN where negative."""
        return Expr(self.graph, _sqrt(self.graph, self.index))

    def sign(self) -> Expr:
        """-1, 0 or 1."""
        return Expr(self.graph, _sign(self.graph, self.index))

    def __eq__(self, other: object) -> bool:
        if type(other) is Expr:
            return other.graph is self.graph and other.index == self.index
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
        f"{what} of a traced scalar: it has no value yet. Branch on structure (joint kinds, the tree, a constant "
        "parameter), never on values."
    )


def _node(g: Graph, op: str, a: int, b: int) -> int:
    key = (op, a, b)
    index = g.interned.get(key)
    if index is None:
        index = g.interned[key] = len(g.op)
        g.op.append(op)
        g.a.append(a)
        g.b.append(b)
    return index


def _constant(g: Graph, value: float) -> int:
    index = g.interned.get(value)
    if index is None:
        if not math.isfinite(value):
            raise GraphError(f"the constant {value} in a traced computation: constants must be finite.")
        value += 0.0  # -0.0 becomes 0.0
        index = g.interned[value] = len(g.op)
        g.op.append("const")
        g.a.append(len(g.values))
        g.b.append(-1)
        g.values.append(value)
        g.constant_of[index] = value
    return index


def _add(g: Graph, i: int, j: int) -> int:
    if i > j:
        i, j = j, i
    if i == ZERO:
        return j
    op, value = g.op, g.constant_of
    if i in value and j in value:
        return _constant(g, value[i] + value[j])
    if op[i] == "neg":
        return _neg(g, _add(g, g.a[i], g.a[j])) if op[j] == "neg" else _sub(g, j, g.a[i])
    if op[j] == "neg":
        return _sub(g, i, g.a[j])
    return _node(g, "add", j, i) if j in value else _node(g, "add", i, j)


def _sub(g: Graph, i: int, j: int) -> int:
    if i == j:
        return ZERO
    if j == ZERO:
        return i
    if i == ZERO:
        return _neg(g, j)
    op, value = g.op, g.constant_of
    if j in value:
        return _constant(g, value[i] - value[j]) if i in value else _add(g, i, _constant(g, -value[j]))
    if op[j] == "neg":
        return _add(g, i, g.a[j])
    if op[i] == "neg":
        return _neg(g, _add(g, g.a[i], j))
    if i > j and i not in value:
        return _neg(g, _node(g, "sub", j, i))
    return _node(g, "sub", i, j)


def _mul(g: Graph, i: int, j: int) -> int:
    if i > j:
        i, j = j, i
    if i == ZERO:
        return ZERO
    if i == ONE:
        return j
    op, value = g.op, g.constant_of
    if op[i] == "neg":
        return _neg(g, _mul(g, g.a[i], j))
    if op[j] == "neg":
        return _neg(g, _mul(g, i, g.a[j]))
    if j in value:
        i, j = j, i
    if i in value:
        c = value[i]
        if j in value:
            return _constant(g, c * value[j])
        if c < 0.0:
            return _neg(g, _mul(g, _constant(g, -c), j))
        if (
            op[j] == "mul" and g.a[j] in value
        ):  # c1 (c2 x) = (c1 c2) x, unless the product over- or underflows
            both = c * value[g.a[j]]
            if 1e-290 < both < 1e290:
                return _mul(g, _constant(g, both), g.b[j])
    return _node(g, "mul", i, j)


def _div(g: Graph, i: int, j: int) -> int:
    op, value = g.op, g.constant_of
    if j == ONE or (i == ZERO and j != ZERO):
        return i
    if op[i] == "neg":
        return _neg(g, _div(g, g.a[i], j))
    if op[j] == "neg":
        return _neg(g, _div(g, i, g.a[j]))
    if j in value:
        c = value[j]
        if c == 0.0:
            raise GraphError("division by the constant 0 in a traced computation.")
        if i in value:
            return _constant(g, value[i] / c)
        if c < 0.0:
            return _neg(g, _div(g, i, _constant(g, -c)))
        if math.frexp(c)[0] == 0.5 and 1e-300 < c < 1e300:  # a power of two: the reciprocal is exact
            return _mul(g, i, _constant(g, 1.0 / c))
    elif i in value and value[i] < 0.0:
        return _neg(g, _div(g, _constant(g, -value[i]), j))
    return _node(g, "div", i, j)


def _neg(g: Graph, i: int) -> int:
    if i in g.constant_of:
        return _constant(g, -g.constant_of[i])
    if g.op[i] == "neg":
        return g.a[i]
    return _node(g, "neg", i, -1)


def _sin(g: Graph, i: int) -> int:
    if i in g.constant_of:
        return _constant(g, math.sin(g.constant_of[i]))
    if g.op[i] == "neg":
        return _neg(g, _sin(g, g.a[i]))
    return _node(g, "sin", i, -1)


def _cos(g: Graph, i: int) -> int:
    if i in g.constant_of:
        return _constant(g, math.cos(g.constant_of[i]))
    return _node(g, "cos", g.a[i] if g.op[i] == "neg" else i, -1)


def _sqrt(g: Graph, i: int) -> int:
    if i in g.constant_of:
        if g.constant_of[i] < 0.0:
            raise GraphError(f"square root of the constant {g.constant_of[i]} in a traced computation.")
        return _constant(g, math.sqrt(g.constant_of[i]))
    return _node(g, "sqrt", i, -1)


def _sign(g: Graph, i: int) -> int:
    if i in g.constant_of:
        return _constant(g, float((g.constant_of[i] > 0.0) - (g.constant_of[i] < 0.0)))
    if g.op[i] == "neg":
        return _neg(g, _sign(g, g.a[i]))
    return _node(g, "sign", i, -1)


FOLD: dict[str, Callable[..., int]] = {
    "neg": _neg,
    "sqrt": _sqrt,
    "sin": _sin,
    "cos": _cos,
    "sign": _sign,
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
}
"""The folding rules of each operation: (graph, operands) -> node. Passes rebuild programs through it."""
