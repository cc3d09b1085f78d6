"""Checks of a formula by a function."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

from freebody_notes.checks.calls import source
from freebody_notes.item import Outcome


@dataclass(frozen=True)
class ByFunction:
    """Check by a function of the formula, which returns the outcome."""

    function: Callable[[str], Outcome]
    bold: Collection[str] = ()
    calls: str = ""
    """Calls that a user types to see the same result."""

    def call(self, form: str) -> str:
        return f"{self.calls}\n\n{source(self.function)}".lstrip()

    def run(self, form: str) -> Outcome:
        return self.function(form)
