"""Formulas of parameters as text, `l1/2` or `m1*l1**2/12`: read here, never run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import NoReturn

from freebody.errors import FreebodyError, shown
from freebody.model.parameters import LARGEST

Powers = tuple[tuple[str, int], ...]
"""Names and their exponents, in the order of the names."""
PolynomialTerms = dict[Powers, Fraction]
"""A polynomial: the factor of each product of powers."""

_NUMBER = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2}(?![0-9]))?"
_WITH_UNIT = re.compile(rf"\s*([+-]?{_NUMBER})\s*([^\W\d]\w*)\s*")
"""200 g, which would else be a product with the parameter g."""
_SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_TOKEN = re.compile(
    rf"\s*(?:(?P<number>{_NUMBER})|(?P<name>[^\W\d{_SUPERSCRIPTS}][^\W{_SUPERSCRIPTS}]*)"
    rf"|(?P<raised>[{_SUPERSCRIPTS}]+)|(?P<sign>\*\*|.)|$)",
    re.DOTALL,
)
_DIGITS = str.maketrans(_SUPERSCRIPTS, "0123456789")
_SIGNS = {"−": "-", "·": "*", "×": "*", "^": "**"}
_FUNCTIONS = {"sqrt": math.sqrt, "sin": math.sin, "cos": math.cos, "tan": math.tan}
_PI = Fraction(repr(math.pi))
_LONGEST, _DEEPEST, _MOST_TERMS, _LARGEST_POWER = 1000, 50, 200, 12


class FormulaTextError(FreebodyError):
    """A text that is no formula of parameters."""


def polynomial(text: str) -> PolynomialTerms:
    """The polynomial that a formula is: sums, products and whole powers of names, divided by
    numbers; and pi, sqrt, sin, cos and tan of numbers. Raises FormulaTextError."""
    if len(text) > _LONGEST:
        raise FormulaTextError(f"it has {len(text)} characters; at most {_LONGEST} are read")
    if unit := _WITH_UNIT.fullmatch(text):
        raise FormulaTextError(
            f"this reads as a number with a unit; numbers are in SI units and without one, and a "
            f"product is written {unit[1]}*{unit[2]}"
        )
    found = _TermsReader(text).whole()
    if any(abs(factor) > LARGEST for factor in found.values()):
        raise FormulaTextError(f"a number in it is above {LARGEST:g}")
    return found


def renamed(text: str, names: Mapping[str, str]) -> str:
    """The text with other names in the place of some."""

    def written(token: re.Match[str]) -> str:
        name = token["name"] if token.lastgroup == "name" else ""
        return token[0].removesuffix(name) + names.get(name, name)

    return _TOKEN.sub(written, text)


class _TermsReader:
    """Recursive descent; each piece is a polynomial at once."""

    def __init__(self, text: str):
        self.tokens = [*_tokens(text), ("end", "the end")]
        self.at = self.depth = 0

    def whole(self) -> PolynomialTerms:
        found = self.total()
        if self.kind != "end":
            self.expected("an operator or the end")
        return found

    @property
    def kind(self) -> str:
        """The kind of the next token; a sign's is the sign."""
        return self.tokens[self.at][0]

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1][1]

    def expected(self, what: str) -> NoReturn:
        raise FormulaTextError(f"{self.tokens[self.at][1]} stands where {what} is expected")

    def total(self) -> PolynomialTerms:
        """Read a sum: term ± term …"""
        found: PolynomialTerms = {}
        while True:
            found = _plus(found, self.signed(self.product))
            if self.kind not in ("+", "-"):
                return found

    def signed(self, read: Callable[[], PolynomialTerms]) -> PolynomialTerms:
        factor = Fraction(1)
        while self.kind in ("+", "-"):
            factor *= -1 if self.take() == "-" else 1
        return _times(read(), {(): factor})

    def product(self) -> PolynomialTerms:
        """Factors with * and / between them or nothing."""
        found = self.power()
        while True:
            if self.kind == "*":
                self.take()
                found = _times(found, self.signed(self.power))
            elif self.kind == "/":
                self.take()
                found = _times(found, _reciprocal(self.signed(self.power)))
            elif self.kind in ("name", "("):
                found = _times(found, self.power())
            else:
                return found

    def power(self) -> PolynomialTerms:
        base = self.primary()
        if self.kind == "raised":
            exponent = int(self.take().translate(_DIGITS))
        elif self.kind == "**":
            self.take()
            if self.kind != "number" or not self.tokens[self.at][1].isdigit():
                self.expected("a whole number as power")
            exponent = int(self.take())
        else:
            return base
        if exponent > _LARGEST_POWER:
            raise FormulaTextError(f"the power {exponent} is above {_LARGEST_POWER}")
        found: PolynomialTerms = {(): Fraction(1)}
        for _ in range(exponent):
            found = _times(found, base)
        return found

    def primary(self) -> PolynomialTerms:
        if self.kind == "number":
            return {(): Fraction(self.take())}
        if self.kind == "(":
            return self.bracket()
        if self.kind != "name":
            self.expected("a number, a name or a bracket")
        name = self.take()
        if self.kind == "(" and name in _FUNCTIONS:
            return {(): _of_number(name, self.bracket())}
        return {(): _PI} if name in ("pi", "π") else {((name, 1),): Fraction(1)}

    def bracket(self) -> PolynomialTerms:
        self.take()
        self.depth += 1
        if self.depth > _DEEPEST:
            raise FormulaTextError(f"more than {_DEEPEST} brackets stand inside one another")
        found = self.total()
        self.depth -= 1
        if self.kind != ")":
            self.expected("')'")
        self.take()
        return found


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup
        if kind == "sign":
            sign = _SIGNS.get(match["sign"], match["sign"])
            if sign not in ("+", "-", "*", "/", "**", "(", ")"):
                raise FormulaTextError(f"{shown(sign)} has no meaning in it")
            yield sign, sign
        elif kind is not None:
            if kind == "number" and len(match[kind]) > 40:
                raise FormulaTextError("a number in it has more than 40 characters")
            if kind == "name" and not match[kind].isidentifier():
                raise FormulaTextError(f"{shown(match[kind])} is no name of a parameter")
            yield kind, match[kind]


def _plus(a: PolynomialTerms, b: PolynomialTerms) -> PolynomialTerms:
    found = dict(a)
    for powers, factor in b.items():
        found[powers] = found.get(powers, Fraction(0)) + factor
    return {powers: factor for powers, factor in found.items() if factor}


def _times(a: PolynomialTerms, b: PolynomialTerms) -> PolynomialTerms:
    found: PolynomialTerms = {}
    for one, x in a.items():
        for other, y in b.items():
            powers = dict(one)
            for name, exponent in other:
                powers[name] = powers.get(name, 0) + exponent
            key = tuple(sorted(powers.items()))
            found[key] = found.get(key, Fraction(0)) + x * y
            if sum(powers.values()) > _LARGEST_POWER or len(found) > _MOST_TERMS:
                raise FormulaTextError(
                    f"it has more than {_MOST_TERMS} terms, or one of a degree above "
                    f"{_LARGEST_POWER}"
                )
    return {powers: factor for powers, factor in found.items() if factor}


def _reciprocal(x: PolynomialTerms) -> PolynomialTerms:
    if not x:
        raise FormulaTextError("it divides by 0")
    if set(x) != {()}:
        raise FormulaTextError(
            "it divides by a parameter; a formula is a polynomial and divides by numbers alone"
        )
    return {(): 1 / x[()]}


def _of_number(name: str, x: PolynomialTerms) -> Fraction:
    if set(x) - {()}:
        raise FormulaTextError(
            f"it takes {name} of a parameter; a formula is a polynomial, with {name} of numbers "
            "alone"
        )
    try:
        return Fraction(repr(_FUNCTIONS[name](x.get((), Fraction(0)))))
    except (ValueError, OverflowError):
        raise FormulaTextError(f"{name} of {float(x[()]):g} is no number") from None
