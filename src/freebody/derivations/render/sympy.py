"""Expressions as SymPy expressions; SymPy is imported when one is asked for."""

from __future__ import annotations

from typing import Any

from freebody.derivations.expression import (
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
    Vector,
)
from freebody.errors import FreebodyError


def to_sympy(node: Expression) -> Any:
    """The same expression in SymPy; symbols are real and carry the names of code (theta1, theta1_d,
    l1, …)."""
    import sympy

    if type(node) not in _TABLE:
        raise FreebodyError(f"{node}: {type(node).__name__} has no counterpart in SymPy.")
    return _TABLE[type(node)](node, sympy)


_NAMES = {x: x for x in ("sin", "cos", "tan", "sqrt", "exp", "log")} | {"sgn": "sign"}

_TABLE: dict[type, Any] = {
    Number: lambda node, sympy: sympy.Rational(node.value.numerator, node.value.denominator),
    Symbol: lambda node, sympy: sympy.Symbol(node.name, real=True),
    Sum: lambda node, sympy: sympy.Add(*map(to_sympy, node.terms)),
    Negative: lambda node, sympy: -to_sympy(node.operand),
    Product: lambda node, sympy: sympy.Mul(*map(to_sympy, node.factors)),
    Quotient: lambda node, sympy: to_sympy(node.above) / to_sympy(node.below),
    Power: lambda node, sympy: to_sympy(node.base) ** node.exponent,
    Function: lambda node, sympy: getattr(sympy, _NAMES[node.name])(to_sympy(node.argument)),
    Vector: lambda node, sympy: sympy.Matrix([to_sympy(x) for x in node.entries]),
    Matrix: lambda node, sympy: sympy.Matrix([[to_sympy(x) for x in row] for row in node.rows]),
}
