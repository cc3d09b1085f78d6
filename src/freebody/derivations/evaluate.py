"""The value of a printed expression at numbers: what a reader would compute from the page."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import Any

import numpy as np

from freebody.derivations.expression import (
    Cross,
    Dot,
    Equation,
    Expression,
    Function,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    Transposed,
    Vector,
)
from freebody.errors import FreebodyError, UnknownNameError

FUNCTIONS = {"sin": np.sin, "cos": np.cos, "sgn": np.sign}


def evaluate(node: Expression, values: Mapping[str, Any]) -> Any:
    """A number or array; `values` gives each symbol's by name. Of an equation the last side;
    vectors become rows."""
    rule = _RULES.get(type(node))
    if rule is None:
        raise FreebodyError(f"{node} has no value: {type(node).__name__} is for print only.")
    return rule(node, lambda part: evaluate(part, values), values)


def _symbol(node: Symbol, at: Any, values: Mapping[str, Any]) -> Any:
    if node.name not in values:
        raise UnknownNameError("value", node.name, "the values given", values)
    return values[node.name]


def _cross(node: Cross, at: Any, values: Any) -> Any:
    a, b = np.asarray(at(node.left)), np.asarray(at(node.right))
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0] if a.shape[-1] == 2 else np.cross(a, b)


_RULES: dict[type, Any] = {
    Number: lambda node, at, _: node.value.numerator / node.value.denominator,
    Symbol: _symbol,
    Sum: lambda node, at, _: reduce(lambda a, b: a + b, map(at, node.terms)),
    Negative: lambda node, at, _: -at(node.operand),
    Product: lambda node, at, _: reduce(lambda a, b: a * b, map(at, node.factors)),
    Quotient: lambda node, at, _: at(node.above) / at(node.below),
    Power: lambda node, at, _: at(node.base) ** node.exponent,
    Transposed: lambda node, at, _: np.swapaxes(np.asarray(at(node.operand)), -1, -2),
    Function: lambda node, at, _: FUNCTIONS[node.name](at(node.argument)),
    Cross: _cross,
    Dot: lambda node, at, _: np.sum(
        np.asarray(at(node.left)) * np.asarray(at(node.right)), axis=-1
    ),
    Vector: lambda node, at, _: np.stack(np.broadcast_arrays(*map(at, node.entries)), axis=-1),
    Matrix: lambda node, at, _: np.stack(
        np.broadcast_arrays(*(at(Vector(row)) for row in node.rows)), axis=-2
    ),
    Equation: lambda node, at, _: at(node.rhs),
}
