"""Lexemes into tokens: names as the vocabulary knows them, numbers, operators, brackets."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, Protocol

from freebody.expressions.grammar import words
from freebody.expressions.grammar.lexemes import Lexeme, Lexemes, plain
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.source import Source, Span
from freebody.expressions.grammar.tables import characters as table


class WrittenFigures(NamedTuple):
    """A number as it is written: 2.50e-3 has the mantissa 2.50 with two decimals, and the exponent
    -3."""

    mantissa: str
    decimals: int
    exponent: int

    @property
    def last(self) -> Fraction:
        """The value of one unit of the last digit."""
        return Fraction(10) ** (self.exponent - self.decimals)

    @property
    def digits(self) -> int:
        """The number of significant digits, zeros in front not counted."""
        return len(self.mantissa.replace(".", "").lstrip("0"))


@dataclass(frozen=True)
class Token:
    """kind: number name function power operator open close fraction partial transpose comma equals
    line amp row begin end degree stop."""

    kind: str
    text: str
    start: int
    end: int
    value: Fraction = Fraction(0)
    written: str = ""
    """The sign as it was written."""

    @property
    def span(self) -> Span:
        """Place of the token in the text."""
        return self.start, self.end

    @property
    def deepens(self) -> int:
        """Change of the number of open brackets by this token: 1, 0 or -1."""
        return _DEEPENING.get(self.kind, 0)


class Grammar(Protocol):
    """The part of a language that the lexer needs: its functions and its words."""

    @property
    def functions(self) -> Collection[str]:
        """The words of the language that are functions."""
        ...

    def begins(self, x: Lexeme) -> bool:
        """Whether a word of the language may begin with a lexeme."""
        ...

    def word(self, source: Source, at: int) -> words.Cut:
        """The word that begins at a lexeme; raises the error for a word that the language does not
        know."""
        ...


_NUMBER, _POWER = LexemePattern("@number"), LexemePattern("%high ~%high{0,60}")
_LONGEST_NUMBER, _LARGEST_EXPONENT = 40, 30
_DEEPENING = {"open": 1, "begin": 1, "close": -1, "end": -1}
_SIGNS = {
    **dict.fromkeys(table.FRACTIONS, ("fraction", "")),
    **{text: ("number", "", Fraction(*x)) for text, x in table.VULGAR_FRACTIONS.items()},
    **{text: (kind, "") for text, kind in table.KINDS_OF_SIGNS.items()},
    **{text: ("close", text[-1]) for text in table.BRACKETS.values()},
    **{text: ("open", text[-1]) for text in table.BRACKETS},
    **{text: ("operator", plain) for text, plain in table.OPERATORS.items()},
}
"""The kind of token that a sign is, its text where it is another, and its value."""
MATRICES = frozenset(table.MATRICES)


def tokens(source: Source, language: Grammar, piece: Span | None = None) -> list[Token]:
    """All tokens of a text, or of a piece of it, the last of kind "stop"."""
    found: list[Token] = []
    lexemes = source.lexemes
    inside = lexemes.between(*piece) if piece else range(len(lexemes))
    k = inside.start
    while k < inside.stop:
        x = lexemes[k]
        if language.begins(x):
            cut = language.word(source, k)
            found += _names(cut, language)
            k = cut.stop
        elif x.kind == "digit" or x.text == ".":
            k = _number(source, k, found)
        elif x.kind == "high":
            k = _power(source, k, found)
        else:
            found.append(_mark(source, x, language))
            k += 1
    end = piece[1] if piece else len(source.text)
    found.append(Token("stop", "", end, end))
    return found


def sides(line: Iterable[Token]) -> list[list[Token]]:
    """Tokens of a line, split at the signs of equality."""
    found: list[list[Token]] = [[]]
    for token in line:
        if token.kind == "equals":
            found.append([])
        else:
            found[-1].append(token)
    return found


def _names(cut: words.Cut, language: Grammar) -> Iterator[Token]:
    """Tokens of the names and numbers that a word consists of, with the power that stood before its
    subscript."""
    for name, start, end in cut.pieces:
        if name.isdigit():
            yield Token("number", name, start, end, Fraction(name))
        else:
            yield Token("function" if name in language.functions else "name", name, start, end)
    if cut.power is not None:
        end = cut.pieces[-1][2]
        yield Token("power", str(cut.power), end, end, Fraction(cut.power))


def _figures(match: Match) -> WrittenFigures:
    exponent = match["exponent"]
    return WrittenFigures(match["mantissa"], len(match.items("decimals")), int(exponent or 0))


def numbers(lexemes: Lexemes) -> Iterator[tuple[Match, WrittenFigures]]:
    """The numbers of a text without their signs, and where each stands."""
    return ((match, _figures(match)) for match in _NUMBER.all(lexemes))


def _number(source: Source, k: int, found: list[Token]) -> int:
    """The index behind a number or full stop, whose token is appended to `found`; of bare digits
    behind \\frac, as in \\frac12, only the first is taken."""
    lexemes = source.lexemes
    match = _NUMBER.at(lexemes, k)
    if match is None:
        if k + 1 >= len(lexemes) or lexemes[k + 1].apart or lexemes[k + 1].kind == "line":
            return k + 1  # a full stop
        source.fail("a decimal point without digits", (lexemes[k].start, lexemes[k].end))
    stop = match.stop
    kinds = [token.kind for token in found[-2:]]
    if kinds[-1:] == ["fraction"] or kinds == ["fraction", "number"]:
        whole = all(x.kind == "digit" for x in lexemes[k:stop])
        stop = k + 1 if whole else stop
    text, span = plain(lexemes[k:stop]), (lexemes[k].start, lexemes[stop - 1].end)
    figures = _figures(match)
    if len(figures.mantissa) > _LONGEST_NUMBER or abs(figures.exponent) > _LARGEST_EXPONENT:
        source.fail("this number is too long or too large", span)
    found.append(Token("number", text, *span, Fraction(text)))
    return stop


def _power(source: Source, k: int, found: list[Token]) -> int:
    """The index behind figures in superscript, whose token is appended to `found`."""
    lexemes, stop = source.lexemes, _POWER.end(source.lexemes, k)
    digits = "".join(table.HIGH[x.text] for x in lexemes[k:stop])
    if not digits.removeprefix("-").isdigit() or len(digits) > 9:
        x = lexemes[k]
        source.fail(f"{x.text!r} has no meaning here", (x.start, x.end))
    text, span = plain(lexemes[k:stop]), (lexemes[k].start, lexemes[stop - 1].end)
    found.append(Token("power", text, *span, Fraction(int(digits))))
    return stop


def _mark(source: Source, x: Lexeme, language: Grammar) -> Token:
    """The token of an operator, bracket, command or other mark."""
    text, span = x.text, (x.start, x.end)
    if text in _SIGNS:
        kind, own, *value = _SIGNS[text]
        return Token(kind, own or text, *span, *value, written=text)
    if x.kind in ("row", "begin", "end"):
        return Token(x.kind, text, *span)
    if x.command in table.FUNCTION_COMMANDS and x.command in language.functions:
        return Token("function", x.command, *span)
    if x.kind == "mark":
        source.fail("a dot, stroke or accent without a letter under it", span)
    if text == "\\":
        source.fail("a backslash alone", span)
    if text == "\\prime":
        source.fail("a prime is written ' here, such as \\theta_1'", span)
    if x.kind == "command":
        shown = text if len(text) <= 40 else f"{text[:40]}…"
        source.fail(f"the command {shown} is not known here", span)
    source.fail(f"{text[:1]!r} has no meaning here", span)
