"""Checks of statements that cannot be executed."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from freebody_notes.item import Outcome


@dataclass(frozen=True)
class ByReading:
    """Check of a statement that cannot be executed: it is compared with the expected text, for the
    given reason."""

    right: str = ""
    reason: str = ""
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return ""

    def run(self, form: str) -> Outcome:
        return Outcome(form == self.right, (f"Read, not executed: {self.reason}",))
