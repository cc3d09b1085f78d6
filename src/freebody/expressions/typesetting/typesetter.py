"""The walk that sets an expression in any notation: what needs brackets where, how sums take signs,
products gaps and functions their arguments. A notation is a record that says how it writes the
pieces."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from freebody.expressions.nodes import (
    Arguments,
    Conditioned,
    Cross,
    Derivative,
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
    Sourced,
    Sum,
    Symbol,
    Transposed,
    Vector,
    Words,
    nodes,
)
from freebody.outputs.number_text import mantissa_and_exponent

BREAK = "\u2028"
"""Stands where a line may be broken, in place of the space before a sign."""


_SHORT, _LONG = (Symbol, Number, Derivative), range(7, 13)
"""Entries of which a column stands as a row with ᵀ, and how many: fewer are not high, more are as
wide as a page."""

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

DIGITS = 6
"""Significant digits of a decimal in print; code gets all of them."""


def precedence(node: Expression) -> int:
    """The strength with which a node binds; brackets go around what binds less than its
    surroundings need."""
    if isinstance(node, Number):
        if node.value < 0:
            return SUM
        return ATOM if node.value.denominator == 1 or node.decimal else PRODUCT
    if isinstance(node, Sourced):
        return precedence(node.operand)
    return _PRECEDENCE.get(type(node), ATOM)


def is_call(node: Expression) -> bool:
    """Whether an expression is a function or a power of one, so that its argument may stand without
    brackets."""
    return isinstance(node, Function) or (
        isinstance(node, Power) and isinstance(node.base, Function)
    )


def _called(node: Expression) -> Function:
    """The function of an expression for which `is_call` is true."""
    function = node.base if isinstance(node, Power) else node
    assert isinstance(function, Function)
    return function


def _has_factors(argument: Expression) -> bool:
    """Whether an argument without brackets would read on into a following factor, as products,
    fractions and products of vectors do."""
    if isinstance(argument, Product):
        return sum(not isinstance(factor, Number) for factor in argument.factors) > 1
    return isinstance(argument, Quotient | Cross | Dot)


@dataclass(frozen=True, kw_only=True)
class Notation:
    """A typesetting notation: templates of the text around the pieces of each kind of node, and
    functions where a template is not enough.

    A matrix or column: what is around it, between its rows, and between the entries of a row.
    """

    digits: Callable[[str], str] = str
    """A number's digits and sign."""
    ratio: Callable[[Fraction], str] = str
    """How a fraction of two numbers is set."""
    symbol: Callable[[Symbol, str], str]
    """A symbol, with an exponent as `exponent` gives it, or ""."""
    exponent: Callable[[int], str] = str
    gap: Callable[[Expression, Expression], str] = lambda before, after: " "
    """The text between two factors."""
    function: Callable[[str], str] = str
    """How a function's name is set."""
    tight: Callable[[str], str] = str
    """An argument without the spaces around its signs."""
    words: Callable[[str], str] = str
    """How words are set upright."""
    sourced: Callable[[str, str], str] = lambda source, term: term
    """A term by where it came from; it may be broken."""
    finished: Callable[[list[str]], list[str]] = list
    """A last change of a formula that has been broken into lines."""
    plus: str = f"{BREAK}+ "
    minus: str = f"{BREAK}− "
    lead: str = "−"
    brackets: str = "({})"
    tall_brackets: str = "({})"
    """Brackets around an expression that has a fraction in it."""
    cross: str = " × "
    dot: str = " · "
    equals: str = " = "
    comma: str = ", "
    colon: str = ": "
    """Behind the conditions under which something holds."""
    tenfold: str = "·"
    """Sign between a decimal's digits and its power of ten."""
    differentials: tuple[str, str] = ("d", "∂")
    transposed: str = "ᵀ"
    inverse_transposed: str = "⁻ᵀ"
    space: str = " "
    """The text in place of a `BREAK` where no line may be broken."""
    raised: str = "{}{}"
    group: str = "{}"
    """Several pieces as one; where this is an element, no line is broken in it."""
    line: str = "{}"
    """Text around a whole formula."""
    width: Callable[[str], float] = len
    """About how wide a string is, in letters."""
    applied: str = "{} {}"
    bracketed: str = "{}({})"
    """A function with its argument, and with brackets around that."""
    norm: str = "|{}|"
    root: str = "√{}"
    fraction: str = "{}/{}"
    bar: bool = True
    """Whether a fraction has a bar as wide as both, so that nothing in it needs brackets or is
    broken."""
    brackets_before_factors: bool = False
    """Whether a function before a factor needs brackets, lest that is read as its argument."""
    operand: str = " ({})"
    """The template of the operand of a derivative that stands before it."""
    matrix: tuple[str, str, str] = ("[{}]", "; ", ", ")
    column: tuple[str, str, str] | None = None
    """The templates of a column, where it has another form than a matrix."""


class Typesetter:
    """Expressions as strings in a notation: `setter(node, level)` puts brackets where needed."""

    fraction_levels = CALL, POWER
    """The strength with which numerator and denominator must bind to stand without brackets in a
    line."""

    def __init__(self, notation: Notation):
        self.notation = notation

    def __call__(self, node: Expression, level: int = EQUATION) -> str:
        """The string of an expression in the notation, with `BREAK` where a line may end."""
        string = self._rules[type(node)](self, node)
        if precedence(node) >= level:
            return string
        form, tall = self.notation.brackets, self.notation.tall_brackets
        if form != tall and any(isinstance(part, Quotient) for part in nodes(node)):
            form = tall
        return form.format(string)

    def whole(self, node: Expression, level: int = EQUATION) -> str:
        """The string of an expression that is not to be broken into lines."""
        return self(node, level).replace(BREAK, self.notation.space)

    def line(self, node: Expression) -> str:
        """The string of a whole formula on one line."""
        return self._finished([self.whole(node)])[0]

    def lines(self, node: Expression, room: float) -> list[str]:
        """An expression in lines of about so many letters, broken before signs."""
        return self._finished(broken(self(node), room, self.notation.width))

    def _finished(self, lines: list[str]) -> list[str]:
        return [self.notation.line.format(line) for line in self.notation.finished(lines)]

    def _number(self, node: Number) -> str:
        n, value = self.notation, node.value
        if value.denominator == 1 and not (node.decimal and abs(value) >= 10**6):
            return n.digits(str(value))
        if not node.decimal:
            return n.ratio(value)
        mantissa, exponent = mantissa_and_exponent(float(value), DIGITS)
        if not exponent:
            return n.digits(mantissa)
        return (
            n.digits(mantissa) + n.tenfold + n.raised.format(n.digits("10"), n.exponent(exponent))
        )

    def _sum(self, node: Sum) -> str:
        n, pieces = self.notation, []
        for term in node.terms:
            negative, size = _signed(term)
            sign = (n.minus if negative else n.plus) if pieces else n.lead * negative
            pieces.append(sign + self(size, PRODUCT))
        return "".join(pieces)

    def _product(self, node: Product) -> str:
        before, string = node.factors[0], self._factor(node, 0)
        for k, factor in enumerate(node.factors[1:], 1):
            string += self.notation.gap(before, factor) + self._factor(node, k)
            before = factor
        return string

    def _factor(self, node: Product, k: int) -> str:
        factor, after = node.factors[k], node.factors[k + 1 : k + 2]
        if isinstance(factor, Number):
            return self(factor, ATOM if factor.value < 0 else EQUATION)
        if after and is_call(factor):
            before = self.notation.brackets_before_factors and not is_call(after[0])
            if before or _has_factors(_called(factor).argument):
                return self._call(factor, True)
        return self(factor, CALL if isinstance(factor, Cross | Dot | Product) else PRODUCT)

    def _call(self, node: Expression, bracket: bool = False) -> str:
        """Set a function, or a power of one."""
        n, function = self.notation, _called(node)
        argument = function.argument
        if function.name == "norm" and function is node:
            return n.norm.format(self.whole(argument))
        if function.name == "sqrt":
            return self._root(node, argument)
        name = n.function(function.name)
        if isinstance(node, Power):
            name = n.raised.format(name, n.exponent(node.exponent))
        if isinstance(argument, Arguments):
            return n.bracketed.format(name, self(argument))
        nested = any(isinstance(x, Function) for x in nodes(argument))
        bracket = bracket or nested or precedence(argument) < PRODUCT or function.name == "sgn"
        form = n.bracketed if bracket else n.applied
        inner = self.whole(argument)
        return form.format(name, inner if nested else n.tight(inner))

    def _root(self, node: Expression, argument: Expression) -> str:
        """Set the square root of an argument, or a power of that."""
        n = self.notation
        root = n.root.format(self.whole(argument, EQUATION if n.bar else ATOM))
        if not isinstance(node, Power):
            return root
        return n.raised.format(n.brackets.format(root), n.exponent(node.exponent))

    def _power(self, node: Power) -> str:
        n, base = self.notation, node.base
        if isinstance(base, Function):
            return self._call(node)
        if isinstance(base, Transposed) and node.exponent == -1:
            return self._raised(base.operand, n.inverse_transposed)
        if isinstance(base, Symbol) and not base.high:
            return n.symbol(base, n.exponent(node.exponent))
        return self._raised(base, n.exponent(node.exponent))

    def _raised(self, base: Expression, high: str) -> str:
        n = self.notation
        set_base = self if n.group == "{}" else self.whole
        return n.raised.format(n.group.format(set_base(base, ATOM)), high)

    def _derivative(self, node: Derivative) -> str:
        n = self.notation
        d = n.differentials[node.partial]
        below = d + self(node.by, ATOM)
        if isinstance(node.of, Symbol):
            return n.fraction.format(d + self(node.of), below)
        return n.fraction.format(d.strip(), below) + n.operand.format(self.whole(node.of))

    def _pair(self, node: Cross | Dot, sign: str) -> str:
        return sign.join(
            self(x, CALL if isinstance(x, Cross | Dot) else PRODUCT)
            for x in (node.left, node.right)
        )

    def _quotient(self, node: Quotient) -> str:
        form = self.notation.fraction
        if self.notation.bar:
            return form.format(self.whole(node.above), self.whole(node.below))
        above, below = self.fraction_levels
        return form.format(self(node.above, above), self(node.below, below))

    def _array(self, rows: Iterable[Iterable[Expression]], form: tuple[str, str, str]) -> str:
        around, below, beside = form
        return around.format(below.join(beside.join(map(self.whole, row)) for row in rows))

    def _column(self, node: Vector) -> str:
        n, rows = self.notation, [[entry] for entry in node.entries]
        if not n.column and len(rows) in _LONG and all(isinstance(x, _SHORT) for x in node.entries):
            return self._raised(Matrix((node.entries,)), n.transposed)
        return self._array(rows, n.column or n.matrix)

    def _conditioned(self, node: Conditioned) -> str:
        n = self.notation
        return n.comma.join(map(self.whole, node.conditions)) + n.colon + self(node.operand)

    _rules: ClassVar[dict[type, Callable[[Any, Any], str]]] = {
        Number: _number,
        Symbol: lambda self, node: self.notation.symbol(node, ""),
        Sum: _sum,
        Negative: lambda self, node: self.notation.lead + self(node.operand, PRODUCT),
        Product: _product,
        Quotient: _quotient,
        Power: _power,
        Transposed: lambda self, node: self._raised(node.operand, self.notation.transposed),
        Function: _call,
        Derivative: _derivative,
        Cross: lambda self, node: self._pair(node, self.notation.cross),
        Dot: lambda self, node: self._pair(node, self.notation.dot),
        Arguments: lambda self, node: self.notation.comma.join(
            self.whole(x, SUM) for x in node.entries
        ),
        Vector: _column,
        Matrix: lambda self, node: self._array(node.rows, self.notation.matrix),
        Equation: lambda self, node: self.notation.equals.join(self(x, SUM) for x in node.sides),
        Conditioned: _conditioned,
        Sourced: lambda self, node: self.notation.sourced(node.source, self(node.operand)),
        Words: lambda self, node: self.notation.words(node.text),
    }


def _signed(term: Expression) -> tuple[bool, Expression]:
    """Whether a term is negative, and the term without its sign."""
    if isinstance(term, Negative):
        return True, term.operand
    if isinstance(term, Number) and term.value < 0:
        return True, Number(-term.value, term.decimal)
    return False, term


@dataclass
class _LinePart:
    text: str
    depth: int
    """Brackets that are open where the piece begins."""


def broken(string: str, width: float, measure: Callable[[str], float] = len) -> list[str]:
    """The string in lines of at most `width`, as far as its breaks allow; breaks outside brackets
    are preferred."""
    pieces, depth = [], 0
    for text in string.split(BREAK):
        pieces.append(_LinePart(text, depth))
        depth += text.count("(") - text.count(")")
    lines = []
    while pieces:
        size = _fitting(pieces, width, measure)
        lines.append(" ".join(piece.text for piece in pieces[:size]))
        pieces = pieces[size:]
    return lines


def _fitting(pieces: list[_LinePart], width: float, measure: Callable[[str], float]) -> int:
    """The number of pieces that are put on the next line."""
    sizes = []
    total = 0.0
    for piece in pieces:
        total += measure(piece.text) + (1 if sizes else 0)
        sizes.append(total)
    if total <= width or len(pieces) == 1:
        return len(pieces)
    most = max(1, sum(size <= width for size in sizes))
    breaks = [k for k in range(1, most + 1) if k < len(pieces) and sizes[k - 1] > 0.35 * width] or [
        most
    ]
    shallow = min(pieces[k].depth for k in breaks)
    return max(k for k in breaks if pieces[k].depth == shallow)
