"""The walk that sets an expression in any notation: what needs brackets where, how sums take signs,
products gaps and functions their arguments. A notation is a subclass that says how it writes the
pieces."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, ClassVar

from freebody.derivations.expressions.expression import (
    Arguments,
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
    Sum,
    Symbol,
    Transposed,
    Vector,
    Words,
)
from freebody.outputs.numbers import mantissa_and_exponent

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
        if node.value < 0:
            return SUM
        return ATOM if node.value.denominator == 1 or node.decimal else PRODUCT
    return _PRECEDENCE.get(type(node), ATOM)


def is_call(node: Expression) -> bool:
    """Whether it is a function or its power, whose argument may stand without brackets."""
    return isinstance(node, Function) or (
        isinstance(node, Power) and isinstance(node.base, Function)
    )


class Typesetter:
    """Expressions as strings; `setter(node, level)` puts brackets where needed. The attributes and
    the methods below the walk are what a notation says of itself."""

    plus, minus, lead = f"{BREAK}+ ", f"{BREAK}− ", "−"
    brackets = "(", ")"
    cross, dot, equals, comma = " × ", " · ", " = ", ", "
    differentials = "d", "∂"
    transposed, inverse_transposed = "ᵀ", "⁻ᵀ"
    space = " "
    """What is left of a `BREAK` where no line may be broken."""
    fraction_levels = EQUATION, EQUATION
    """How tightly numerator and denominator must bind to stand without brackets."""
    brackets_before_factors = False
    """Whether a function before a factor needs brackets, lest that is read as its argument."""

    def __call__(self, node: Expression, level: int = EQUATION) -> str:
        string = self._rules[type(node)](self, node)
        if precedence(node) < level:
            return self.brackets[0] + string + self.brackets[1]
        return string

    def whole(self, node: Expression, level: int = EQUATION) -> str:
        """A node that is not to be broken."""
        return self(node, level).replace(BREAK, self.space)

    # ------------------------------------------------------------ the walk
    def _number(self, node: Number) -> str:
        value = node.value
        if value.denominator == 1 and not (node.decimal and abs(value) >= 10**6):
            return self.digits(str(value))
        if not node.decimal:
            return self.ratio(value)
        mantissa, exponent = mantissa_and_exponent(float(value), DIGITS)
        if not exponent:
            return self.digits(mantissa)
        power = self.raised(self.digits("10"), self.high(exponent))
        return self.digits(mantissa) + self.tenfold + power

    def _sum(self, node: Sum) -> str:
        pieces = []
        for term in node.terms:
            negative, size = _signed(term)
            sign = (self.minus if negative else self.plus) if pieces else self.lead * negative
            pieces.append(sign + self(size, PRODUCT))
        return "".join(pieces)

    def _product(self, node: Product) -> str:
        before, string = node.factors[0], self._factor(node, 0)
        for k, factor in enumerate(node.factors[1:], 1):
            string += self.gap(before, factor) + self._factor(node, k)
            before = factor
        return string

    def _factor(self, node: Product, k: int) -> str:
        factor, after = node.factors[k], node.factors[k + 1 : k + 2]
        if isinstance(factor, Number):
            return self(factor, ATOM if factor.value < 0 else EQUATION)
        if self.brackets_before_factors and is_call(factor) and after and not is_call(after[0]):
            return self._call(factor, True)
        return self(factor, CALL if isinstance(factor, Cross | Dot | Product) else PRODUCT)

    def _call(self, node: Expression, bracket: bool = False) -> str:
        """A function, or its power."""
        function = node.base if isinstance(node, Power) else node
        assert isinstance(function, Function)
        argument = function.argument
        if function.name == "norm" and function is node:
            return self.norm(self.whole(argument))
        name = self.function(function.name)
        if isinstance(node, Power):
            name = self.raised(name, self.high(node.exponent))
        if isinstance(argument, Arguments):
            return self.applied(name, self(argument), True)
        bracket = bracket or precedence(argument) < PRODUCT or function.name == "sgn"
        return self.applied(name, self.tight(self.whole(argument)), bracket)

    def _power(self, node: Power) -> str:
        if isinstance(node.base, Function):
            return self._call(node)
        if isinstance(node.base, Transposed) and node.exponent == -1:
            return self.raised(self.group(self(node.base.operand, ATOM)), self.inverse_transposed)
        if isinstance(node.base, Symbol) and not node.base.high:
            return self.symbol(node.base, self.high(node.exponent))
        return self.raised(self.group(self.base(node.base)), self.high(node.exponent))

    def _derivative(self, node: Derivative) -> str:
        d = self.differentials[node.partial]
        below = d + self(node.by, ATOM)
        if isinstance(node.of, Symbol):
            return self.fraction(d + self(node.of), below)
        return self.fraction(d.strip(), below) + self.operand(self.whole(node.of))

    def _pair(self, node: Cross | Dot) -> str:
        left, right = (
            self(x, CALL if isinstance(x, Cross | Dot) else PRODUCT)
            for x in (node.left, node.right)
        )
        return left + (self.cross if isinstance(node, Cross) else self.dot) + right

    def _quotient(self, node: Quotient) -> str:
        above, below = self.fraction_levels
        return self.fraction(self(node.above, above), self(node.below, below))

    _rules: ClassVar[dict[type, Callable[[Any, Any], str]]] = {
        Number: _number,
        Symbol: lambda self, node: self.symbol(node),
        Sum: _sum,
        Negative: lambda self, node: self.lead + self(node.operand, PRODUCT),
        Product: _product,
        Quotient: _quotient,
        Power: _power,
        Transposed: lambda self, node: self.raised(
            self.group(self(node.operand, ATOM)), self.transposed
        ),
        Function: _call,
        Derivative: _derivative,
        Cross: _pair,
        Dot: _pair,
        Arguments: lambda self, node: self.comma.join(self.whole(x, SUM) for x in node.entries),
        Vector: lambda self, node: self.column([self.whole(x) for x in node.entries]),
        Matrix: lambda self, node: self.array([[self.whole(x) for x in row] for row in node.rows]),
        Equation: lambda self, node: self.equals.join(self(side, SUM) for side in node.sides),
        Words: lambda self, node: self.words(node.text),
    }

    # ------------------------------------------------------------ the pieces
    tenfold = "·"
    """Between a decimal's digits and its power of ten."""

    def digits(self, digits: str) -> str:
        """A number's digits and sign."""
        raise NotImplementedError

    def ratio(self, value: Fraction) -> str:
        """A fraction of two numbers."""
        raise NotImplementedError

    def symbol(self, node: Symbol, high: str = "") -> str:
        """A symbol, with an exponent as `high` gives it."""
        raise NotImplementedError

    def high(self, exponent: int) -> str:
        """An exponent."""
        raise NotImplementedError

    def raised(self, base: str, high: str) -> str:
        """Something with an exponent."""
        return base + high

    def base(self, node: Expression) -> str:
        """What a power is of, in brackets where needed."""
        return self(node, ATOM)

    def group(self, string: str) -> str:
        """Several pieces as one."""
        return string

    def gap(self, before: Expression, after: Expression) -> str:
        """What stands between two factors."""
        return " "

    def function(self, name: str) -> str:
        """A function's name."""
        return name

    def tight(self, argument: str) -> str:
        """An argument without the spaces around its signs."""
        return argument

    def applied(self, name: str, argument: str, bracket: bool) -> str:
        """A function with its argument."""
        return f"{name}({argument})" if bracket else f"{name} {argument}"

    def norm(self, argument: str) -> str:
        """The length of a vector."""
        return f"|{argument}|"

    def fraction(self, above: str, below: str) -> str:
        """A fraction of expressions."""
        return f"{above}/{below}"

    def operand(self, string: str) -> str:
        """What a derivative that stands before it is taken of."""
        return f" ({string})"

    def column(self, entries: list[str]) -> str:
        """A column of entries."""
        return self.array([[entry] for entry in entries])

    def array(self, rows: list[list[str]]) -> str:
        """A matrix."""
        raise NotImplementedError

    def words(self, text: str) -> str:
        """Upright words."""
        return text


def _signed(term: Expression) -> tuple[bool, Expression]:
    """Whether a term is negative, and what stands behind its sign."""
    if isinstance(term, Negative):
        return True, term.operand
    if isinstance(term, Number) and term.value < 0:
        return True, Number(-term.value, term.decimal)
    return False, term
