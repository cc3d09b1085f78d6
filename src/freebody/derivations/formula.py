"""Formulas with vectors written as text, `tau1 - cross(s1, f12) = I1*omega1_d`: read, printed and
evaluated.

The text has Python's arithmetic, `^` for powers, [a, b] for vectors and [[a, b], [c, d]] for
matrices. It is parsed, never run. Names are those that print as in the notes: theta1_d is θ̇₁, sc1
is s_c1, R2_1 is R with subscript 1 and superscript 2; omega_i, omega_h, omega_k are those of link
i, i-1 and i+1.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Collection
from dataclasses import replace
from fractions import Fraction
from typing import Any

from freebody.derivations import expression as ex
from freebody.derivations.expression import Equation, Expression, Symbol
from freebody.derivations.names import GREEK, sym
from freebody.errors import FreebodyError

LONGEST = 4000
"""Characters that are read."""

FUNCTIONS = (
    "sin", "cos", "tan", "sqrt", "exp", "log", "arcsin", "arccos", "arctan", "norm", "det", "sum", "diag", "skew",
)  # fmt: skip
"""Functions of one argument; `sum` adds up what is given for each of several bodies."""

PRINTED = {"sum": "∑"}

SPECIAL: dict[str, tuple] = {
    "gravity": ("g",), "qd": ("q", (), 1), "qdd": ("q", (), 2), "qdd_back": ("q", ("back",), 2),
}  # fmt: skip
"""Vectors whose names are words: letter, subscripts, dots."""

GENERAL = {"i": "i", "h": "i−1", "k": "i+1"}
"""Endings of names that stand for a link's number."""


class FormulaError(FreebodyError, ValueError):
    """A formula that cannot be read or evaluated."""


def parse(text: str, bold: Collection[str] = (), primed: Collection[str] = ()) -> Expression:
    """A formula as it is printed: an equation where it has an =, else one expression.

    Names in `bold` are vectors, those in `primed` have components in the axes of their own body.
    """
    if len(text) > LONGEST:
        raise FormulaError(f"the formula has {len(text)} characters; at most {LONGEST} are read.")
    sides = [_Parser(side, bold, primed).expression() for side in text.split("=")]
    return sides[0] if len(sides) == 1 else Equation(tuple(sides))


def symbol(name: str, bold: bool = False, primed: bool = False) -> Any:
    """The symbol of a name, those of links with letters for numbers included; omega_prime is ω with
    a prime."""
    if primed or "_prime" in name:
        plain = symbol(name.replace("_prime", ""), bold)
        return replace(plain, name=name, high="′") if isinstance(plain, Symbol) else plain
    high = re.fullmatch(r"([A-Za-z]+)([\dihk])_([\dihk])", name)
    if high:
        letter, up, low = high.groups()
        return Symbol(name, letter, (GENERAL.get(low, low),), bold=True, high=GENERAL.get(up, up))
    if re.fullmatch(r"w(\d|_[ihk])", name):
        return replace(
            symbol("omega" + name[1:], bold), name=name
        )  # ω with components in the world
    match = re.fullmatch(r"([A-Za-z]+?)(c?)_([ihk]{1,2})(_dd|_d)?", name)
    if match is None:
        return Symbol(name, *SPECIAL[name], bold=True) if name in SPECIAL else sym(name, bold)
    letters, centre, places, dots = match.groups()
    if letters + centre in GREEK:
        letters, centre = letters + centre, ""
    low = [GENERAL[place] for place in places]
    low[0] = centre + low[0]
    return Symbol(name, GREEK.get(letters, letters), tuple(low), len(dots or "_") - 1, bold)


class _Parser:
    """One side of a formula, by Python's own grammar, of which a few nodes are let in."""

    def __init__(self, text: str, bold: Collection[str], primed: Collection[str]):
        self.text = text.strip().replace("^", "**")
        self.bold, self.primed = bold, primed

    def expression(self) -> Expression:
        try:
            tree = ast.parse(self.text, mode="eval").body
            return self._read(tree)
        except SyntaxError as problem:
            raise FormulaError(
                f"the formula {self.text!r} cannot be read: {problem.msg}."
            ) from None
        except RecursionError:
            raise FormulaError("the formula has too many brackets inside one another.") from None

    def _read(self, node: ast.expr) -> Expression:
        match node:
            case ast.Constant(value=int() | float()):
                return self._number(node)
            case ast.Name(id=name):
                return symbol(name, name in self.bold, name in self.primed)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return ex.neg(self._read(operand))
            case ast.BinOp(left=left, op=operator, right=right):
                return self._pair(self._read(left), operator, self._read(right), right)
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(name, [self._read(x) for x in arguments])
            case ast.List(elts=rows) if rows and all(isinstance(row, ast.List) for row in rows):
                return ex.matrix([[self._read(x) for x in row.elts] for row in rows])  # type: ignore[attr-defined]
            case ast.List(elts=entries) if entries:
                return ex.vector(*map(self._read, entries))
        raise FormulaError(f"{ast.unparse(node)!r} has no meaning in a formula.")

    def _number(self, node: ast.Constant) -> Expression:
        digits = ast.get_source_segment(self.text, node) or str(node.value)
        return ex.num(Fraction(digits), decimal="." in digits or "e" in digits)

    def _pair(
        self, a: Expression, operator: ast.operator, b: Expression, right: ast.expr
    ) -> Expression:
        match operator:
            case ast.Add():
                return ex.add(a, b)
            case ast.Sub():
                return ex.sub(a, b)
            case ast.Mult():
                return ex.mul(a, b)
            case ast.Div():
                return ex.div(a, b)
            case ast.Pow() if isinstance(b, ex.Number) and b.value.denominator == 1:
                return ex.power(a, int(b.value))
            case ast.Pow() if b == ex.num(-1):
                return ex.power(a, -1)
        raise FormulaError(f"{ast.unparse(right)!r} is no whole number, which a power must be.")

    def _call(self, name: str, arguments: list[Expression]) -> Expression:
        rules: dict[str, Callable[..., Expression]] = {
            "cross": ex.cross, "dot": ex.dot, "transpose": ex.transposed, "d_dt": ex.d_dt, "partial": ex.partial,
            "atan2": lambda y, x: ex.Function("atan2", ex.Arguments((y, x))),
        }  # fmt: skip
        rules |= {f: lambda x, f=f: ex.Function(PRINTED.get(f, f), x) for f in FUNCTIONS}
        if name not in rules:
            raise FormulaError(
                f"no function {name!r} in a formula; there are {', '.join(sorted(rules))}."
            )
        try:
            return rules[name](*arguments)
        except TypeError:
            raise FormulaError(f"{name} is given {len(arguments)} arguments.") from None


def as_printed(text: str, bold: Collection[str] = (), primed: Collection[str] = ()) -> Expression:
    """A formula, or the text itself in upright words where it is none."""
    try:
        return parse(text, bold, primed)
    except FormulaError:
        return ex.Words(text)


def names_in(node: Expression) -> list[str]:
    """Names of the symbols of a formula, each once."""
    return list(dict.fromkeys(part.name for part in ex.nodes(node) if isinstance(part, Symbol)))
