"""Checking an equation between named quantities (`relation`): whether it holds, exactly or up to
rounding, and the difference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.errors import require_kind
from freebody.expressions.expression import Equation
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.lexer import numbers
from freebody.outputs.display import Titled
from freebody.scalars.composed import Composed
from freebody.scalars.trig import Trig
from freebody_textbook.relations.formula import FormulaError, names_in, parse
from freebody_textbook.relations.formula_values import (
    Each,
    FormulaValue,
    minus,
    occurs,
    plain,
    plus,
    rank,
    shape_name,
    typical,
    value,
)
from freebody_textbook.relations.quantities import of_link

ROUNDING = 1e-9
"""A difference of floats that counts as none, relative to the largest number of either side."""
PLACES = 16
"""The number of places at which functions are compared by numbers."""


@dataclass(frozen=True, repr=False)
class Relation(Titled):
    """True when both sides are equal."""

    formula: str
    sides: tuple[FormulaValue, ...]
    """Values of the sides; none where they cannot be formed."""
    equal: bool
    exact: bool
    """Whether both sides are polynomials or exact functions, compared term by term."""
    problem: str = ""
    """Why the sides cannot be compared."""

    def __bool__(self) -> bool:
        return self.equal

    def _title(self) -> str:
        exactly = "as polynomials" if self.exact else "numerically"
        found = f"both sides are equal, {exactly}" if self.equal else "the sides differ"
        return f"Relation {self.formula}: {self.problem or found}"

    @property
    def differences(self) -> list[FormulaValue]:
        """The first side minus the last, entry by entry; zero if the relation holds."""
        return (
            list(_entries(plus(self.sides[0], minus(self.sides[-1])))) if not self.problem else []
        )

    def at(self, values: Mapping[str, float]) -> tuple[Any, ...]:
        """Values of the sides with numbers substituted for the symbols."""
        return tuple(_numbers(side, values) for side in self.sides)

    def example(self) -> tuple[dict[str, float], tuple[Any, ...]] | None:
        """Numbers for the symbols, and the sides' values there; None if the sides contain no
        symbols."""
        rings = [x.ring for side in self.sides for x in _entries(side) if isinstance(x, Trig)]
        if not rings:
            return self._example_of_functions()
        used = [x for side in self.sides for x in _entries(side) if isinstance(x, Trig)]
        numbers = typical([name for name in rings[0].names if any(occurs(name, x) for x in used)])
        return numbers, self.at(numbers)

    def _example_of_functions(self) -> tuple[dict[str, float], tuple[Any, ...]] | None:
        functions = [x for side in self.sides for x in _entries(side) if isinstance(x, Composed)]
        names = sorted({name for x in functions for name in x.variables})
        numbers = {name: 0.5 + k for k, name in enumerate(names)}
        return (numbers, self.at(numbers)) if names else None


def relation(values: Mapping[str, Any], formula: str, *, link: int | None = None) -> Relation:
    """Whether an equation holds between quantities given by name; see `fb.quantities` for those of
    an arm.

    Polynomials are compared exactly, numbers to 1e-9 of the largest. A scalar and a vector are not
    equal, but a vector may be compared with 0.

    Parameters
    ----------
    values
        Scalars, vectors and matrices of numbers or exact polynomials, by name.
    formula
        "f12 + m2*gravity = m2*vc2_d"; see `freebody_textbook.relations.formula`.
    link
        The number that `i` stands for in names such as omega_i, and omega_h, omega_k of the
        previous and the next link.

    Returns
    -------
    Relation
        True where the equation holds, with both sides and, where it does not, the reason.

    Raises
    ------
    FreebodyError
        A text that cannot be read.
    UnknownNameError
        A name without value.
    """
    require_kind("relation", "values", values, Mapping, "a dict of values by name")
    require_kind("relation", "formula", formula, str, "a text")
    node = parse(formula)
    if not isinstance(node, Equation):
        raise FormulaError(f"{formula!r} has no =")
    if link is not None:
        values = of_link(values, link)
    try:
        sides = tuple(plain(value(side, values)) for side in node.sides)
        sides = tuple(_filled(side, sides) for side in sides)
    except FormulaError as problem:
        return Relation(formula, (), False, False, str(problem))
    if len({_shape(side) for side in sides}) > 1:
        names = " and ".join(dict.fromkeys(map(shape_name, sides)))
        return Relation(formula, sides, False, False, f"{names} are never equal")
    entries = [list(_entries(side)) for side in sides]
    found = [
        _compared(a, b, row) for row in entries[1:] for a, b in zip(entries[0], row, strict=True)
    ]
    exact = any(isinstance(x, Trig | Composed) for row in entries for x in row)
    equal = all(equal for equal, _ in found)
    return Relation(formula, sides, equal, exact and all(certain for _, certain in found))


def symbols_of(formula: str) -> list[str]:
    """Names that occur in a formula."""
    return names_in(parse(formula))


def _filled(side: FormulaValue, sides: tuple[FormulaValue, ...]) -> FormulaValue:
    """A side of an equation; a plain 0 becomes a zero vector if another side is a vector."""
    other = max(sides, key=rank)
    return plus(other, minus(other)) if rank(side) == 0 and _is_zero(side) and rank(other) else side


def _is_zero(x: FormulaValue) -> bool:
    return bool(x.is_zero) if hasattr(x, "is_zero") else bool(np.all(np.asarray(x) == 0))


def _shape(x: FormulaValue) -> tuple[int, ...]:
    return (len(x), *_shape(x[0])) if isinstance(x, tuple) and x else ()


def _entries(x: FormulaValue) -> Iterator[FormulaValue]:
    if isinstance(x, tuple):
        for entry in x:
            yield from _entries(entry)
    else:
        yield x


def _compared(a: FormulaValue, b: FormulaValue, scale: list[FormulaValue]) -> tuple[bool, bool]:
    """(whether two scalars are equal, whether this is exact rather than up to rounding).

    A difference of functions that does not become 0 is looked at in places: where it is 0 in all of
    them, the functions are taken as equal, to rounding.
    """
    if not isinstance(a, Composed) and not isinstance(b, Composed):
        return _equal(a, b, scale), True
    a, b = Composed.of(a), Composed.of(b)
    if (a - b).is_zero:
        return True, True
    names = sorted({*a.variables, *b.variables})
    places = np.random.default_rng(0).uniform(0.1, 2.0, (len(names), PLACES))
    at = dict(zip(names, places, strict=True))
    with np.errstate(all="ignore"):
        left, right = (np.broadcast_to(x.evaluate(at), PLACES) for x in (a, b))
    seen = np.isfinite(left) & np.isfinite(right)
    close = np.abs(left - right) <= ROUNDING * np.maximum(1.0, np.abs(left))
    equal = bool(seen.any() and close[seen].all())
    return equal, not equal


def _equal(a: FormulaValue, b: FormulaValue, scale: list[FormulaValue]) -> bool:
    if isinstance(a, Trig) or isinstance(b, Trig):
        return (a - b).is_zero if isinstance(a, Trig) else (b - a).is_zero
    numbers = [x for x in (a, b, *scale) if not isinstance(x, Trig)]
    largest = max(1.0, *(float(np.max(np.abs(np.asarray(x, dtype=float)))) for x in numbers))
    return bool(
        np.all(
            np.abs(np.asarray(a, dtype=float) - np.asarray(b, dtype=float)) <= ROUNDING * largest
        )
    )


def _numbers(side: FormulaValue, values: Mapping[str, float]) -> Any:
    if isinstance(side, tuple):
        return tuple(_numbers(x, values) for x in side)
    return float(side.evaluate(values)) if isinstance(side, Trig | Composed) else float(side)


# ---------------------------------------------------------------- numbers as printed
def printed_numbers(text: str) -> list[tuple[float, float]]:
    """The numbers in a printed result in order, each with one unit of its last digit."""
    found = []
    lexemes = Lexemes.of(text.replace(" ", "").replace("−", "-"))
    for match, figures in numbers(lexemes):
        size = float(match.text)
        negative = match.start > 0 and lexemes[match.start - 1].text == "-"
        found.append((-size if negative else size, float(figures.last)))
    return found


def agrees(computed: Any, text: str) -> bool:
    """Whether computed numbers agree with printed ones, rounded or truncated at the last printed
    digit."""
    flat = np.asarray(computed, dtype=float).ravel()
    rows = printed_numbers(text)
    if len(flat) != len(rows):
        return False
    return all(abs(x - y) < unit * (1 + 1e-9) for x, (y, unit) in zip(flat, rows, strict=True))


__all__ = ["Each", "Relation", "agrees", "printed_numbers", "relation", "symbols_of"]
