"""Equals signs after one of the robot's quantities, found even where the rest of the line cannot be
read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from freebody.expressions.grammar import words
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source
from freebody.expressions.grammar.tables.characters import PRIMES, STARS

_MARK = LexemePattern("%equality")
_FRESH = LexemePattern("%fresh")
_BEHIND_NAME = LexemePattern(
    "< %beside_equality | ( %not_bracket{0,40} ) | [ %not_bracket{0,40} ]"
    " | < %over_equality { %not_brace{0,40} } | \\mathrel >? { > %last"
)
"""The things that may stand between a quantity and a sign of equality: alignment, arguments, a
unit, +=, \\overset."""
_LONGEST_LEFT = 60


@dataclass(frozen=True)
class AskedMark:
    """An equals sign with the name on its left."""

    name: str
    start: int
    """The place at which the name begins in the text."""
    at: int
    """The place of the sign in the text."""
    lexeme: int
    """The number of the sign's lexeme."""


def asked_marks(
    source: Source, within: range, is_quantity: Callable[[str], bool]
) -> Iterator[AskedMark]:
    """The equals signs in a stretch of lexemes that have a quantity on their left."""
    lexemes = source.lexemes
    for match in _MARK.all(lexemes, within.start, within.stop):
        k = match.start
        name = quantity_before(source, k, is_quantity)
        if name is not None:
            yield AskedMark(name.plain, name.start, lexemes[k].start, k)


def quantity_before(
    source: Source, k: int, is_quantity: Callable[[str], bool]
) -> words.Word | None:
    """The quantity's name before a lexeme on the same line, ignoring what may stand between."""
    items = source.lexemes.items
    first = k
    while first > 0 and items[first - 1].kind != "line":
        if items[first - 1].start < items[k].start - _LONGEST_LEFT:
            break
        first -= 1
    return _last_quantity(source, first, k, is_quantity)


def _last_quantity(
    source: Source, first: int, end: int, is_quantity: Callable[[str], bool]
) -> words.Word | None:
    """The last name of a stretch if it is a quantity, ignoring what may follow it."""
    while end > first:
        for word in _last_names(source, first, end):
            if is_quantity(word.plain):
                return word
        shorter = (
            k
            for k in range(end - 1, first - 1, -1)
            if _BEHIND_NAME.at(source.lexemes, k, end) is not None
        )
        found = next(shorter, None)
        if found is None:
            return None
        end = found
    return None


def _last_names(source: Source, first: int, end: int) -> Iterator[words.Word]:
    """Names with which a stretch may end."""
    lexemes = source.lexemes
    last = lexemes[end - 1]
    if last.kind in ("sign", "line", "row") and last.text not in _LAST:
        return
    for k in range(first, end):
        word = words.word_at(source, k) if _FRESH.at(lexemes, k) else None
        if word is not None and word.at == end:
            yield word


_LAST = frozenset((*PRIMES, *STARS, "}", "_"))
