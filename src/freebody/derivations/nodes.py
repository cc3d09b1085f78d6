"""The nodes of expressions as they are printed: a small immutable tree. What builds them is in
`expression`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

STYLES: dict[str, Callable[[Expression], str]] = {}
"""How an expression is written: "text", "latex", "mathml". The renderers stand above the nodes and
fill it in."""


class Expression:
    """A node; `str` gives its text for a terminal."""

    def __str__(self) -> str:
        return STYLES["text"](self)

    def latex(self) -> str:
        """LaTeX, without dollar signs."""
        return STYLES["latex"](self)

    def mathml(self) -> str:
        """A `<math>` element."""
        return STYLES["mathml"](self)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(str(self))


@dataclass(frozen=True)
class Number(Expression):
    """An exact number; `decimal` prints 1/2 as 0.5."""

    value: Fraction
    decimal: bool = False


@dataclass(frozen=True)
class Symbol(Expression):
    """A letter with subscripts, dots and a superscript; `name` is what it is called in code. Bold
    for vectors."""

    name: str
    letter: str
    low: tuple[str, ...] = ()
    dots: int = 0
    bold: bool = False
    high: str = ""


@dataclass(frozen=True)
class Sum(Expression):
    """Terms added up; a `Negative` term prints with its minus."""

    terms: tuple[Expression, ...]


@dataclass(frozen=True)
class Negative(Expression):
    """- operand."""

    operand: Expression


@dataclass(frozen=True)
class Product(Expression):
    """Factors side by side."""

    factors: tuple[Expression, ...]


@dataclass(frozen=True)
class Quotient(Expression):
    """above / below."""

    above: Expression
    below: Expression


@dataclass(frozen=True)
class Power(Expression):
    """base to a whole exponent; -1 of a matrix is its inverse."""

    base: Expression
    exponent: int


@dataclass(frozen=True)
class Transposed(Expression):
    """Transpose of a vector or matrix."""

    operand: Expression


@dataclass(frozen=True)
class Function(Expression):
    """sin, cos, sgn, … of one argument."""

    name: str
    argument: Expression


@dataclass(frozen=True)
class Arguments(Expression):
    """Several arguments of one function, atan2(y, x)."""

    entries: tuple[Expression, ...]


@dataclass(frozen=True)
class Derivative(Expression):
    """∂ of / ∂ by, or d of / d by; by the time where `by` is the symbol t."""

    of: Expression
    by: Expression
    partial: bool = False


@dataclass(frozen=True)
class Cross(Expression):
    """left × right: in space a vector, in the plane the scalar a₁b₂ - a₂b₁."""

    left: Expression
    right: Expression


@dataclass(frozen=True)
class Dot(Expression):
    """left · right."""

    left: Expression
    right: Expression


@dataclass(frozen=True)
class Vector(Expression):
    """A column of components."""

    entries: tuple[Expression, ...]


@dataclass(frozen=True)
class Matrix(Expression):
    """Rows of entries."""

    rows: tuple[tuple[Expression, ...], ...]


@dataclass(frozen=True)
class Equation(Expression):
    """Sides that are equal: two, or more in a chain."""

    sides: tuple[Expression, ...]

    @property
    def lhs(self) -> Expression:
        """The first side."""
        return self.sides[0]

    @property
    def rhs(self) -> Expression:
        """The last side."""
        return self.sides[-1]


@dataclass(frozen=True)
class Words(Expression):
    """Upright words inside a formula."""

    text: str
