"""The operations of a program, a record each.

A target adds what is its own: how it computes or writes the operation, in a table by the same
names, which a test holds to be complete.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from freebody.scalars import folding
from freebody.scalars.nodes import ONE, ZERO, GraphError, Nodes


@dataclass(frozen=True)
class Operation:
    """An operation of programs, for passes, targets and tracing.

    number: of floats; folds constants.
    fold: (nodes, *operands) -> the node of something simpler; None: there is nothing simpler.
    symmetry: odd, f(-x) = -f(x), or even, f(-x) = f(x), in the first operand.
    commutes: whether its two operands may be swapped.
    cost: of one, in additions.
    """

    name: str
    arity: int
    number: Callable[..., Any]
    fold: Callable[..., int | None] | None = None
    symmetry: Literal["odd", "even"] | None = None
    commutes: bool = False
    cost: float = 1.0

    def node(self, g: Nodes, *operands: int) -> int:
        """The index of the node of the operation on other nodes, simplified."""
        simpler = None if self.fold is None else self.fold(g, *operands)
        if simpler is not None:
            return simpler
        known = g.constant_of
        if all(i in known for i in operands):
            return self._constant(g, *(known[i] for i in operands))
        if self.symmetry and g.op[operands[0]] == "neg":
            made = self.node(g, g.a[operands[0]], *operands[1:])
            return made if self.symmetry == "even" else folding.neg(g, made)
        return g.node(self.name, *(sorted(operands) if self.commutes else operands))

    def _constant(self, g: Nodes, *values: float) -> int:
        try:
            return g.number(float(self.number(*values)))
        except (ValueError, OverflowError):
            given = ", ".join(map(repr, values))
            raise GraphError(
                f"{self.name}({given}) has no finite value: constants of a traced computation must "
                f"have one."
            ) from None


def _alike(of_equals: int | None) -> Callable[[Nodes, int, int], int | None]:
    """The simplification of an operation whose two operands are the same node: to that node, or to
    a constant."""

    def fold(g: Nodes, a: int, b: int) -> int | None:
        return (a if of_equals is None else of_equals) if a == b else None

    return fold


def _where(g: Nodes, condition: int, a: int, b: int) -> int | None:
    if condition in g.constant_of:
        return a if g.constant_of[condition] else b
    return a if a == b else None


def _absolute(g: Nodes, a: int) -> int | None:
    return a if g.op[a] in ("absolute", "sqrt") else None


def _epsilon(g: Nodes, a: int) -> int | None:
    """The node of the unit of rounding for an operand, taken from an input that it comes from,
    which has the same number type; None for constants."""
    while ARITY[g.op[a]]:
        operands = (g.a[a], g.b[a], g.c[a])
        a = next(i for i in operands if i >= 0 and i not in g.constant_of)
    return None if a in g.constant_of else g.node("epsilon", a)


_RECORDS = (
    Operation("neg", 1, operator.neg, fold=folding.neg),
    Operation("add", 2, operator.add, fold=folding.add),
    Operation("sub", 2, operator.sub, fold=folding.sub),
    Operation("mul", 2, operator.mul, fold=folding.mul),
    Operation("div", 2, operator.truediv, fold=folding.div, cost=8.0),
    Operation("sqrt", 1, math.sqrt, cost=8.0),
    Operation("sin", 1, math.sin, symmetry="odd", cost=15.0),
    Operation("cos", 1, math.cos, symmetry="even", cost=15.0),
    Operation("exp", 1, math.exp, cost=15.0),
    Operation("log", 1, math.log, cost=15.0),
    Operation("tanh", 1, math.tanh, symmetry="odd", cost=25.0),
    Operation("atan2", 2, math.atan2, symmetry="odd", cost=30.0),
    Operation(
        "asin",
        1,
        math.asin,
        symmetry="odd",
        cost=15.0,
    ),
    Operation("acos", 1, math.acos, cost=15.0),
    Operation("sign", 1, lambda x: (x > 0.0) - (x < 0.0), symmetry="odd"),
    Operation("absolute", 1, abs, fold=_absolute, symmetry="even"),
    Operation("less", 2, operator.lt, fold=_alike(ZERO)),
    Operation("less_equal", 2, operator.le, fold=_alike(ONE)),
    Operation("equal", 2, operator.eq, fold=_alike(ONE), commutes=True),
    Operation("where", 3, lambda c, a, b: a if c else b, fold=_where),
    Operation("minimum", 2, min, fold=_alike(None), commutes=True),
    Operation("maximum", 2, max, fold=_alike(None), commutes=True),
    Operation("epsilon", 1, lambda x: 2.0**-52, fold=_epsilon),  # constants have 64 bits
)

OPERATIONS: dict[str, Operation] = {record.name: record for record in _RECORDS}
"""Every operation by its name."""

ARITY: dict[str, int] = {"input": 0, "const": 0} | {
    name: record.arity for name, record in OPERATIONS.items()
}
"""Number of operands of each kind of node."""
