"""The text of an answer, and the error for text that cannot be read."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Self

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.respelling import in_one_spelling
from freebody.expressions.grammar.source import Source, Span, UnreadableError
from freebody.expressions.grammar.tables.characters import FILL
from freebody.lazy import cached_property


class AnswerError(UnreadableError):
    """Error for an answer that cannot be read: the problem, its place, and the line with a caret
    below the place."""

    asked_by = "check: "


@dataclass(frozen=True)
class AnswerText(Source):
    """An answer's text with parts that are not to be checked replaced by blanks, so that all places
    stay the same."""

    written: str = ""
    """The text as the user wrote it, character by character; "" where that is `text`."""
    parts: tuple[tuple[str, int], ...] = ()
    """The cells of a notebook, and where each begins."""

    what, error = "answer", AnswerError

    @classmethod
    def of(cls, text: str) -> Self:
        plain = super().of(text)
        return cls.of_formulas(plain.text)

    @classmethod
    def of_formulas(cls, text: str, written: str = "", parts: tuple = ()) -> Self:
        """The text with accents decomposed; `written` is the text before words were removed."""
        size = len("".join(text.split()))
        if size > cls.longest:
            raise AnswerError(f"the answer has {size} characters; at most {cls.longest} are read")
        return cls(text, written, parts)

    @property
    def shown(self) -> str:
        return self.written or self.text

    @cached_property
    def lexemes(self) -> Lexemes:
        """The answer's letters, digits, commands and signs in one spelling."""
        return in_one_spelling(self.text)

    def __getitem__(self, span: Span) -> str:
        return super().__getitem__(self._with_padding(span))

    def caret(self, span: Span) -> str:
        """The line of the answer that contains a span, with carets below the text of the span as it
        was originally written."""
        return super().caret(self._with_padding(span))

    def _with_padding(self, span: Span) -> Span:
        """A span extended by the blanks after text that is shorter than originally written."""
        end = span[1]
        while self.text[end : end + 1] == FILL:
            end += 1
        return span[0], end

    def part(self, at: int) -> tuple[str, int]:
        k = bisect_right(self.parts, at, key=lambda part: part[1])
        return self.parts[k - 1] if k else ("", 0)

    def where(self, at: int) -> str:
        """Phrase for the line of a place, such as "line 3"."""
        part, _ = self.part(at)
        line = f"line {self.place(at)[0]}"
        return f"{part}, {line}" if part else line
