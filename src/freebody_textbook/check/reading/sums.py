"""Sums over bodies, V = Σ m_i g y_ci: the summand is read once per body, with its number as the
index."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from freebody.expressions.grammar.lexemes import Lexeme, Lexemes
from freebody.expressions.grammar.lexer import Grammar, Token, tokens
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.source import Span
from freebody.expressions.grammar.tables.characters import LOW
from freebody_textbook.check.spelling.answer_text import AnswerText

MOST_SUMS = 200
"""The most sums of one text that are read."""
MOST_TOKENS, DEEPEST = 10_000, 3
"""The most tokens of a sum that is written out, and the most sums inside one another."""
_LONGEST = 600
"""The most lexemes of a summand."""
_HEAD = LexemePattern("@sum_sign < below:@sum_below above:@sum_above? | above:@sum_above? >")
_CALL = LexemePattern("@sum_sign ~(")
_ARGUMENTS = LexemePattern("@sum_arguments )")
_BOUNDS = LexemePattern("< @sum_index | @sum_index_low > < = first:%digit{1,2} >?")
_NUMBER = LexemePattern("^ {? last:%digit{1,2}")
_INDICES = ("i", "j", "k")
_LOW_OF = {letter: low for low, letter in LOW.items() if letter.isalpha()}
_ENDS = frozenset(("=", "==", ",", ";", "&"))
_SIGNS = frozenset(("+", "-", "−"))


@dataclass(frozen=True)
class WrittenSum:
    """A sum: its lexemes, those of the summand, the index and its values."""

    whole: range
    summand: range
    index: str
    values: range

    def with_number(self, source: AnswerText, number: int) -> AnswerText:
        """The text with the index replaced by a number; each character keeps its place."""
        places = set(_places_of(source.lexemes, self.summand, self.index))
        items = [
            _numbered(x, number) if k in places else x for k, x in enumerate(source.lexemes.items)
        ]
        return _with_lexemes(source, Lexemes(items))


def sums(lexemes: Lexemes, within: range, count: int) -> Iterator[WrittenSum]:
    """The outermost sums in a stretch; count: the number of bodies, for sums without bounds."""
    at = within.start
    for match in islice(_HEAD.all(lexemes, within.start, within.stop), MOST_SUMS):
        end = min(within.stop, match.stop + _LONGEST)
        found = _sum(lexemes, match, end, count) if match.start >= at else None
        if found is not None:
            yield found
            at = found.whole.stop


def tokens_with_sums(
    source: AnswerText, language: Grammar, piece: Span, count: int, depth: int = 0
) -> list[Token]:
    """All tokens of a piece of text with sums expanded; the last token is of kind "stop"."""
    lexemes, at, found = source.lexemes, piece[0], list[Token]()
    for one in sums(lexemes, lexemes.between(*piece), count):
        start, end = lexemes[one.whole.start].start, lexemes[one.whole.stop - 1].end
        found += tokens(source, language, (at, start))[:-1]
        inside = lexemes[one.summand.start].start, lexemes[one.summand.stop - 1].end
        if depth == DEEPEST:
            source.fail(f"more than {DEEPEST} sums inside one another", (start, end))
        found.append(Token("open", "(", start, start))
        for k, number in enumerate(one.values):
            numbered = one.with_number(source, number)
            found += [Token("operator", "+", start, start, written="+")] * bool(k)
            found += tokens_with_sums(numbered, language, inside, count, depth + 1)[:-1]
            if len(found) > MOST_TOKENS:
                source.fail("this sum is too long to be written out", (start, end))
        found.append(Token("close", ")", end, end))
        at = end
    return found + tokens(source, language, (at, piece[1]))


def _sum(lexemes: Lexemes, head: Match, end: int, count: int) -> WrittenSum | None:
    """The sum that begins with Σ or a sum command; None if it has no index."""
    if (call := _CALL.at(lexemes, head.start, end)) is not None:
        return _called(lexemes, call, end, count)
    below = next(_BOUNDS.all(lexemes, *head.captures["below"]), None) if "below" in head else None
    above = next(_NUMBER.all(lexemes, *head.captures["above"]), None) if "above" in head else None
    values = _values(below["first"] if below else "", above["last"] if above else "", count)
    for index in (LOW.get(below["index"], below["index"]),) if below else _INDICES:
        stop = _end_of_summand(lexemes, head.stop, end, index)
        found = _checked(lexemes, head.start, stop, range(head.stop, stop), index, values)
        if found is not None:
            return found
    return None


def _called(lexemes: Lexemes, call: Match, end: int, count: int) -> WrittenSum | None:
    """The sum written sum(…), with or without bounds after a comma."""
    close = _closing(lexemes, call.stop - 1, end)
    for bounds in _ARGUMENTS.all(lexemes, call.stop, close + 1):
        if bounds.stop == close + 1:
            values = _values(bounds["first"], bounds["last"], count)
            summand = range(call.stop, bounds.start)
            return _checked(lexemes, call.start, close + 1, summand, bounds["index"], values)
    values, summand = _values("", "", count), range(call.stop, close)
    ways = (_checked(lexemes, call.start, close + 1, summand, x, values) for x in _INDICES)
    return next((way for way in ways if way is not None), None)


def _checked(
    lexemes: Lexemes, start: int, stop: int, summand: range, index: str, values: range
) -> WrittenSum | None:
    """A sum, if its index occurs in the summand; otherwise None."""
    if not any(True for _ in _places_of(lexemes, summand, index)):
        return None
    return WrittenSum(range(start, stop), summand, index, values)


def _values(first: str, last: str, count: int) -> range:
    return range(int(first or 1), int(last or count) + 1)


def _closing(lexemes: Lexemes, k: int, end: int) -> int:
    """The bracket that closes the one at k; the last lexeme if none does."""
    depths = lexemes.depths
    return next((j for j in range(k, end) if depths[j + 1] <= depths[k]), end - 1)


def _end_of_summand(lexemes: Lexemes, k: int, end: int, index: str) -> int:
    """The lexeme after the last term that contains the index, also beyond + and -, up to another
    sum."""
    term, depths = k, lexemes.depths

    def ends(j: int) -> bool:
        x, depth = lexemes[j], depths[j + 1] - depths[k]
        return depth < 0 or (depth == 0 and (x.text in _ENDS or x.kind in ("line", "row", "end")))

    stop = next(filter(ends, range(k, end)), end)
    for j in [*_operators(lexemes, k, stop), stop]:
        has_index = any(True for _ in _places_of(lexemes, range(term, j), index))
        begun = term + (lexemes[term].text in _SIGNS) if term < j else term
        if term > k and (not has_index or _HEAD.at(lexemes, begun, stop)):
            return term
        term = j
    return stop


def _operators(lexemes: Lexemes, k: int, stop: int) -> Iterator[int]:
    """The signs + and - after a lexeme, outside of brackets and powers."""
    for j in range(k + 1, stop):
        outside = lexemes.depths[j] == lexemes.depths[k]
        if outside and lexemes[j].text in _SIGNS and lexemes[j - 1].text != "^":
            yield j


def _places_of(lexemes: Lexemes, within: range, index: str) -> Iterator[int]:
    """The lexemes that are the summation index: in a subscript, or as a factor."""
    inside, depth = False, 0
    for k in within:
        x, before = lexemes[k], lexemes[k - 1] if k > within.start else None
        if depth:
            depth += (x.text == "{") - (x.text == "}")
        elif x.text == "{" and before is not None and before.text == "_":
            depth = 1
        elif x.text == "_":
            inside = True
        elif x.apart or x.kind not in ("letter", "digit", "low"):
            inside = False
        is_own = x.text == index and (inside or depth or _stands_alone(lexemes, k, within))
        if is_own or x.text == _LOW_OF.get(index):
            yield k


def _stands_alone(lexemes: Lexemes, k: int, within: range) -> bool:
    """Whether the letter at k has no letter or digit directly beside it."""
    behind = lexemes[k + 1] if k + 1 < within.stop else None
    glued = behind is not None and not behind.apart and behind.kind in ("letter", "digit", "low")
    before = lexemes[k - 1] if k > within.start and not lexemes[k].apart else None
    return not glued and not (before is not None and before.kind in ("letter", "command"))


def _numbered(x: Lexeme, number: int) -> Lexeme:
    return x._replace(kind="digit", text=str(number))


def _with_lexemes(source: AnswerText, lexemes: Lexemes) -> AnswerText:
    """A text with its lexemes replaced."""
    made: Any = replace(source)
    made.__dict__["lexemes"] = lexemes
    return made
