"""Checks of a formula as a student's answer about a model, by a function, and of printed digits
against computed ones; and of statements that are read, since they cannot be executed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import freebody as fb
from freebody.outputs.number_text import signed
from freebody_notes.checks.calls import ARM, made, source
from freebody_notes.checks.evidence import number, sentence
from freebody_notes.checks.relation import vectors
from freebody_notes.item import Outcome, parts
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.relations.formula import as_printed, parse
from freebody_textbook.relations.formula_values import value
from freebody_textbook.relations.relation import agrees, relation


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


@dataclass(frozen=True)
class Answer:
    """Check that submits the formula as a student's answer about a model."""

    model: str = ARM
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return f"fb.check({self.model}, {form!r})"

    def run(self, form: str) -> Outcome:
        try:
            verdict = fb.check(made(self.model), "\n".join(parts(form)))
        except AnswerError as problem:
            return Outcome(False, (sentence(problem.problem.removeprefix("check: ")),))
        lines = []
        for equation in verdict.equations:
            lines += [
                *equation.causes,
                *(f"{equation.name}: {x.message}" for x in equation.findings),
            ]
        lines = lines or [
            f"{equation.name}, {equation.title}: equal, term by term."
            for equation in verdict.equations
        ]
        example = next((e.example_text for e in verdict.equations if e.example_text), "")
        example = example.replace("For example, at", "At").replace(
            "yours is", "the printed form gives"
        )
        return Outcome(bool(verdict), tuple(lines), example)


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
