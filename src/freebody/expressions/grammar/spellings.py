"""Lexemes rewritten to one spelling: alternative spellings from a table are replaced."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

from freebody.expressions.grammar.lexemes import Lexeme, Lexemes, scanned
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.tables.characters import HIGH
from freebody.expressions.grammar.tables.spellings import LABEL, SPELLINGS


class _SpellingRow:
    """A row of the table of spellings: a pattern, and the spelling that replaces its matches."""

    def __init__(self, find: str, put: str, remark: str = ""):
        self.pattern = LexemePattern(find)
        self.put = put.split()
        self.is_wide = remark != LABEL
        self.literal = {x: scanned(x) for x in self.put if x[0] not in "$#␣" and "$" not in x}

    def applied(self, lexemes: Lexemes) -> Lexemes:
        """The lexemes with each match of the row's pattern replaced by its standard spelling."""
        found = list(self.pattern.all(lexemes))
        if not found:
            return lexemes
        made: list[Lexeme] = []
        at = 0
        items = list(lexemes.items)
        for match in found:
            made += items[at : match.start]
            made += self._written(match, items[match.start].apart)
            at = match.stop
            if at < len(items):  # what was written there is no part of what follows
                items[at] = items[at]._replace(apart=True)
        return Lexemes(made + items[at:])

    def _written(self, match: Match, apart: bool) -> Sequence[Lexeme]:
        start, end = match.span
        made: list[Lexeme] = []
        for item in self.put:
            if item == "␣":
                apart = True
                continue
            place = made[-1].end if made else start
            for k, x in enumerate(self._item(item, match)):
                moved = x if item[0] == "$" else x._replace(start=place, end=place)
                made.append(moved._replace(apart=apart) if k == 0 else moved)
                apart = False
        if made and self.is_wide:
            made[0] = made[0]._replace(start=start)
            made[-1] = made[-1]._replace(end=end)
        return made

    def _item(self, item: str, match: Match) -> Iterator[Lexeme]:
        if item == "#determinant":
            yield Lexeme("determinant", "", 0, 0)
        elif item.startswith("frame("):
            frame = match[item[7:-1]]
            yield Lexeme("frame", HIGH.get(frame, frame), 0, 0)
        elif item.startswith("plain("):
            figures = "".join(HIGH.get(c, c) for c in match[item[7:-1]]).replace("−", "-")
            yield from scanned(figures)
        elif item[0] == "$":
            yield from match.items(item[1:])
        else:
            yield from self.literal[item]


_ROWS = [_SpellingRow(*row) for row in SPELLINGS]


@lru_cache(maxsize=4)
def in_one_spelling(text: str) -> Lexemes:
    """The lexemes of a text in standard spelling; results for the last few texts are kept, since
    several readers ask for them in turn."""
    lexemes = Lexemes.of(text)
    for row in _ROWS:
        lexemes = row.applied(lexemes)
    return lexemes
