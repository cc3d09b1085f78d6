"""Which equations a view shows, in which order: the notes' (3.20)-(3.27) for any arm, or everything
written out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Equation, Expression, Symbol
from freebody.derivations.expressions.printed_names import entry
from freebody.derivations.naming import motors
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.polynomials.textbook_form import Layout
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig

if TYPE_CHECKING:
    from freebody.derivations.equations.closed_form import ClosedForm

Group = list[Equation]


@dataclass(frozen=True)
class Letters:
    """What the quantities are called."""

    M: str
    c: str
    g: str


NOTES, STANDARD = Letters("H", "h", "G"), Letters("M", "c", "g")
NAMES = {"notes": NOTES, "standard": STANDARD}
"""H_ij, h, G_i as in (3.20)-(3.27); or M_ij, c_i, g_i."""


def expanded(equations: ClosedForm, layout: Layout) -> list[Group]:
    """τ_i, or 0 where there is no motor, with everything written out."""
    left = motors(equations.symbols.model)
    return [[ex.eq(motor, layout.form(x)) for motor, x in zip(left, equations.tau, strict=True)]]


def named(equations: ClosedForm, layout: Layout, names: Letters = NOTES) -> list[Group]:
    """τ_i, or 0, by mass matrix, velocity and gravity terms, then what these are: groups τ, M,
    velocity, gravity."""
    velocity = _Coefficients(equations) if names.c == "h" else None
    torques = [
        ex.eq(motor, ex.add(*_torque(equations, layout, names, velocity, i)))
        for i, motor in enumerate(motors(equations.symbols.model))
    ]
    terms = velocity.definitions() if velocity else _entries(names.c, equations.c)
    found = (
        [ex.eq(symbol, layout.form(value)) for symbol, value in rows]
        for rows in (terms, _entries(names.g, equations.g))
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
    equations: ClosedForm, layout: Layout, names: Letters, velocity: _Coefficients | None, i: int
) -> Iterator[Expression]:
    """The terms of τ_i."""
    coordinates = equations.symbols.coordinates
    for j, x in enumerate(coordinates):
        if not equations.M[i][j].is_zero:
            yield ex.mul(entry(names.M, i + 1, j + 1), x + SECOND)
    if velocity is not None:
        yield from velocity.terms(i)
    elif not equations.c[i].is_zero:
        yield entry(names.c, i + 1)
    if not equations.g[i].is_zero:
        yield entry(names.g, i + 1)
    yield layout.form(equations.drives[i])


@dataclass
class _Coefficients:
    """Christoffel symbols, each a multiple of a named one: h, or h_1, h_2, …, in larger arms
    h_ijk."""

    equations: ClosedForm
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
