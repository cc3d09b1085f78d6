"""Words that are read."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from freebody_notes.item import Outcome


@dataclass(frozen=True)
class ByReading:
    """Words that nothing executes: the form is held against what has to stand there, for the reason
    given."""

    right: str = ""
    reason: str = ""
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return ""

    def run(self, form: str) -> Outcome:
        return Outcome(form == self.right, (f"Read, not executed: {self.reason}",))
