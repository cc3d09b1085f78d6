"""Where a text says that one of the robot's quantities is equal to something, whether the reader of
answers understands the rest or not."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from freebody.derivations.check.spelling.answer_text import AnswerText
from freebody.derivations.grammar import words
from freebody.derivations.grammar.source import Span
from freebody.errors import FreebodyError

_MARK = re.compile(
    r"(?<![<>!=])=|[≈≃≅≡≜≔]|\\(?:approx|simeq|cong|equiv|triangleq|coloneqq|doteq)(?![A-Za-z])"
)
"""Signs of equality, also of an approximate one."""
_LONGEST_LEFT = 60
_BEFORE = re.compile(
    r"(?:[\s$&+:*/`-]|\\(?:quad|qquad|not|[,;:!( )]))+$|\([^()]*\)$|\[[^\[\]]*\]$"
    r"|(?:\\(?:overset|underset|stackrel)\s{0,9}\{[^{}]*\}\s{0,9}|\\mathrel\s{0,9})?\{$"
)
"""What may stand between a quantity and the mark: alignment, arguments, a unit, +=, \\overset."""


def asked_marks(text: str, span: Span, is_quantity: Callable[[str], bool]) -> Iterator[Span]:
    """In a stretch of a text the signs of equality with a quantity left of them: where its name
    begins, and where the sign stands."""
    for match in _MARK.finditer(text, *span):
        line = text.rfind("\n", max(0, match.start() - _LONGEST_LEFT), match.start()) + 1
        start = max(line, match.start() - _LONGEST_LEFT)
        name = _last_quantity(text[start : match.start()], is_quantity)
        if name is not None:
            yield start + name, match.start()


def _last_quantity(left: str, is_quantity: Callable[[str], bool]) -> int | None:
    """Where the last word begins if it is a quantity's name, apart from what may stand behind
    it."""
    while True:
        for at, name in _last_names(left):
            if is_quantity(name):
                return at
        shorter = _BEFORE.sub("", left)
        if shorter == left:
            return None
        left = shorter


def _last_names(left: str) -> Iterator[tuple[int, str]]:
    """The names with which a text may end: where they begin, and their plain spelling."""
    source = AnswerText(left)
    for at, c in enumerate(left):
        inside = at > 0 and (left[at - 1].isalnum() or left[at - 1] in "_\\")
        if inside or not (c in words.STARTS or c == "\\"):
            continue
        try:
            word = words.spell(source, at)
        except FreebodyError:  # it begins as a name does and is none
            continue
        if word.end == len(left):
            yield at, word.plain
