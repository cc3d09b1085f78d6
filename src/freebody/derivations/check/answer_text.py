"""The text of an answer, and the error for one that cannot be read."""

from __future__ import annotations

import re
from typing import Self

from freebody.derivations.grammar.source import Source, UnreadableError

_STATE = (
    r"(?:\\(?:d?dot|boldsymbol|mathbf)\s*\{?\s*)*(?:\\(?:var)?[Tt]heta|[qQΘθϑ])[\u0307\u0308]?"
    r"\s*\}{0,2}"
)
_ARGUMENTS = re.compile(
    r"(?<![\w\\])((?:[A-Za-z]|\\?tau|τ|\\?phi|\\?Gamma|J_P|J_\{P\})\s*)"
    rf"(\(\s*{_STATE}(?:\s*,\s*{_STATE})*\s*\))(?=\s*&?\s*(?:=|$))",
    re.MULTILINE,
)
"""A quantity and what it depends on: M(q), C(q, q̇)."""
_DETERMINANT = re.compile(
    r"(?<![\w\\])\\?det(?:\s+|\s*\(\s*)J(?:_P|_\{P\})?\s*\)?(?=\s*&?\s*(?:=|$))", re.MULTILINE
)


class AnswerError(UnreadableError):
    """An answer that cannot be read: what is wrong, where, and the line with a caret under the
    place."""

    asked_by = "check: "


class AnswerText(Source):
    """An answer's text, every character at its place; what says nothing to check is blank."""

    what, error = "answer", AnswerError

    @classmethod
    def of(cls, text: str) -> Self:
        plain = super().of(text)
        return cls(_DETERMINANT.sub(_as_name, _ARGUMENTS.sub(_alone, plain.text)))


def _alone(match: re.Match[str]) -> str:
    """The quantity, and blanks in place of its arguments."""
    return match[1] + " " * len(match[2])


def _as_name(match: re.Match[str]) -> str:
    """The determinant of the Jacobian by the name that it has here, and as long as it was."""
    return "detJ".ljust(len(match[0]))
