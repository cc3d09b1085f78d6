"""The value of a printed expression at numbers: what a reader would compute from the page.

Expressions are results of public functions; their kinds are told by name, as their repr does.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import freebody as fb

FUNCTIONS = {"sin": np.sin, "cos": np.cos, "sgn": np.sign}


def evaluate(node: Any, values: Mapping[str, Any]) -> Any:
    """A number or array; `values` gives each symbol's by name. Of an equation the last side;
    vectors become rows. Raises UnknownNameError for a symbol without value."""

    def at(node: Any) -> Any:
        if type(node).__name__ != "Symbol":
            return _RULES[type(node).__name__](node, at)
        if node.name not in values:
            raise fb.UnknownNameError("value", node.name, "the values given", values)
        return values[node.name]

    return at(node)


_RULES = {
    "Number": lambda node, at: float(node.value),
    "Sum": lambda node, at: functools.reduce(operator.add, map(at, node.terms)),
    "Product": lambda node, at: functools.reduce(operator.mul, map(at, node.factors)),
    "Negative": lambda node, at: -at(node.operand),
    "Sourced": lambda node, at: at(node.operand),
    "Quotient": lambda node, at: at(node.above) / at(node.below),
    "Power": lambda node, at: at(node.base) ** node.exponent,
    "Transposed": lambda node, at: np.swapaxes(at(node.operand), -1, -2),
    "Function": lambda node, at: FUNCTIONS[node.name](at(node.argument)),
    "Cross": lambda node, at: _cross(at(node.left), at(node.right)),
    "Dot": lambda node, at: np.sum(at(node.left) * at(node.right), axis=-1),
    "Vector": lambda node, at: _stacked(map(at, node.entries), -1),
    "Matrix": lambda node, at: _stacked((_stacked(map(at, row), -1) for row in node.rows), -2),
    "Equation": lambda node, at: at(node.rhs),
}


def _stacked(entries: Any, axis: int) -> Any:
    return np.stack(np.broadcast_arrays(*entries), axis=axis)


def _cross(a: Any, b: Any) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0] if a.shape[-1] == 2 else np.cross(a, b)


def parts(node: Any) -> Iterator[Any]:
    """An expression and all that it is made of, from the outside in."""
    yield node
    for part in node.parts:
        yield from parts(part)


def is_a(node: Any, *kinds: str) -> bool:
    """Whether an expression is of one of these kinds, by name."""
    return type(node).__name__ in kinds
