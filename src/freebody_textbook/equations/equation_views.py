"""Which equations a view shows, in which order: the notes' (3.20)-(3.27) for any arm, or everything
written out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.naming import motors
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import entry
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig

if TYPE_CHECKING:
    from freebody_textbook.equations.closed_form import ClosedForm

Group = list[Equation]


@dataclass(frozen=True)
class Letters:
    """What the quantities are called."""

    M: str
    c: str
    g: str
    terms: str = "vector"
    """One of `TERMS` of a notation; c and g are not asked where they are not written."""


NOTES, STANDARD = Letters("H", "h", "G", "coefficients"), Letters("M", "c", "g")
"""H_ij, h, G_i as in (3.20)-(3.27); or M_ij, c_i, g_i."""


def expanded(equations: ClosedForm, layout: Layout) -> list[Group]:
    """τ_i, or 0 where there is no motor, with everything written out."""
    left = motors(equations.symbols.model)
    return [[ex.eq(motor, layout.form(x)) for motor, x in zip(left, equations.tau, strict=True)]]


def in_terms(terms: str) -> Letters:
    """The letters that `Lettering` knows, for one of a notation's `TERMS`."""
    return NOTES if terms == NOTES.terms else Letters("H", "velocity", "G", terms)


def named(equations: ClosedForm, layout: Layout, names: Letters = NOTES) -> list[Group]:
    """τ_i, or 0, by mass matrix, velocity and gravity terms, then what these are: groups τ, M,
    velocity, gravity."""
    velocity = _TERMS[names.terms](equations, names)
    weights = [] if names.terms == "bias" else _entries(names.g, equations.g)
    torques = [
        ex.eq(motor, ex.add(*_torque(equations, layout, names, velocity, i)))
        for i, motor in enumerate(motors(equations.symbols.model))
    ]
    found = (
        [ex.eq(symbol, layout.form(value)) for symbol, value in rows]
        for rows in (velocity.definitions(), weights)
    )
    groups = [torques, symmetric(names.M, equations.M, layout.form), *found]
    return [group for group in groups if group]


def _entries(letter: str, column: Sequence[Trig]) -> list[tuple[Symbol, Trig]]:
    """Those that are not zero, with their names."""
    return [(entry(letter, i), x) for i, x in enumerate(column, 1) if not x.is_zero]


def symmetric(
    letter: str, rows: Sequence[Sequence[Trig]], form: Callable[[Trig], Expression]
) -> Group:
    """The entries of a symmetric matrix that are not zero, the diagonal first; H12 = H21 is one
    line."""
    n = len(rows)
    pairs = [(i, i) for i in range(n)] + [(i, j) for i in range(n) for j in range(i + 1, n)]
    return [
        ex.chain(entry(letter, i + 1, j + 1), entry(letter, j + 1, i + 1), form(rows[i][j]))
        for i, j in pairs
        if not rows[i][j].is_zero
    ]


def _torque(
    equations: ClosedForm, layout: Layout, names: Letters, velocity: _VelocityTerms, i: int
) -> Iterator[Expression]:
    """The terms of τ_i."""
    coordinates = equations.symbols.coordinates
    for j, x in enumerate(coordinates):
        if not equations.M[i][j].is_zero:
            yield ex.mul(entry(names.M, i + 1, j + 1), x + SECOND)
    yield from velocity.terms(i)
    if names.terms == "bias":
        return
    if not equations.g[i].is_zero:
        yield entry(names.g, i + 1)
    yield layout.form(equations.drives[i])


class _VelocityTerms(Protocol):
    """How the velocity terms are written."""

    def __init__(self, equations: ClosedForm, names: Letters): ...

    def terms(self, i: int) -> Iterator[Expression]:
        """In τ_i."""
        ...

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        """The names in them, and their values."""
        ...


class _VelocityVector:
    """A vector c; or one that holds gravity, friction and springs too."""

    def __init__(self, equations: ClosedForm, names: Letters):
        self.letter, self.values = names.c, equations.c
        if names.terms == "bias":
            parts = zip(equations.c, equations.g, equations.drives, strict=True)
            self.letter, self.values = "bias", [c + g + drive for c, g, drive in parts]

    def terms(self, i: int) -> Iterator[Expression]:
        if not self.values[i].is_zero:
            yield entry(self.letter, i + 1)

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        return _entries(self.letter, self.values)


class _CoriolisMatrix:
    """The matrix C of Christoffel symbols times the rates."""

    def __init__(self, equations: ClosedForm, names: Letters):
        self.rows, self.coordinates = equations.C, equations.symbols.coordinates

    def terms(self, i: int) -> Iterator[Expression]:
        for j, name in enumerate(self.coordinates):
            if not self.rows[i][j].is_zero:
                yield ex.mul(entry("C", i + 1, j + 1), name + RATE)

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        return [
            (entry("C", i, j), x)
            for i, row in enumerate(self.rows, 1)
            for j, x in enumerate(row, 1)
            if not x.is_zero
        ]


@dataclass
class _Coefficients:
    """Christoffel symbols, each a multiple of a named one: h, or h_1, h_2, …, in larger arms
    h_ijk."""

    equations: ClosedForm
    names: Letters
    found: dict[Trig, tuple[tuple[int, int, int], Trig, Fraction]] = field(default_factory=dict)
    """By what is common to its multiples: the indices and value of the first, and its factor."""

    def __post_init__(self) -> None:
        for i in range(len(self.equations.M)):
            for j, k in self._pairs():
                value = self.equations.christoffel[i][j][k]
                if not value.is_zero:
                    lead = value.leading_coefficient
                    self.found.setdefault(value / lead, ((i, j, k), value, lead))

    def _pairs(self) -> list[tuple[int, int]]:
        n = len(self.equations.M)
        return [(j, j) for j in range(n)] + [(j, k) for j in range(n) for k in range(j + 1, n)]

    @cached_property
    def symbols(self) -> dict[Trig, Symbol]:
        """The name of each."""
        n, count = len(self.equations.M), len(self.found)
        if count == 1:
            return {key: Symbol("h", "h") for key in self.found}
        if count <= max(3, n):
            return {key: entry("h", k) for k, key in enumerate(self.found, 1)}
        return {
            key: entry("h", *(x + 1 for x in first)) for key, (first, _, _) in self.found.items()
        }

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        """Name and value."""
        return [(symbol, self.values[key]) for key, symbol in self.symbols.items()]

    @cached_property
    def values(self) -> dict[Trig, Trig]:
        """What each name stands for: the first multiple found, its sign chosen so that it begins
        without a minus."""
        is_negative = self.equations.layout.is_negative
        return {
            key: -value if is_negative(value) else value
            for key, (_, value, _) in self.found.items()
        }

    def terms(self, i: int) -> Iterator[Expression]:
        """± factor · h · rates of τ_i."""
        symbols = self.symbols
        names = self.equations.symbols.coordinates
        for j, k in self._pairs():
            value = self.equations.christoffel[i][j][k]
            if value.is_zero:
                continue
            key = value / value.leading_coefficient
            factor = value.leading_coefficient / self.values[key].leading_coefficient
            number = ex.num(factor if j == k else 2 * factor)
            rates = (
                (ex.power(names[j] + RATE, 2),) if j == k else (names[j] + RATE, names[k] + RATE)
            )
            yield ex.mul(number, symbols[key], *rates)


_TERMS: dict[str, type[_VelocityTerms]] = {
    "coefficients": _Coefficients,
    "vector": _VelocityVector,
    "matrix": _CoriolisMatrix,
    "bias": _VelocityVector,
}
