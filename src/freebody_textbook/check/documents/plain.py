"""Reading plain text: equations on lines of their own or among words, which are distinguished from
the robot's names.

Words are taken away only where no term can be lost: in front of an equation, or where a sentence
holds no equals sign and does not begin with an operator, as what continues an equation would.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from unicodedata import category

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.source import Span
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    DocumentForm,
    FormulaPiece,
    plain_characters,
)

_WORDS = LexemePattern("@words")
_EQUALS = LexemePattern("< = | == >")
_OPERATORS = frozenset("+-−–*·×/=")
_IN_FORMULAS = LexemePattern("%in_formulas | %apart < %minus | – > %apart | -%name ~(")


def read(text: str) -> AnswerDocument:
    """Document of a plain text, any part of which may be a formula; words are recognised later by
    the vocabulary."""
    plain = plain_characters(text)
    whole = FormulaPiece(0, len(plain))
    return AnswerDocument(plain, plain, (whole,), tuple(lines(plain, 0, len(plain))), strict=True)


def lines(text: str, start: int, end: int) -> list[Span]:
    """Spans of the lines between two positions of a text."""
    found = []
    while start < end:
        stop = text.find("\n", start, end)
        stop = end if stop < 0 else stop
        found.append((start, stop))
        start = stop + 1
    return found


FORM = DocumentForm("text", "plain text, an equation a line", (".txt",), read)


@dataclass(frozen=True)
class Sentence:
    """A stretch between punctuation marks: where its part that is no words begins, and whether
    words precede or follow."""

    start: int
    kept: int
    end: int
    words_before: bool = False
    words_behind: bool = False

    @property
    def is_empty(self) -> bool:
        """Whether the stretch contained only words."""
        return self.kept == self.end


def sentences(lexemes: Lexemes, line: Span, is_name: Callable[[range], bool]) -> Iterator[Sentence]:
    """The stretches of a line that contain words, without the words in front of equations."""
    for within, start, end in _stretches(lexemes, line):
        words = [
            range(match.start, match.stop)
            for match in _WORDS.all(lexemes, within.start, within.stop)
            if _is_word(match) and not all(map(is_name, _parts(match)))
        ]
        if not words:
            continue
        equals = next(_EQUALS.all(lexemes, within.start, within.stop), None)
        if equals is None:
            if lexemes[within.start].text not in _OPERATORS:
                behind = lexemes[within.stop : within.stop + 1]
                stop = behind[0].end if behind and behind[0].text in (".", ":") else end
                yield Sentence(start, stop, stop, True)
            continue
        before = [x.stop for x in words if x.start < _last_name(lexemes, within, equals.start)]
        if before and _is_formula(lexemes, within.start, before[-1]):
            before = []
        behind = any(x.start > equals.start for x in words)
        if before or behind:
            kept = lexemes[before[-1] - 1].end if before else start
            yield Sentence(start, kept, end, bool(before), behind)


def _parts(match: Match) -> Iterator[range]:
    """The parts of a word between its hyphens."""
    start = match.start
    for k in range(match.start, match.stop):
        if match.lexemes[k].text == "-":
            yield range(start, k)
            start = k + 1
    yield range(start, match.stop)


def _is_word(match: Match) -> bool:
    """Whether a run of lexemes consists of letters, without superscripts such as a transpose's."""
    items = match.lexemes[match.start : match.stop]
    return all(category(x.text) != "Lm" for x in items if x.kind == "letter")


def _last_name(lexemes: Lexemes, within: range, k: int) -> int:
    """The index of the first lexeme of the name that directly precedes lexeme k; k if there is
    none."""
    first = k
    while first > within.start and (
        lexemes[first - 1].kind in ("letter", "digit", "low", "command")
        or lexemes[first - 1].text == "_"
    ):
        first -= 1
        if lexemes[first].apart:
            break
    return first


def _is_formula(lexemes: Lexemes, start: int, stop: int) -> bool:
    """Whether an operator among or after words shows that they are part of a formula."""
    behind = stop
    while behind < len(lexemes) and lexemes[behind].kind == "line":
        behind += 1
    among = next(_IN_FORMULAS.all(lexemes, start, stop), None)
    return among is not None or (behind < len(lexemes) and lexemes[behind].text in _OPERATORS)


def _stretches(lexemes: Lexemes, line: Span) -> Iterator[tuple[range, int, int]]:
    """A line split at commas, semicolons and stops outside of brackets: lexemes, start and end of
    each piece."""
    start, within, depths = line[0], lexemes.between(*line), lexemes.depths
    first, outside = within.start, depths[within.start]
    for k in within:
        x = lexemes[k]
        stops = x.text in (",", ";") or (x.text in (".", ":") and _stops(lexemes, k))
        if stops and depths[k] <= outside:
            yield range(first, k), start, x.start
            first, start = k + 1, x.end
    yield range(first, within.stop), start, line[1]


def _stops(lexemes: Lexemes, k: int) -> bool:
    """Whether punctuation at lexeme k ends a stretch: a blank or the line's end follows."""
    return k + 1 >= len(lexemes) or lexemes[k + 1].apart or lexemes[k + 1].kind == "line"
