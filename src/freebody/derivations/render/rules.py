"""What all renderers share: which node needs brackets where, how sums take signs, numbers their
digits."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any

from freebody.derivations.expression import (
    Cross,
    Derivative,
    Dot,
    Equation,
    Expression,
    Function,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Words,
)

EQUATION, SUM, PRODUCT, CALL, POWER, ATOM = range(6)

_PRECEDENCE: dict[type, int] = {
    Equation: EQUATION,
    Sum: SUM,
    Negative: SUM,
    Product: PRODUCT,
    Cross: PRODUCT,
    Dot: PRODUCT,
    Quotient: PRODUCT,
    Derivative: PRODUCT,
    Words: EQUATION,
    Function: CALL,
    Power: POWER,
}

BREAK = "\u2028"
"""Stands where a line may be broken, in place of the space before a sign."""

DIGITS = 6
"""Significant digits of a decimal in print; code gets all of them."""


def precedence(node: Expression) -> int:
    """How tightly a node binds; brackets go around what binds less than its surroundings need."""
    if isinstance(node, Number):
        return (
            SUM
            if node.value < 0
            else ATOM
            if node.value.denominator == 1 or node.decimal
            else PRODUCT
        )
    return _PRECEDENCE.get(type(node), ATOM)


class Renderer:
    """A table from node type to a (node, render) -> string; `render(node, level)` puts brackets
    where needed."""

    def __init__(
        self, table: dict[type, Callable[..., str]], brackets: tuple[str, str] = ("(", ")")
    ):
        self.table = table
        self.brackets = brackets

    def __call__(self, node: Expression, level: int = EQUATION) -> str:
        string = self.table[type(node)](node, self)
        if precedence(node) < level:
            return self.brackets[0] + string + self.brackets[1]
        return string


def signed(terms: Iterable[Expression]) -> list[tuple[bool, Expression]]:
    """(is negative, what stands behind the sign) of each term."""
    rows = []
    for term in terms:
        if isinstance(term, Negative):
            rows.append((True, term.operand))
        elif isinstance(term, Number) and term.value < 0:
            rows.append((True, Number(-term.value, term.decimal)))
        else:
            rows.append((False, term))
    return rows


def summed(node: Sum, render: Any, plus: str, minus: str, lead: str) -> str:
    """A sum: signs between the terms, a leading minus in front."""
    pieces = []
    for k, (negative, term) in enumerate(signed(node.terms)):
        sign = (lead if negative else "") if k == 0 else (minus if negative else plus)
        pieces.append(sign + render(term, PRODUCT))
    return "".join(pieces)


def whole(string: str) -> str:
    """A string that is not to be broken."""
    return string.replace(BREAK, " ")


def digits(value: Fraction) -> tuple[str, int]:
    """Mantissa and power of ten (0: none) of a number as decimal."""
    string = f"{float(value):.{DIGITS}g}"
    mantissa, _, exponent = string.partition("e")
    if exponent and 0 < int(exponent) < 10:
        return f"{float(value):.0f}", 0
    return mantissa, int(exponent or 0)
