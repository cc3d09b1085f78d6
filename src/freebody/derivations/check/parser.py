"""Tokens into a tree, by recursive descent with implied products, 2 l1 lc2 cos θ2; nothing is
run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from freebody.derivations.check.exact import LARGEST_EXPONENT, Reader
from freebody.derivations.check.lexer import Token
from freebody.derivations.check.source import Source, Span
from freebody.derivations.check.tree import Named, Wave
from freebody.derivations.check.vocabulary import Vocabulary
from freebody.derivations.nodes import (
    Expression,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
)
from freebody.errors import FreebodyError
from freebody.scalars.trig import Trig

DEEPEST = 100
"""Brackets inside brackets."""

_PAIR = {"(": ")", "[": "]", "{": "}"}
_PI = Fraction(repr(math.pi))
_STARTS = ("name", "function", "open", "fraction")
"""Tokens that begin a factor, numbers apart."""


class Parser:
    """Reads one side of an equation. `quantity(name)` gives the right value of τ1, H12, … where one
    stands for it."""

    def __init__(self, source: Source, tokens: Sequence[Token], vocabulary: Vocabulary, quantity):
        self.source, self.tokens, self.vocabulary, self.quantity = (
            source,
            tokens,
            vocabulary,
            quantity,
        )
        self.reader = Reader(source, vocabulary.setting.ring)
        self.at = 0
        self.depth = 0
        end = tokens[-1].end if tokens else 0
        self.stop = Token("stop", "", end, end)

    # ------------------------------------------------------------ tokens
    @property
    def token(self) -> Token:
        """The next token."""
        return self.tokens[self.at] if self.at < len(self.tokens) else self.stop

    def ahead(self, k: int) -> Token:
        """The k-th token after the next."""
        return self.tokens[self.at + k] if self.at + k < len(self.tokens) else self.stop

    def take(self) -> Token:
        """The next token, which is used up."""
        token = self.token
        self.at += 1
        return token

    def _since(self, start: int) -> Span:
        """From there to the end of the last token that was used up."""
        return start, self.tokens[self.at - 1].end

    def is_operator(self, *texts: str) -> bool:
        """Whether one of these operators comes next."""
        return self.token.kind == "operator" and self.token.text in texts

    def fail_here(self, expected: str):
        """Raise the error that something else was expected."""
        token = self.token
        found = "the line ends" if token.kind == "stop" else f"there is {self.source[token.span]!r}"
        self.source.fail(f"{found} where {expected} is expected", token.span)

    # ------------------------------------------------------------ sides
    def side(self) -> Expression:
        """A whole side: an expression, or a vector or matrix of expressions."""
        node = self.table() if self._is_table() else self.expression()
        if self.token.kind == "close":
            self.source.fail(f"this {self.token.text!r} closes no bracket", self.token.span)
        if self.token.kind != "stop":
            self.fail_here("an operator or the end of the line")
        return node

    def _is_table(self) -> bool:
        token = self.token
        if token.kind == "begin" or (
            token.kind == "function" and self._function(token) == "Matrix"
        ):
            return True
        if token.kind != "open" or token.text != "[":
            return False
        depth = 0
        for k in range(len(self.tokens) - self.at):
            following = self.ahead(k)
            depth += {"open": 1, "close": -1}.get(following.kind, 0)
            if depth == 0:
                return self.ahead(k + 1).kind == "stop" and self.ahead(1).kind == "open"
            if depth == 1 and following.kind in ("comma", "line"):
                return True
        return False

    def table(self) -> Matrix:
        """[[a, b], [c, d]], [a, b], Matrix(…), or a LaTeX matrix."""
        first = self.take()
        if first.kind == "begin":
            rows = self._rows(("amp",), ("row",), "end")
        elif first.kind == "function":
            self._expect("open", "'('")
            inner = self.table()
            self._expect("close", "')'")
            rows = inner.rows
        elif self.token.kind == "open" and self.token.text == "[":
            rows = self._nested()
        else:
            rows = self._rows(("comma",), ("line", "row"), "close")
        return Matrix(tuple(map(tuple, rows)), span=self._since(first.start))

    def _rows(
        self, column: tuple[str, ...], row: tuple[str, ...], end: str
    ) -> list[list[Expression]]:
        rows: list[list[Expression]] = [[]]
        while True:
            rows[-1].append(self.expression())
            token = self.take()
            if token.kind in row and self.token.kind == end:
                token = self.take()
            if token.kind in row:
                rows.append([])
            elif token.kind == end:
                return rows
            elif token.kind not in column:
                self.at -= 1
                self.fail_here("the next entry of the matrix")

    def _nested(self) -> list[list[Expression]]:
        rows = []
        while True:
            self._expect("open", "'['")
            rows += self._rows(("comma",), (), "close")
            token = self.take()
            if token.kind == "close":
                return rows
            if token.kind != "comma":
                self.at -= 1
                self.fail_here("the next row of the matrix")

    def _expect(self, kind: str, what: str) -> Token:
        if self.token.kind != kind:
            self.fail_here(what)
        return self.take()

    # ------------------------------------------------------------ expressions
    def expression(self) -> Expression:
        """term ± term …"""
        terms = [self._signed_term()]
        while self.is_operator("+", "-"):
            terms.append(self._signed_term())
        if len(terms) == 1:
            return terms[0]
        return Sum(tuple(terms), span=around(terms[0], terms[-1]))

    def _signed_term(self) -> Expression:
        """A term with the signs before it."""
        start, negative = self.token.start, False
        while self.is_operator("+", "-"):
            negative ^= self.take().text == "-"
        term = self.product()
        return Negative(term, span=(start, term.span[1])) if negative else term

    def product(self) -> Expression:
        """Factors with * and / between them or nothing."""
        node = self.factor()
        factors = [node]
        while True:
            token = self.token
            if self.is_operator("*"):
                self.take()
                factors.append(self._signed_factor())
            elif self.is_operator("/"):
                self.take()
                above, below = _product(factors), self._signed_factor()
                factors = [_quotient(above, below)]
            elif token.kind in _STARTS or (token.kind == "number" and "." in token.text):
                factors.append(self.factor())
            elif token.kind == "number":
                self._number_behind(token)
            else:
                return _product(factors)

    def _number_behind(self, token: Token) -> None:
        before = self.source[self.tokens[self.at - 1].span]
        self.source.fail(
            f"the number {token.text} stands behind {before!r}: write {before}^{token.text} for a "
            f"power, "
            f"{before}*{token.text} for a product",
            token.span,
        )

    def _signed_factor(self) -> Expression:
        start, negative = self.token.start, False
        while self.is_operator("+", "-"):
            negative ^= self.take().text == "-"
        factor = self.factor()
        return Negative(factor, span=(start, factor.span[1])) if negative else factor

    def factor(self) -> Expression:
        """A primary with its powers."""
        node = self.primary()
        while True:
            if self.token.kind == "power" or self.is_operator("^"):
                exponent = self._exponent()
                span = self._since(node.span[0])
                node = (
                    replace(node, span=span) if exponent == 1 else Power(node, exponent, span=span)
                )
            elif self.token.kind == "degree":
                span = (node.span[0], self.take().end)
                node = Product((node, Number(_PI / 180, span=span)), span=span)
            else:
                return node

    def _exponent(self) -> int:
        """The number behind ^, or written as superscript."""
        first = self.take()
        token, value = first, first.value
        if first.kind != "power":
            bracket = self.take() if self.token.kind == "open" else None
            sign = -1 if self.is_operator("-") and self.take() else 1
            token = self.token
            if token.kind == "name":
                self.source.fail("a power must be a whole number", token.span)
            value = self._expect("number", "a whole number as power").value * sign
            if bracket is not None:
                self._expect("close", f"{_PAIR[bracket.text]!r}")
        if value < 0:
            self.source.fail("negative powers do not occur in these equations", token.span)
        if value.denominator != 1 or value > LARGEST_EXPONENT:
            self.source.fail(f"a power must be a whole number up to {LARGEST_EXPONENT}", token.span)
        if self.is_operator("^") or self.token.kind == "power":
            self.source.fail("a power of a power needs brackets", self.token.span)
        return int(value)

    def primary(self) -> Expression:
        """A number, name, function, fraction or bracket."""
        token = self.token
        if token.kind == "number":
            self.take()
            return Number(token.value, span=token.span)
        if token.kind == "name":
            return self._name()
        if token.kind == "open":
            return self.bracket()
        if token.kind in ("function", "fraction"):
            return self._nested_call()
        if token.kind == "begin":
            self.source.fail("a matrix must be a whole side of the equation", token.span)
        self.fail_here("a term")
        raise AssertionError

    def bracket(self) -> Expression:
        """( … ), the node as wide as its brackets."""
        token = self.take()
        self._deeper(token)
        node = self.expression()
        self.depth -= 1
        close = self.token
        if close.kind != "close":
            if close.kind == "stop":
                self.source.fail(f"this {token.text!r} is not closed", token.span)
            self.fail_here(f"{_PAIR[token.text]!r}")
        if close.text != _PAIR[token.text]:
            self.source.fail(f"{token.text!r} is closed by {close.text!r}", close.span)
        self.take()
        return replace(node, span=(token.start, close.end))

    def _deeper(self, token: Token) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            self.source.fail(f"more than {DEEPEST} brackets inside one another", token.span)

    def _nested_call(self) -> Expression:
        """A function or fraction; both may hold others."""
        token = self.token
        self._deeper(token)
        node = self._fraction() if token.kind == "fraction" else self._call()
        self.depth -= 1
        return node

    def _fraction(self) -> Expression:
        """\\frac{above}{below}, \\frac12."""
        start = self.take().start
        above, below = (
            self.bracket() if self.token.kind == "open" else self.primary() for _ in range(2)
        )
        return replace(_quotient(above, below), span=(start, below.span[1]))

    # ------------------------------------------------------------ names and functions
    def _name(self) -> Expression:
        """A symbol, c12, or a quantity that stands for its right value; theta1(t) is theta1."""
        token = self.take()
        name = token.text
        if [self.ahead(k).text for k in range(3)] == ["(", "t", ")"]:
            self.at += 3
        span = self._since(token.start)
        vocabulary = self.vocabulary
        if name in vocabulary.symbols:
            return Named(name, vocabulary.symbols[name], span=span)
        if name in vocabulary.waves:
            return Wave(*vocabulary.waves[name], span=span)
        if name == "pi":
            return Number(_PI, span=span)
        if name == "t":
            self.source.fail("the time t does not occur in these equations", token.span)
        value = self.quantity(name)
        if not isinstance(value, Trig):
            self.source.fail(
                f"{self.source[token.span]} is a vector or matrix, which cannot stand in a product",
                token.span,
            )
        return Named(name, value, span=span)

    def _function(self, token: Token) -> str:
        return self.vocabulary.functions[token.text]

    def _call(self) -> Expression:
        """A function with its argument; cos²(x) is a power of it."""
        token = self.take()
        function = self._function(token)
        if function == "Derivative":
            return self._derivative(token)
        if function == "Matrix":
            self.source.fail("a matrix must be a whole side of the equation", token.span)
        exponent = self._exponent() if self.token.kind == "power" or self.is_operator("^") else 1
        argument = self._argument(token)
        span = self._since(token.start)
        if function == "sgn":
            node: Expression = Named(self.source[span], self._sign(argument), span=span)
        else:
            node = Wave(function, *self.reader.angle(argument), span=span)
        return node if exponent == 1 else Power(node, exponent, span=span)

    def _argument(self, function: Token) -> Expression:
        """A bracket; or, without one, numbers and one angle: cos 2θ1."""
        if self.token.kind == "open":
            return self.bracket()
        factors: list[Expression] = []
        while self.token.kind in ("number", "fraction") or self.is_operator("-", "*"):
            if self.is_operator("-", "*"):
                token = self.take()
                if token.text == "*" and not factors:
                    self.source.fail(f"{function.text} needs an angle behind it", token.span)
                if token.text == "-":
                    factors.append(Number(Fraction(-1), span=token.span))
            else:
                factors.append(self.primary())
        if self.token.kind == "name":
            factors.append(self._name())
        if not factors:
            self.fail_here(f"the angle of {function.text}")
        if self.token.kind == "power" or self.is_operator("^"):
            angle = self.source[around(factors[0], factors[-1])]
            self.source.fail(
                f"this power may belong to the angle or to {function.text}: write "
                f"{function.text}^2({angle})",
                self.token.span,
            )
        return _product(factors)

    def _sign(self, argument: Expression) -> Trig:
        try:
            return self.reader.read(argument).sign()
        except FreebodyError:
            self.source.fail("sgn needs a single rate here", argument.span)

    def _derivative(self, token: Token) -> Expression:
        """Derivative(theta1(t), t), Derivative(theta1(t), (t, 2))."""
        self._expect("open", "'('")
        value = self.reader.read(self.expression())
        order = 0
        while self.token.kind == "comma":
            self.take()
            pair = self.token.kind == "open"
            if pair:
                self.take()
            if self._expect("name", "the time t").text != "t":
                self.source.fail("only derivatives with respect to the time t are read", token.span)
            times = 1
            if pair:
                self._expect("comma", "','")
                times = int(self._expect("number", "the order").value)
                self._expect("close", "')'")
            order += times
        span = (token.start, self._expect("close", "')'").end)
        if not 1 <= order <= 2:
            self.source.fail("a derivative must be the first or second one by t", span)
        for _ in range(order):
            value = value.along(self.vocabulary.setting.symbols.rates)
        return Named(self.source[span], value, span=span)


def around(first: Expression, last: Expression) -> Span:
    """From the start of one piece to the end of another."""
    return first.span[0], last.span[1]


def _product(factors: list[Expression]) -> Expression:
    if len(factors) == 1:
        return factors[0]
    return Product(tuple(factors), span=around(factors[0], factors[-1]))


def _quotient(above: Expression, below: Expression) -> Expression:
    """A fraction; of two numbers one number."""
    if isinstance(above, Number) and isinstance(below, Number) and below.value:
        return Number(above.value / below.value, span=around(above, below))
    return Quotient(above, below, span=around(above, below))
