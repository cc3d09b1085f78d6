"""Characters into tokens: names as the vocabulary knows them, numbers, operators, brackets, LaTeX
left behind."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from freebody.derivations.grammar import words
from freebody.derivations.grammar.source import Source, Span


@dataclass(frozen=True)
class Token:
    """kind: number name function power operator open close fraction partial transpose comma equals
    line amp row begin end stop."""

    kind: str
    text: str
    start: int
    end: int
    value: Fraction = Fraction(0)

    @property
    def span(self) -> Span:
        """Where it stands."""
        return self.start, self.end


class Grammar(Protocol):
    """What the lexer asks of a language."""

    @property
    def functions(self) -> Collection[str]:
        """Words that are functions."""
        ...

    def begins(self, letter: str) -> bool:
        """Whether a word begins with this character."""
        ...

    def word(self, source: Source, at: int) -> tuple[list[words.Piece], int | None]:
        """The names and numbers that the word there is made of, and a power that stood inside;
        raises the error for one that is none."""
        ...


_NUMBER = re.compile(
    r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII
)  # no digits of other scripts
_LONGEST_NUMBER, _LARGEST_EXPONENT = 40, 30
_COMMAND = re.compile(r"\\([A-Za-z]+\*?|.)", re.DOTALL)
_ENVIRONMENT = re.compile(r"\s*\{([A-Za-z]+\*?)\}(\{[clr|\s]*\})?")
_OPERATORS = {"+": "+", "^": "^"}
_OPERATORS |= (
    dict.fromkeys("*·⋅×∗∙•", "*") | dict.fromkeys("-−–—‐", "-") | dict.fromkeys("/÷∕⁄", "/")
)
_OPENING, _CLOSING = {"(": ")", "[": "]", "{": "}"}, frozenset(")]}")
_VULGAR = {
    "½": (1, 2), "⅓": (1, 3), "⅔": (2, 3), "¼": (1, 4), "¾": (3, 4), "⅕": (1, 5), "⅙": (1, 6),
    "⅛": (1, 8), "⅜": (3, 8),
}  # fmt: skip
_TIMES = ("cdot", "times", "ast")
_FRACTIONS = ("frac", "tfrac", "dfrac")
_FUNCTIONS = ("sin", "cos", "tan", "sqrt", "exp", "log", "ln", "arctan", "arccos", "arcsin", "sgn")
_BRACKET_SIZES = tuple(
    f"{size}{side}" for size in ("big", "Big", "bigg", "Bigg") for side in ("", "l", "r", "m")
)
_SILENT = frozenset(
    (*_BRACKET_SIZES, "left", "right", "displaystyle", "textstyle", "quad", "qquad", "nonumber")
)
_SILENT |= frozenset(",;:!()[] \n")
"""Commands that say nothing about the matter."""

MATRICES = frozenset(("matrix", "pmatrix", "bmatrix", "Bmatrix", "vmatrix", "smallmatrix", "array"))
"""LaTeX environments that hold a matrix; other environments are passed over."""


def tokens(source: Source, language: Grammar, piece: Span | None = None) -> list[Token]:
    """All tokens of a text, or of a piece of it, the last of kind "stop"."""
    found: list[Token] = []
    at, end = piece or (0, len(source.text))
    while at < end:
        after_fraction = _wants_digit(found)
        for token in _next(source, at, language, after_fraction):
            at = token.end
            if token.kind != "space":
                found.append(token)
    found.append(Token("stop", "", at, at))
    return found


def _wants_digit(found: list[Token]) -> bool:
    """Whether \\frac stands before, or \\frac and one bare digit: \\frac12 is a half."""
    kinds = [token.kind for token in found[-2:]]
    return kinds[-1:] == ["fraction"] or kinds == ["fraction", "number"]


def _next(source: Source, at: int, language: Grammar, single: bool) -> Iterator[Token]:
    """The tokens that begin there; `single`: of a number only its first digit."""
    c = source.text[at]
    if c == "\n" or c == ";":
        yield Token("line", c, at, at + 1)
    elif c.isspace() or c in "$~\u200b\u2061\u2062":
        yield Token("space", c, at, at + 1)
    elif c == "#":
        end = source.text.find("\n", at)
        yield Token("space", c, at, end if end >= 0 else len(source.text))
    elif c == "\\":
        yield from _command(source, at, language)
    elif language.begins(c):
        yield from _word(source, at, language)
    elif (c.isascii() and c.isdigit()) or c == ".":
        yield _number(source, at, single)
    elif c in _VULGAR:
        yield Token("number", c, at, at + 1, Fraction(*_VULGAR[c]))
    else:
        yield _mark(source, at)


def _mark(source: Source, at: int) -> Token:
    """Operators, brackets, superscripts."""
    text, c = source.text, source.text[at]
    if c in _OPERATORS:
        double = text[at : at + 2] == "**"
        return Token("operator", "^" if double else _OPERATORS[c], at, at + 1 + double)
    if c in _OPENING:
        return Token("open", c, at, at + 1)
    if c in _CLOSING:
        return Token("close", c, at, at + 1)
    if c in "∂ᵀ":
        return Token("partial" if c == "∂" else "transpose", c, at, at + 1)
    if c in "=,&°":
        size = 2 if text[at : at + 2] == "==" else 1
        return Token({"=": "equals", ",": "comma", "&": "amp", "°": "degree"}[c], c, at, at + size)
    power, end = words.superscript(text, at)
    if power is not None:
        return Token("power", text[at:end], at, end, Fraction(power))
    if c in words.MARKS:
        source.fail("a dot without a letter under it", (at, at + 1))
    source.fail(f"{c!r} has no meaning here", (at, at + 1))


def _number(source: Source, at: int, single: bool) -> Token:
    match = _NUMBER.match(source.text, at)
    if match is None:
        if not source.text[at + 1 : at + 2].strip():
            return Token("space", ".", at, at + 1)  # a full stop
        source.fail("a decimal point without digits", (at, at + 1))
    text = match[0][0] if single and match[0].isdigit() else match[0]
    span = (at, at + len(text))
    mantissa, _, exponent = text.lower().partition("e")
    if len(mantissa) > _LONGEST_NUMBER or abs(int(exponent[:9] or 0)) > _LARGEST_EXPONENT:
        source.fail("this number is too long or too large", span)
    return Token("number", text, *span, Fraction(text))


def _word(source: Source, at: int, language: Grammar) -> Iterator[Token]:
    """The names that a word is made of, with the power that stood before its subscript."""
    pieces, power = language.word(source, at)
    for name, start, end in pieces:
        if name.isdigit():
            yield Token("number", name, start, end, Fraction(name))
        else:
            yield Token("function" if name in language.functions else "name", name, start, end)
    if power is not None:
        end = pieces[-1][2]
        yield Token("power", str(power), end, end, Fraction(power))


def _command(source: Source, at: int, language: Grammar) -> Iterator[Token]:
    """A LaTeX command."""
    match = _COMMAND.match(source.text, at)
    if match is None:
        source.fail("a backslash alone", (at, at + 1))
    name, end = match[1], match.end()
    if name in words.COMMANDS:
        yield from _word(source, at, language)
    elif name in _SILENT:
        yield Token("space", name, at, end)
    elif name in _TIMES:
        yield Token("operator", "*", at, end)
    elif name in _FRACTIONS:
        yield Token("fraction", name, at, end)
    elif name in _FUNCTIONS and name in language.functions:
        yield Token("function", name, at, end)
    elif name == "\\":
        skip = re.compile(r"\s*\[[^\]\n]{0,12}\]").match(source.text, end)
        yield Token("row", name, at, skip.end() if skip else end)
    elif name in ("{", "}"):
        yield Token("open" if name == "{" else "close", name, at, end)
    elif name in ("begin", "end") and (environment := _ENVIRONMENT.match(source.text, end)):
        kind = name if environment[1] in MATRICES else "space"
        yield Token(kind, environment[1], at, environment.end())
    elif name == "prime":
        source.fail("a prime is written ' here, such as \\theta_1'", (at, end))
    else:
        written = source.text[at : min(end, at + 40)] + "…" * (end > at + 40)
        source.fail(f"the command {written} is not known here", (at, end))
