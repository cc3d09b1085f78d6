"""Ways to execute an item: as an answer to be checked, as a relation, against printed digits, by a
function."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import freebody as fb
from freebody.derivations.check.source import AnswerError
from freebody.derivations.formula import FormulaError, as_printed, parse
from freebody.derivations.functions import printed
from freebody.derivations.names import sym
from freebody.derivations.quantities import Quantities, of_link
from freebody.derivations.relation import Relation, agrees, relation
from freebody.derivations.values import Each, plain, rank, value
from freebody.errors import UnknownNameError
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_notes.item import Outcome

ARM = 'fb.planar("RR")'
"""The notes' arm of two links."""


ROUNDING = 1e-12
"""Numbers below are shown as 0."""

_OWN_AXES = re.compile(r"(omega|v|vc|sc|f|n|fc|nc)_?[\dihk]")

NOTHING = Outcome(False, ("Nothing is printed here.",))


def parts(form: str) -> list[str]:
    """The equations of a form, which stand between semicolons."""
    return [part.strip() for part in form.split(";") if part.strip()]


@cache
def made(text: str) -> Any:
    """What a call gives: the text that is shown is the text that is run."""
    return eval(text, {"fb": fb, "np": np})  # the calls are constants of this package


# ---------------------------------------------------------------- as an answer
@dataclass(frozen=True)
class Answer:
    """The form is handed in as a student's answer about a model."""

    model: str = ARM
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return f"fb.check({self.model}, {form!r})"

    def run(self, form: str) -> Outcome:
        try:
            verdict = fb.check(made(self.model), "\n".join(parts(form)))
        except AnswerError as problem:
            return Outcome(False, (_sentence(problem.problem.removeprefix("check: ")),))
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


# ---------------------------------------------------------------- as a relation
@dataclass(frozen=True)
class Related:
    """The form is a relation between quantities; `values` is the call that gives them, or a
    function without arguments.

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
        return _vectors(values)

    @property
    def primed(self) -> Collection[str]:
        """Vectors of a model in space, which have components in the axes of their own body."""
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
        """The outcome of one equation; where there are several, its lines say which."""
        outcome = self._one(form)
        name = str(as_printed(form, self.bold, self.primed)) if one_of_many else ""
        if not one_of_many or len(name) > SHORT:
            return outcome
        first, *rest = outcome.lines
        return Outcome(
            outcome.holds, (f"{name}: {first[0].lower()}{first[1:]}", *rest), outcome.example
        )

    def _one(self, form: str) -> Outcome:
        values = self._values
        for n in self.links or (None,):
            try:
                found = relation(values, form, link=n)
            except UnknownNameError as problem:
                return Outcome(
                    False, (str(problem).split(".")[0] + ": it is used, and defined nowhere.",)
                )
            except FormulaError as problem:
                return Outcome(False, (_sentence(str(problem)),))
            outcome = told(found, values)
            if not outcome.holds:
                return (
                    outcome
                    if not n
                    else Outcome(False, (f"i = {n}:", *outcome.lines), outcome.example)
                )
        if self.links:
            return Outcome(
                True, (f"{outcome.lines[0]} (for i = {_listed(self.links)})", *outcome.lines[1:])
            )
        return outcome


def _vectors(values: Mapping[str, Any]) -> Collection[str]:
    """Names of vectors and matrices, also of those given for each of several bodies."""
    made_plain = {name: plain(x) for name, x in values.items()}
    return frozenset(
        name for name, x in made_plain.items() if rank(x[0] if isinstance(x, Each) else x)
    )


def _listed(numbers: tuple[int, ...]) -> str:
    return ", ".join(map(str, numbers))


LONGEST, MOST_TERMS, SHORT = 160, 24, 70
"""Letters and terms of a value that is shown in a line of evidence; letters of an equation that
stands before it."""


def told(found: Relation, values: Mapping[str, Any]) -> Outcome:
    """A relation in words."""
    if found.problem:
        return Outcome(False, (_sentence(found.problem),))
    if found.equal:
        how = "the same polynomials" if found.exact else "the same numbers"
        return Outcome(True, (f"Both sides are {how}{_shown(found.sides[0], values)}.",))
    difference = tuple(x for x in found.differences if not _nothing(x))
    text = (
        "; ".join(str(form(x, values)) for x in difference)
        if _terms(difference) <= MOST_TERMS
        else ""
    )
    line = "The sides differ" + (f" by {text}" if 0 < len(text) <= LONGEST else "") + "."
    example = found.example()
    if example is None:
        return Outcome(False, (line,), f"{_sides(found.sides)}.")
    at, sides = example
    where = ", ".join(f"{sym(name)} = {number(x)}" for name, x in at.items())
    return Outcome(False, (line,), f"At {where}: {_sides(sides)}.")


def _sentence(text: str) -> str:
    """With a capital in front and a full stop behind."""
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _sides(sides: tuple[Any, ...]) -> str:
    return f"left {number(sides[0])}, right {number(sides[-1])}"


def form(x: Any, values: Mapping[str, Any]) -> Any:
    """A value as it is printed."""
    return values.form(x) if isinstance(values, Quantities) else number(x)


def _nothing(x: Any) -> bool:
    return (
        x.is_zero
        if hasattr(x, "is_zero")
        else bool(np.all(np.abs(np.asarray(x, dtype=float)) < 1e-12))
    )


def _terms(x: Any) -> int:
    """How many terms a value has."""
    if isinstance(x, tuple):
        return sum(map(_terms, x))
    return len(x) if isinstance(x, Trig) else 1


def _shown(side: Any, values: Mapping[str, Any]) -> str:
    if _terms(side) > MOST_TERMS:
        return ""
    text = str(form(side, values))
    return f": {text}" if len(text) <= LONGEST else ""


def number(x: Any, digits: int = 6) -> str:
    """Numbers, vectors and matrices in a line."""
    if isinstance(x, tuple | list | np.ndarray):
        return f"[{', '.join(number(y, digits) for y in x)}]"
    if hasattr(x, "free_symbols"):
        return str(printed(x, decimal=False))
    x = float(x)
    return f"{0.0 if abs(x) < ROUNDING else x:.{digits}g}".replace("-", "−")


# ---------------------------------------------------------------- against printed digits
@dataclass(frozen=True)
class Digits:
    """The left side is computed, the right side are numbers as printed: equal to one unit of their
    last digit."""

    values: Callable[[], Mapping[str, Any]]

    @property
    def bold(self) -> Collection[str]:
        return _vectors(self.values())

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
        line = f"{as_printed(left[0])}: computed {number(computed, 8)}, printed {right.strip()}."
        return Outcome(same and agrees(computed, right), (line,))


# ---------------------------------------------------------------- by a function
@dataclass(frozen=True)
class Run:
    """A function of the form decides."""

    function: Callable[[str], Outcome]
    bold: Collection[str] = ()
    calls: str = ""
    """What a user types to see the same."""

    def call(self, form: str) -> str:
        return f"{self.calls}\n\n{source(self.function)}".lstrip()

    def run(self, form: str) -> Outcome:
        return self.function(form)


# ---------------------------------------------------------------- by reading
@dataclass(frozen=True)
class Reading:
    """Words that nothing executes: the form is held against what has to stand there, for the reason
    given."""

    right: str = ""
    reason: str = ""
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return ""

    def run(self, form: str) -> Outcome:
        return Outcome(form == self.right, (f"Read, not executed: {self.reason}",))


@cache
def source(function: Callable[..., Any]) -> str:
    """The text of a function without its description."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    start = next((k for k, line in enumerate(lines) if line.strip().startswith('"""')), None)
    if start is not None:
        end = start if lines[start].count('"""') == 2 else next(
            k for k in range(start + 1, len(lines)) if '"""' in lines[k]
        )  # fmt: skip
        lines = lines[:start] + lines[end + 1 :]
    return "\n".join(
        line.replace("  # fmt: skip", "") for line in lines if not line.startswith("@")
    )


SHARED: Mapping[str, Any] = {
    "arm": Related(),
    "answer": Answer(),
    "reading": Reading(),
}
"""Checks that items of all chapters name; `right` and `reason` of a reading stand with the item."""
