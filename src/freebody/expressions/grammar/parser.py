"""Tokens into a tree, by recursive descent; nothing is run. A language is a subclass: what its
names and functions are, and whether products may go without a sign, 2 l1 lc2 cos θ2."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NoReturn

from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.source import Source, Span
from freebody.expressions.nodes import (
    Expression,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Transposed,
)

DEEPEST = 100
"""The most brackets inside one another."""

_PAIR = {"(": ")", "[": "]", "{": "}"}
PI = Fraction(repr(math.pi))
_STARTS = ("name", "function", "open", "fraction", "partial", "begin")
"""Tokens that begin a factor, numbers apart."""


class Parser(ABC):
    """A parser of one side of an equation, from tokens to a tree."""

    implied_products = True
    """Whether factors may stand side by side without a sign."""
    largest_exponent = 12

    def __init__(self, source: Source, tokens: Sequence[Token]):
        self.source, self.tokens = source, tokens
        self.at = 0
        self.depth = 0
        end = tokens[-1].end if tokens else 0
        self.stop = Token("stop", "", end, end)

    # ------------------------------------------------------------ tokens
    @property
    def token(self) -> Token:
        """The token that is read next."""
        return self.tokens[self.at] if self.at < len(self.tokens) else self.stop

    def ahead(self, k: int) -> Token:
        """The k-th token after the next."""
        return self.tokens[self.at + k] if self.at + k < len(self.tokens) else self.stop

    def take(self) -> Token:
        """The next token, which is used up."""
        token = self.token
        self.at += 1
        return token

    def since(self, start: int) -> Span:
        """The span from a place to the end of the last token that was used up."""
        return start, self.tokens[self.at - 1].end

    def is_operator(self, *texts: str) -> bool:
        """Whether one of these operators comes next."""
        return self.token.kind == "operator" and self.token.text in texts

    def fail_here(self, expected: str) -> NoReturn:
        """Raise the error that something else than the next token was expected."""
        token = self.token
        found = "the line ends" if token.kind == "stop" else f"there is {self.source[token.span]!r}"
        self.source.fail(f"{found} where {expected} is expected", token.span)

    # ------------------------------------------------------------ sides
    def side(self) -> Expression:
        """A whole side: an expression, or a vector or matrix of expressions."""
        node = self.expression()
        if self.token.kind == "close":
            self.source.fail(f"this {self.token.text!r} closes no bracket", self.token.span)
        if self.token.kind != "stop":
            self.fail_here("an operator or the end of the line")
        return node

    def opens_table(self) -> bool:
        """Whether a vector or matrix comes next."""
        return self.token.kind == "begin" or self.token.text == "["

    def table(self) -> Matrix:
        """Parse the vector or matrix that comes next: [[a, b], [c, d]], [a, b], Matrix(…), or one
        of LaTeX."""
        first = self.take()
        if first.kind == "begin":
            rows = self._rows(("amp",), ("row",), "end")
        elif first.kind == "function":
            self.expect("open", "'('")
            inner = self.table()
            self.expect("close", "')'")
            rows = inner.rows
        elif self.token.kind == "open" and self.token.text == "[":
            rows = self._nested()
        else:
            rows = self._rows(("comma",), ("line", "row"), "close")
        return Matrix(tuple(map(tuple, rows)), span=self.since(first.start))

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
            self.expect("open", "'['")
            rows += self._rows(("comma",), (), "close")
            token = self.take()
            if token.kind == "close":
                return rows
            if token.kind != "comma":
                self.at -= 1
                self.fail_here("the next row of the matrix")

    def expect(self, kind: str, what: str) -> Token:
        if self.token.kind != kind:
            self.fail_here(what)
        return self.take()

    # ------------------------------------------------------------ expressions
    def expression(self) -> Expression:
        """Parse a sum of terms."""
        terms = [self._signed(self.product)]
        while self.is_operator("+", "-"):
            terms.append(self._signed(self.product))
        if len(terms) == 1:
            return terms[0]
        return Sum(tuple(terms), span=around(terms[0], terms[-1]))

    def _signed(self, read: Callable[[], Expression]) -> Expression:
        """An operand that `read` reads, with the signs before it."""
        start, negative = self.token.start, False
        while self.is_operator("+", "-"):
            negative ^= self.take().text == "-"
        node = read()
        return Negative(node, span=(start, node.span[1])) if negative else node

    def product(self) -> Expression:
        """Factors with * and / between them or nothing."""
        node = self.factor()
        factors = [node]
        while True:
            token = self.token
            if self.is_operator("*"):
                sign = self.take()
                factors = self.multiplied(factors, sign, self.following(factors, sign))
            elif self.is_operator("/"):
                self.take()
                above, below = product_of(factors), self._signed(self.factor)
                factors = [self.quotient(above, below)]
            elif not self.implied_products:
                return product_of(factors)
            elif token.kind in _STARTS or (
                token.kind == "number" and "." in token.text and not self._is_behind_number()
            ):
                factors.append(self.factor())
            elif token.kind == "number":
                self._number_behind(token)
            else:
                return product_of(factors)

    def _is_behind_number(self) -> bool:
        """Whether the next token directly follows a number, as .5 does in 2.0.5."""
        return self.tokens[self.at - 1].kind == "number"

    def _number_behind(self, token: Token) -> None:
        before = self.source[self.tokens[self.at - 1].span]
        self.source.fail(
            f"the number {token.text} follows {before!r}: write {before}^{token.text} for a power, "
            f"{before}*{token.text} for a product",
            token.span,
        )

    def factor(self) -> Expression:
        """Parse a primary with its powers."""
        node = self.primary()
        while True:
            if self.token.kind == "power" or self.is_operator("^"):
                exponent = self.exponent()
                span = self.since(node.span[0])
                node = (
                    replace(node, span=span) if exponent == 1 else Power(node, exponent, span=span)
                )
            elif self.token.kind == "transpose":
                node = self.transposed(node)
            elif self.token.kind == "degree":
                node = self.degrees(node)
            else:
                return node

    def transposed(self, node: Expression) -> Expression:
        """A node whose mark of a transpose comes next, transposed."""
        return Transposed(node, span=(node.span[0], self.take().end))

    def degrees(self, node: Expression) -> Expression:
        """The operand converted from degrees to radians where a degree sign follows."""
        if self.token.kind != "degree":
            return node
        span = (node.span[0], self.take().end)
        return Product((node, Number(PI / 180, span=span)), span=span)

    def exponent(self) -> int:
        """The number behind ^, or written as superscript."""
        first = self.take()
        token, value = first, first.value
        if first.kind != "power":
            bracket = self.take() if self.token.kind == "open" else None
            sign = -1 if self.is_operator("-") and self.take() else 1
            token = self.token
            if token.kind == "name":
                self.source.fail("a power must be a whole number", token.span)
            value = self.expect("number", "a whole number as power").value * sign
            if bracket is not None:
                self.expect("close", f"{_PAIR[bracket.text]!r}")
        if value.denominator != 1 or abs(value) > self.largest_exponent:
            self.source.fail(
                f"a power must be a whole number up to {self.largest_exponent}", token.span
            )
        if self.is_operator("^") or self.token.kind == "power":
            self.source.fail("a power of a power needs brackets", self.token.span)
        return int(value)

    def primary(self) -> Expression:
        """A number, name, function, fraction or bracket."""
        token = self.token
        if token.kind == "number":
            self.take()
            decimal = bool(set(token.text) & {".", "e", "E"})
            return Number(token.value, decimal, span=token.span)
        if token.kind == "name":
            return self.name()
        if self.opens_table():
            return self.table()
        if token.kind == "open":
            return self.bracket()
        if token.kind in ("function", "fraction"):
            return self._nested_call()
        self.fail_here("a term")

    def bracket(self) -> Expression:
        """Parse ( … ); the node is as wide as its brackets."""
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
        """Parse a function or fraction, whose parts may hold further ones."""
        token = self.token
        self._deeper(token)
        node = self._fraction() if token.kind == "fraction" else self.call()
        self.depth -= 1
        return node

    def _fraction(self) -> Expression:
        """The fraction of \\frac{above}{below} or \\frac12."""
        start = self.take().start
        above, below = (
            self.bracket() if self.token.kind == "open" else self.primary() for _ in range(2)
        )
        return replace(self.quotient(above, below), span=(start, below.span[1]))

    # ------------------------------------------------------------ what a language says
    @abstractmethod
    def name(self) -> Expression:
        """The node that the name that comes next stands for."""

    @abstractmethod
    def call(self) -> Expression:
        """The function that comes next, with its argument."""

    def following(self, factors: list[Expression], sign: Token) -> Expression:
        """The factor behind the sign of a product."""
        return self._signed(self.factor)

    def multiplied(
        self, factors: list[Expression], sign: Token, factor: Expression
    ) -> list[Expression]:
        """The factors of a product with one more behind its sign."""
        return [*factors, factor]

    def quotient(self, above: Expression, below: Expression) -> Expression:
        """The fraction of two nodes."""
        return Quotient(above, below, span=around(above, below))


def around(first: Expression, last: Expression) -> Span:
    """The span from the start of one piece to the end of another."""
    return first.span[0], last.span[1]


def product_of(factors: list[Expression]) -> Expression:
    if len(factors) == 1:
        return factors[0]
    return Product(tuple(factors), span=around(factors[0], factors[-1]))
