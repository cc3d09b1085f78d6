"""Checks of a formula as a student's answer about a model."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import freebody as fb
from freebody_notes.checks.calls import ARM, made
from freebody_notes.checks.evidence import sentence
from freebody_notes.item import Outcome, parts
from freebody_textbook.check.spelling.answer_text import AnswerError


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
