"""The nodes of expressions, printed ones and those read from a text: a small immutable tree. What
builds them is in `expression`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, ClassVar, Self, dataclass_transform

Span = tuple[int, int]
"""Start and end of a piece of text."""

NOWHERE: Span = (-1, -1)

STYLES: dict[str, Callable[[Expression], str]] = {}
"""Ways of writing an expression: "text", "latex", "mathml". The renderers stand above the nodes and
fill it in."""


@dataclass_transform(frozen_default=True, eq_default=False)
@dataclass(frozen=True, eq=False, repr=False)
class Expression:
    """A node; `str` gives its text for a terminal.

    Two nodes with the same content are equal, unless they are pieces of a text: a piece is equal to
    itself alone.
    """

    span: Span = field(default=NOWHERE, kw_only=True)
    """The place in a text where the expression was read."""

    __match_args__: ClassVar[tuple[str, ...]] = ()
    """Names of the fields that are its content, as `dataclass` lists them."""

    def __init_subclass__(cls) -> None:
        """Make every subclass a frozen data class that shows itself in a shell by its text."""
        dataclass(frozen=True, eq=False, repr=False)(cls)

    def __eq__(self, other: object) -> bool:
        if self is other or type(self) is not type(other) or not isinstance(other, Expression):
            return self is other
        apart = self.span != NOWHERE or other.span != NOWHERE
        return not apart and self._content() == other._content()

    def __hash__(self) -> int:
        if self.span != NOWHERE:
            return object.__hash__(self)
        return hash((type(self), *self._content()))

    def _content(self) -> tuple[Any, ...]:
        return tuple([getattr(self, name) for name in self.__match_args__])

    @property
    def parts(self) -> tuple[Expression, ...]:
        """The nodes of which the expression is made."""
        return tuple(_expressions(self._content()))

    def mapped(self, f: Callable[[Expression], Expression]) -> Self:
        """The node with f applied to each of its parts; the node itself where nothing changes."""
        new = list(map(f, self.parts))
        if all(a is b for a, b in zip(new, self.parts, strict=True)):
            return self
        rest = iter(new)
        return replace(self, **{x: _filled(getattr(self, x), rest) for x in self.__match_args__})

    def __str__(self) -> str:
        return STYLES["text"](self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"

    def latex(self) -> str:
        """The expression as LaTeX, without dollar signs."""
        return STYLES["latex"](self)

    def mathml(self) -> str:
        """The expression as a `<math>` element."""
        return STYLES["mathml"](self)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(str(self))


def _expressions(content: tuple[Any, ...]) -> list[Expression]:
    found = []
    for x in content:
        if isinstance(x, Expression):
            found.append(x)
        elif isinstance(x, tuple):
            found += _expressions(x)
    return found


def _filled(x: Any, rest: Iterator[Expression]) -> Any:
    """A field's content with its expressions replaced by the next ones of `rest`."""
    if isinstance(x, tuple):
        return tuple(_filled(entry, rest) for entry in x)
    return next(rest) if isinstance(x, Expression) else x


def nodes(x: Expression) -> Iterator[Expression]:
    """An expression and all nodes inside it, each before its parts."""
    waiting = [x]
    while waiting:
        node = waiting.pop()
        yield node
        waiting += reversed(node.parts)


def replaced(x: Expression, new: Mapping[Expression, Expression]) -> Expression:
    """An expression with some of its nodes exchanged."""
    return new[x] if x in new else x.mapped(lambda part: replaced(part, new))


class Number(Expression):
    """An exact number; `decimal` prints 1/2 as 0.5."""

    value: Fraction
    decimal: bool = False


class Symbol(Expression):
    """A letter with subscripts, dots and a superscript, bold for vectors; `name` is its name in
    code."""

    name: str
    letter: str
    low: tuple[str, ...] = ()
    dots: int = 0
    bold: bool = False
    high: str = ""


class Sum(Expression):
    """Terms added up; a `Negative` term prints with its minus."""

    terms: tuple[Expression, ...]


class Negative(Expression):
    """The opposite of an operand, -a."""

    operand: Expression


class Product(Expression):
    """A product of factors side by side."""

    factors: tuple[Expression, ...]


class Quotient(Expression):
    """A fraction, above / below."""

    above: Expression
    below: Expression


class Power(Expression):
    """A base raised to a whole exponent; -1 of a matrix is its inverse."""

    base: Expression
    exponent: int


class Transposed(Expression):
    """Transpose of a vector or matrix."""

    operand: Expression


class Function(Expression):
    """sin, cos, sgn, … of one argument."""

    name: str
    argument: Expression


class Arguments(Expression):
    """Several arguments of one function, atan2(y, x)."""

    entries: tuple[Expression, ...]


class Derivative(Expression):
    """∂ of / ∂ by, or d of / d by; by the time where `by` is the symbol t."""

    of: Expression
    by: Expression
    partial: bool = False


class Cross(Expression):
    """left × right: in space a vector, in the plane the scalar a₁b₂ - a₂b₁."""

    left: Expression
    right: Expression


class Dot(Expression):
    """A dot product, left · right."""

    left: Expression
    right: Expression


class Vector(Expression):
    """A column vector of components."""

    entries: tuple[Expression, ...]


class Matrix(Expression):
    """A matrix as rows of entries."""

    rows: tuple[tuple[Expression, ...], ...]


class Equation(Expression):
    """Sides that are equal: two, or more in a chain."""

    sides: tuple[Expression, ...]

    @property
    def lhs(self) -> Expression:
        """Left side of an equation; of a chain, the first side."""
        return self.sides[0]

    @property
    def rhs(self) -> Expression:
        """Right side of an equation; of a chain, the last side."""
        return self.sides[-1]


class Conditioned(Expression):
    """An expression with the conditions under which it holds, each an equation: `m₂ = 0, I₂ = 0:
    τ₁`."""

    conditions: tuple[Expression, ...]
    operand: Expression


class Sourced(Expression):
    """A term with a word for its source, which pages show by colour and underline."""

    operand: Expression
    source: str


class Words(Expression):
    """Upright words inside a formula."""

    text: str
