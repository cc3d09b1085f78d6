"""Plain text: equations on lines of their own, or among words."""

from __future__ import annotations

from freebody.expressions.grammar.source import Span
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    DocumentForm,
    FormulaPiece,
    plain_characters,
)


def read(text: str) -> AnswerDocument:
    """All of it may be formula; words are found by the vocabulary."""
    plain = plain_characters(text)
    whole = FormulaPiece(0, len(plain))
    return AnswerDocument(plain, plain, (whole,), tuple(lines(plain, 0, len(plain))), strict=True)


def lines(text: str, start: int, end: int) -> list[Span]:
    """The lines between two places."""
    found = []
    while start < end:
        stop = text.find("\n", start, end)
        stop = end if stop < 0 else stop
        found.append((start, stop))
        start = stop + 1
    return found


FORM = DocumentForm("text", "plain text, an equation a line", (".txt",), read)
