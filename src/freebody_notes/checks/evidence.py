"""Findings of a check in words, for the lines below a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from freebody.expressions.printed_names import sym
from freebody.outputs.number_text import shortest
from freebody.scalars.composed import Composed
from freebody.scalars.trig import Trig
from freebody_notes.item import Outcome
from freebody_textbook.relations.functions import printed
from freebody_textbook.relations.quantities import Quantities
from freebody_textbook.relations.relation import Relation

ROUNDING = 1e-12
"""Numbers below are shown as 0."""

LONGEST, MOST_TERMS = 160, 24
"""Letters and terms of a value that is shown in a line of evidence."""


def told(found: Relation, values: Mapping[str, Any]) -> Outcome:
    """The outcome of a tested relation, with lines in words."""
    if found.problem:
        return Outcome(False, (sentence(found.problem),))
    if found.equal:
        how = "identical as polynomials" if found.exact else "numerically equal"
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


def sentence(text: str) -> str:
    """A text as a sentence, capitalised and ending with a full stop."""
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _sides(sides: tuple[Any, ...]) -> str:
    return f"left {number(sides[0])}, right {number(sides[-1])}"


def form(x: Any, values: Mapping[str, Any]) -> Any:
    """A value in printable form: the expression of a model's quantity, or text of a number."""
    return values.form(x) if isinstance(values, Quantities) else number(x)


def _nothing(x: Any) -> bool:
    return (
        x.is_zero
        if hasattr(x, "is_zero")
        else bool(np.all(np.abs(np.asarray(x, dtype=float)) < 1e-12))
    )


def _terms(x: Any) -> int:
    """The number of terms of a value."""
    if isinstance(x, tuple):
        return sum(map(_terms, x))
    return len(x) if isinstance(x, Trig) else 1


def _shown(side: Any, values: Mapping[str, Any]) -> str:
    if _terms(side) > MOST_TERMS:
        return ""
    text = str(form(side, values))
    return f": {text}" if len(text) <= LONGEST else ""


def number(x: Any, digits: int = 6) -> str:
    """Numbers, vectors and matrices as text on one line."""
    if isinstance(x, tuple | list | np.ndarray):
        return f"[{', '.join(number(y, digits) for y in x)}]"
    if isinstance(x, Composed):
        return str(printed(x, decimal=False))
    return shortest(0.0 if abs(float(x)) < ROUNDING else float(x), digits)
