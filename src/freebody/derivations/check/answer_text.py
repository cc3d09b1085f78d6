"""The text of an answer, and the error for one that cannot be read."""

from __future__ import annotations

from freebody.derivations.grammar.source import Source, UnreadableError


class AnswerError(UnreadableError):
    """An answer that cannot be read: what is wrong, where, and the line with a caret under the
    place."""

    asked_by = "check: "


class AnswerText(Source):
    """An answer's text."""

    what, error = "answer", AnswerError
