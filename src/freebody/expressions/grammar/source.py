"""A text that is read, and errors that point into it."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Any, ClassVar, NoReturn, Self

from freebody.errors import FreebodyError
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.nodes import Span
from freebody.lazy import cached_property

_SHOWN = 96
"""The most characters of a line that an error shows."""


class UnreadableError(FreebodyError, ValueError):
    """A text that cannot be read: what is wrong, where, and the line with a caret under the
    place."""

    asked_by = ""
    """The caller that refuses a text, in front of the message."""

    def __init__(
        self,
        problem: str,
        advice: str = "",
        line: int = 0,
        column: int = 0,
        context: str = "",
        part: str = "",
    ):
        self.line, self.column, self.context, self.part = line, column, context, part
        where = f" ({part}line {line}, column {column})" if line else ""
        self.bare = problem
        self.problem = f"{self.asked_by}{problem}{where}.{' ' if advice else ''}{advice}"
        super().__init__(self.problem + (f"\n{context}" if context else ""))


@dataclass(frozen=True)
class Source:
    """A text to be read, with accents decomposed: θ̇ is θ and a dot. Subclasses say what the text
    is, how long it may be, and which error reports what is wrong."""

    text: str

    what: ClassVar[str] = "text"
    longest: ClassVar[int] = 20_000
    """The most characters that are read."""
    error: ClassVar[type[UnreadableError]] = UnreadableError

    @classmethod
    def of(cls, text: str) -> Self:
        """The source of a text; raises an error where the text is too long."""
        if len(text) > cls.longest:
            raise cls.error(
                f"the {cls.what} has {len(text)} characters; at most {cls.longest} are read"
            )
        return cls(decomposed(text))

    @property
    def shown(self) -> str:
        """The text as it was written, character by character where `text` is."""
        return self.text

    @cached_property
    def lexemes(self) -> Lexemes:
        """The text's lexemes: letters, digits, commands and signs."""
        return Lexemes.of(self.text)

    @cached_property
    def words(self) -> dict[int, Any]:
        """The words spelt so far, by the index of the lexeme that they begin with."""
        return {}

    def plain(self, span: Span) -> str:
        """A piece of the text as it is understood, without blanks: 2.5e-3 for 2.5·10⁻³."""
        lexemes = self.lexemes
        return "".join(lexemes[k].text for k in lexemes.between(*span))

    def __getitem__(self, span: Span) -> str:
        """A piece of the text as it was written, on one line."""
        return " ".join(unicodedata.normalize("NFC", self.shown[span[0] : span[1]]).split())

    def part(self, at: int) -> tuple[str, int]:
        """The name of the part of the text that a place lies in, and where that part begins; "" and
        0 for a text in one piece."""
        return "", 0

    def place(self, at: int) -> tuple[int, int]:
        """Line and column of a place in the text, from 1; dots above letters take no column."""
        before = self.shown[self.part(at)[1] : at]
        start = before.rfind("\n") + 1
        return before.count("\n") + 1, _width(before[start:]) + 1

    def fail(self, problem: str, span: Span, advice: str = "") -> NoReturn:
        """Raise an error that points at a piece of the text."""
        line, column = self.place(span[0])
        part, _ = self.part(span[0])
        raise self.error(
            problem, advice, line, column, self.caret(span), f"{part}, " if part else ""
        )

    def caret(self, span: Span) -> str:
        """The line of the text, shortened with "…" where it is long, and below it carets under a
        piece."""
        start = self.shown.rfind("\n", 0, span[0]) + 1
        end = self.shown.find("\n", span[0])
        end = len(self.shown) if end < 0 else end
        first = max(start, min(span[0] - _SHOWN // 2, end - _SHOWN))
        while first > start and unicodedata.combining(self.shown[first]):
            first -= 1
        last = min(end, first + _SHOWN)
        shown = self.shown[first:last].replace("\t", " ")
        shown = ("…" + shown[1:] if first > start else shown) + ("…" if last < end else "")
        size = max(1, _width(self.shown[span[0] : min(span[1], end)]))
        pad = " " * (_width(self.shown[first : span[0]]) + 4)
        return f"    {unicodedata.normalize('NFC', shown)}\n{pad}{'^' * min(size, _SHOWN)}"


def decomposed(text: str) -> str:
    """A text with accents decomposed and the letters of mathematical fonts, 𝜃 of Word, as plain
    ones; both are a character each."""
    plain = _MATHEMATICAL.sub(lambda letter: unicodedata.normalize("NFKC", letter[0]), text)
    return unicodedata.normalize("NFD", plain)


_MATHEMATICAL = re.compile("[\U0001d400-\U0001d7ff\u210e]")


def _width(text: str) -> int:
    return sum(not unicodedata.combining(c) for c in text)
