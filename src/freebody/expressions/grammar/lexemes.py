"""Characters into lexemes: letters with their marks, digits, commands, signs. Blanks, comments and
marks without meaning lie between lexemes, and each knows whether such stood before it."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

from freebody.expressions.grammar.tables import characters as table
from freebody.lazy import cached_property

KINDS = (
    "letter", "digit", "low", "high", "mark", "command", "begin", "end", "row", "line", "sign",
    "frame", "determinant",
)  # fmt: skip
"""Kinds of lexemes; the last two are made of others, by the table of spellings."""


class Lexeme(NamedTuple):
    """A lexeme: a piece of a text, with its place there."""

    kind: str
    text: str
    start: int
    end: int
    apart: bool = False
    """Whether a blank stands before the lexeme."""

    @property
    def command(self) -> str:
        """The name of a LaTeX command; "" for any other lexeme."""
        return self.text[1:] if self.kind == "command" else ""


_LOW, _HIGH = "".join(table.LOW), "".join(table.HIGH)
_LEXEME = re.compile(
    rf"(?P<letter>[^\W\d_{_LOW}{_HIGH}ᵀ{''.join(table.VULGAR_FRACTIONS)}][{table.ANY_MARK}]*)"
    rf"|(?P<digit>[0-9])|(?P<blank>(?:[^\S\n]|[{table.SILENT}])+)"
    r"|(?P<environment>\\(?:begin|end)\s*\{[A-Za-z]+\*?\}(?:\{[clr|\s]*\})?)"
    r"|(?P<row>\\\\(?:\s*\[[^\]\n]{0,12}\])?)|(?P<command>\\(?:[A-Za-z]+|.|$))"
    rf"|(?P<low>[{_LOW}])|(?P<high>[{_HIGH}])|(?P<mark>[{table.ANY_MARK}])|(?P<line>\n)"
    rf"|(?P<comment>\#[^\n]*)|(?P<sign>{'|'.join(map(re.escape, table.SIGNS))}|.)",
    re.DOTALL,
)
_DEEPENING = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}
_SILENT = frozenset(f"\\{name}" for name in table.SILENT_COMMANDS)


def scanned(text: str) -> list[Lexeme]:
    """The lexemes of a text with accents decomposed."""
    made: list[Lexeme] = []
    apart = True
    for match in _LEXEME.finditer(text):
        kind, found = match.lastgroup or "", match[0]
        if kind == "environment":
            name = found[found.index("{") + 1 : found.index("}")]
            kind = found[1:].partition("{")[0].strip() if name in table.MATRICES else "blank"
            found = name
        if kind in ("blank", "comment") or found in _SILENT:
            apart = True
        else:
            made.append(Lexeme(kind, found, *match.span(), apart))
            apart = kind == "line"
    return made


class Lexemes(Sequence[Lexeme]):
    """The lexemes of a text, found by their kinds and texts, and by place."""

    def __init__(self, items: Iterable[Lexeme]):
        self.items = list(items)

    @classmethod
    def of(cls, text: str) -> Lexemes:
        """The lexemes of a text with accents decomposed."""
        return cls(scanned(text))

    def __len__(self) -> int:
        return len(self.items)

    def __getitem__(self, k):  # type: ignore[no-untyped-def]
        return self.items[k]

    def __iter__(self) -> Iterator[Lexeme]:
        return iter(self.items)

    @cached_property
    def _starts(self) -> list[int]:
        return [x.start for x in self.items]

    @cached_property
    def places(self) -> dict[str, list[int]]:
        """The indices of the lexemes of each text, and of each kind under its name behind a %."""
        found: dict[str, list[int]] = {}
        for k, x in enumerate(self.items):
            found.setdefault(x.text, []).append(k)
            found.setdefault(f"%{x.kind}", []).append(k)
        return found

    @cached_property
    def depths(self) -> list[int]:
        """The number of brackets open in front of each lexeme, and behind the last; negative where
        more were closed."""
        return list(accumulate((_DEEPENING.get(x.text, 0) for x in self.items), initial=0))

    def at(self, place: int) -> int:
        """The index of the first lexeme that begins at a place of the text or later."""
        return bisect_left(self._starts, place)

    def between(self, start: int, end: int) -> range:
        """The indices of the lexemes that begin between two places of the text."""
        return range(self.at(start), self.at(end))

    def closing(self, k: int) -> int | None:
        """The index of the brace that closes the one at lexeme k; None where nothing does."""
        return self._closings.get(k)

    @cached_property
    def _closings(self) -> dict[int, int]:
        """The index of the closing brace for each opening brace that is closed."""
        found, opened = dict[int, int](), list[int]()
        for k, x in enumerate(self.items):
            if x.text == "{":
                opened.append(k)
            elif x.text == "}" and opened:
                found[opened.pop()] = k
        return found


NOTHING = Lexemes(())


def plain(items: Iterable[Lexeme]) -> str:
    """The texts of lexemes without blanks."""
    return "".join(x.text for x in items)
