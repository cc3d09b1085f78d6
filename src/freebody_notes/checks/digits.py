"""Computed numbers against printed digits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from freebody.outputs.number_text import signed
from freebody_notes.checks.calls import source
from freebody_notes.checks.evidence import number
from freebody_notes.checks.relation import vectors
from freebody_notes.item import Outcome, parts
from freebody_textbook.relations.formula import as_printed, parse
from freebody_textbook.relations.formula_values import value
from freebody_textbook.relations.relation import agrees, relation


@dataclass(frozen=True)
class Digits:
    """Check of computed numbers on the left side against printed numbers on the right, to one unit
    of the last digit."""

    values: Callable[[], Mapping[str, Any]]

    @property
    def bold(self) -> Collection[str]:
        return vectors(self.values())

    def call(self, form: str) -> str:
        left = form.partition("=")[0].strip()
        return f"{source(self.values)}\n\n{self.values.__name__}()[{left!r}]"

    def run(self, form: str) -> Outcome:
        outcomes = [self._one(part) for part in parts(form)]
        return Outcome(
            bool(outcomes) and all(o.holds for o in outcomes),
            tuple(x for o in outcomes for x in o.lines),
        )

    def _one(self, form: str) -> Outcome:
        values = self.values()
        *left, right = form.split("=")
        computed = value(parse(left[0]), values)
        same = len(left) == 1 or bool(relation(values, "=".join(left)))
        shown = signed(right.strip())
        line = f"{as_printed(left[0])}: computed {number(computed, 8)}, printed {shown}."
        return Outcome(same and agrees(computed, right), (line,))
