"""Checks of a formula as a relation between quantities."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from freebody.errors import UnknownNameError
from freebody.lazy import cached_property
from freebody_notes.checks.calls import ARM, made, source
from freebody_notes.checks.evidence import sentence, told
from freebody_notes.item import Outcome, parts
from freebody_textbook.relations.formula import FormulaError, as_printed
from freebody_textbook.relations.formula_values import Each, plain, rank
from freebody_textbook.relations.quantities import Quantities, of_link
from freebody_textbook.relations.relation import relation

SHORT = 70
"""Letters of an equation that stands before its evidence."""

NOTHING = Outcome(False, ("Nothing is printed here.",))

_OWN_AXES = re.compile(r"(omega|v|vc|sc|f|n|fc|nc)_?[\dihk]")


@dataclass(frozen=True)
class Related:
    """Check of a formula as a relation between quantities; `values` is the call that gives them, or
    a function without arguments.

    links: the form holds for link i, and is tried at each of these. also: a further relation that
    has to hold, which proves the form in another way, such as by differentiation.
    """

    values: str | Callable[[], Mapping[str, Any]] = f"fb.quantities({ARM})"
    links: tuple[int, ...] = ()
    also: str = ""
    calls: str = ""
    """The call that gives the values, where their function holds more than that."""

    @cached_property
    def _values(self) -> Mapping[str, Any]:
        return made(self.values) if isinstance(self.values, str) else self.values()

    @property
    def bold(self) -> Collection[str]:
        values = of_link(self._values, self.links[0]) if self.links else self._values
        return vectors(values)

    @property
    def primed(self) -> Collection[str]:
        """Names of vectors of a spatial model that have components in the axes of their own
        body."""
        if not isinstance(self._values, Quantities) or self._values.layout.symbols.model.dim == 2:
            return ()
        return frozenset(name for name in self.bold if _OWN_AXES.match(name))

    def call(self, form: str) -> str:
        if isinstance(self.values, str):
            values, first = self.values, []
        else:
            values = "values" if self.calls else f"{self.values.__name__}()"
            first = [f"values = {self.calls}" if self.calls else source(self.values), ""]
        whole = [*parts(form), *parts(self.also)]
        if not self.links:
            return "\n".join([*first, *(f"fb.relation({values}, {part!r})" for part in whole)])
        lines = [f"    fb.relation({values}, {part!r}, link=i)" for part in whole]
        return "\n".join([*first, f"for i in {self.links}:", *lines])

    def run(self, form: str) -> Outcome:
        if not parts(form):
            return NOTHING
        whole = [*parts(form), *parts(self.also)]
        outcomes = [self._named(part, len(whole) > 1 and not self.links) for part in whole]
        chosen = [outcome for outcome in outcomes if not outcome.holds] or outcomes
        return Outcome(
            all(outcome.holds for outcome in outcomes),
            tuple(dict.fromkeys(line for outcome in chosen for line in outcome.lines)),
            next((outcome.example for outcome in chosen if outcome.example), ""),
        )

    def _named(self, form: str, one_of_many: bool) -> Outcome:
        """The outcome of one equation; one_of_many: its lines name the equation."""
        outcome = self._one(form)
        name = str(as_printed(form, self.bold, self.primed)) if one_of_many else ""
        if not one_of_many or len(name) > SHORT:
            return outcome
        first, *rest = outcome.lines
        return Outcome(outcome.holds, (f"{name}: {_inside(first)}", *rest), outcome.example)

    def _one(self, form: str) -> Outcome:
        values = self._values
        for n in self.links or (None,):
            try:
                found = relation(values, form, link=n)
            except UnknownNameError as problem:
                missing = str(problem).split(".")[0]
                return Outcome(False, (f"{sentence(missing)} It is used but not defined.",))
            except FormulaError as problem:
                return Outcome(False, (f"‘{form}’ cannot be read: {problem.problem}",))
            outcome = told(found, values)
            if not outcome.holds:
                return (
                    outcome
                    if not n
                    else Outcome(
                        False, (_for(f"{n}", outcome.lines[0]), *outcome.lines[1:]), outcome.example
                    )
                )
        if self.links:
            return Outcome(True, (_for(_listed(self.links), outcome.lines[0]), *outcome.lines[1:]))
        return outcome


def vectors(values: Mapping[str, Any]) -> Collection[str]:
    """Names of vectors and matrices among the values, including those given for each of several
    bodies."""
    made_plain = {name: plain(x) for name, x in values.items()}
    return frozenset(
        name for name, x in made_plain.items() if rank(x[0] if isinstance(x, Each) else x)
    )


def _for(links: str, line: str) -> str:
    return f"For i = {links}, {_inside(line)}"


def _inside(line: str) -> str:
    """A sentence with its first letter in lower case, to follow a colon or comma."""
    return f"{line[0].lower()}{line[1:]}"


def _listed(numbers: tuple[int, ...]) -> str:
    return ", ".join(map(str, numbers))
