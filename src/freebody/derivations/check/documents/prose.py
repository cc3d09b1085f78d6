"""Words between equations: found by what they are not, names of the robot's.

Words are taken away only where no term can be lost: in front of an equation, or where a sentence
holds no equals sign and does not begin with an operator, as what continues an equation would.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from unicodedata import category

from freebody.derivations.grammar.source import Span

_WORD = re.compile(r"(?<![\w\\^{/])[^\W\d_]{2,}(?:[-'’][^\W\d_]+)*(?![\w(\u0300-\u036f])")
_END = re.compile(r"[,;()\[\]{}]|[.:](?=\s|$)")
_EQUALS = re.compile(r"(?<![<>!:=])=")
_LAST_NAME = re.compile(r"[^\W\d_]\w{0,40}\s{0,3}$")
_IN_FORMULAS = re.compile(r"[+*/^\\·×=∂]|\s[-−–]\s|\w\(")
_OPERATORS = "+-−–*·×/="


@dataclass(frozen=True)
class Sentence:
    """A stretch between stops: where what is no words begins, and whether words stood before or
    behind."""

    start: int
    kept: int
    end: int
    words_before: bool = False
    words_behind: bool = False

    @property
    def is_empty(self) -> bool:
        """Whether nothing but words stood there."""
        return self.kept == self.end


def sentences(text: str, line: Span, is_name: Callable[[str], bool]) -> Iterator[Sentence]:
    """The stretches of a line that words stand in, without the words in front of equations."""
    for start, end in _stretches(text, line):
        words = [
            match.span()
            for match in _WORD.finditer(text, start, end)
            if _is_word(match[0]) and not all(map(is_name, match[0].split("-")))
        ]
        if not words or "#" in text[line[0] : words[0][0]]:
            continue
        equals = _EQUALS.search(text, start, end)
        if equals is None:
            if text[start:end].lstrip()[:1] not in _OPERATORS:
                stop = end + (text[end : end + 1] in (".", ":"))
                yield Sentence(start, stop, stop, True)
            continue
        name = _LAST_NAME.search(text, start, equals.start())
        limit = name.start() if name else equals.start()
        before = [b for a, b in words if a < limit]
        if before and _is_formula(text, start, before[-1]):
            before = []
        behind = any(a > equals.start() for a, _ in words)
        if before or behind:
            yield Sentence(start, before[-1] if before else start, end, bool(before), behind)


def _is_word(text: str) -> bool:
    """Whether it is made of letters alone: no superscripts, such as that of a transpose."""
    return all((c.isalpha() and category(c) != "Lm") or c in "-'’" for c in text)


def _is_formula(text: str, start: int, end: int) -> bool:
    """Whether an operator among or behind words tells that they are part of a formula."""
    behind = text[end : end + 80].lstrip()[:1]
    return bool(_IN_FORMULAS.search(text, start, end)) or (behind != "" and behind in _OPERATORS)


def _stretches(text: str, line: Span) -> Iterator[Span]:
    """A line cut at commas, semicolons and stops outside of brackets."""
    depth, start = 0, line[0]
    for match in _END.finditer(text, *line):
        mark = match[0]
        if mark in "([{":
            depth += 1
        elif mark in ")]}":
            depth -= 1
        elif depth <= 0:
            yield start, match.start()
            start = match.end()
    yield start, line[1]
