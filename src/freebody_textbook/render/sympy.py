"""Expressions as SymPy expressions; SymPy is imported when one is asked for."""

from __future__ import annotations

from typing import Any

from freebody.errors import FreebodyError, MissingPackageError
from freebody.expressions.evaluate import NoValue, arithmetic, evaluate
from freebody.expressions.expression import Expression, Function, Matrix, Symbol, Vector

_NAMES = {x: x for x in ("sin", "cos", "tan", "sqrt", "exp", "log")} | {"sgn": "sign"}


def to_sympy(node: Expression) -> Any:
    """The same expression in SymPy; symbols are real and carry the names of code (theta1, theta1_d,
    l1, …).

    Raises MissingPackageError, FreebodyError.
    """
    try:
        import sympy
    except ImportError:
        raise MissingPackageError("to_sympy", "SymPy", "sympy") from None

    rules = {
        **arithmetic(
            lambda number: sympy.Rational(number.numerator, number.denominator),
            total=lambda terms: sympy.Add(*terms),
            product=lambda factors: sympy.Mul(*factors),
        ),
        Symbol: lambda node, at: sympy.Symbol(node.name, real=True),
        Function: lambda node, at: getattr(sympy, _NAMES[node.name])(at(node.argument)),
        Vector: lambda node, at: sympy.Matrix(list(map(at, node.entries))),
        Matrix: lambda node, at: sympy.Matrix([list(map(at, row)) for row in node.rows]),
    }
    try:
        return evaluate(node, rules)
    except NoValue as problem:
        kind = type(problem.node).__name__
        raise FreebodyError(f"{problem.node}: {kind} has no counterpart in SymPy.") from None
