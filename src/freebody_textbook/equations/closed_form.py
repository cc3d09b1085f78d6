"""A model's equations in closed form, matrices and vectors as exact polynomials, with views as in
the notes' (3.20)-(3.27) or fully expanded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol

from freebody.algorithms.crba import crba
from freebody.algorithms.energy import potential_energy
from freebody.errors import FreebodyError
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol, size
from freebody.expressions.naming import motors
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.expressions.polynomials.textbook_form import InTextbookForm, Layout
from freebody.expressions.printed_names import entry, sym
from freebody.lazy import cached_property
from freebody.model.drives import DriveLaw
from freebody.model.tree import Tree, TreeBody
from freebody.scalars.trig import Trig
from freebody.spatial import Vector
from freebody.values import ByValue

SHORT = 700
"""Numbers and symbols that fit on about a page."""
_MOST = 2000
"""Terms of M, c and g that will not fit whatever their form."""


@dataclass(frozen=True, eq=False)
class ClosedForm(InTextbookForm, ByValue):
    """The closed-form equations of a model as exact polynomials in normal form: equal means
    identical."""

    symbols: Symbols

    @cached_property
    def M(self) -> list[list[Trig]]:
        """The mass matrix, rotors included."""
        s = self.symbols
        rows = [s.of_angles([s.element(x) for x in row]) for row in crba(s.tree, s.q)]
        return [list(row) for row in zip(*map(s.of_angles, zip(*rows, strict=True)), strict=True)]

    @cached_property
    def christoffel(self) -> list[list[list[Trig]]]:
        """The Christoffel symbols [i][j][k] = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j - ∂M_jk/∂q_i)."""
        n, names = len(self.symbols.coordinates), self.symbols.coordinates
        slope = [
            [[self.M[i][j].derivative(x) for x in names] if j >= i else [] for j in range(n)]
            for i in range(n)
        ]

        def dM(i: int, j: int, k: int) -> Trig:
            return slope[min(i, j)][max(i, j)][k]

        table: list[list[list[Trig]]] = [
            [[self.symbols.zero()] * n for _ in range(n)] for _ in range(n)
        ]
        for i in range(n):
            for j in range(n):
                for k in range(j, n):
                    value = (dM(i, j, k) + dM(i, k, j) - dM(j, k, i)) * 0.5
                    table[i][j][k] = table[i][k][j] = value
        return table

    @cached_property
    def C(self) -> list[list[Trig]]:
        """Coriolis matrix of Christoffel symbols: C q̇ = c and Ṁ - 2C is skew-symmetric."""
        return [[self._along_rates(row) for row in plane] for plane in self.christoffel]

    @cached_property
    def c(self) -> list[Trig]:
        """Coriolis and centrifugal terms."""
        return [self._along_rates(row) for row in self.C]

    def _along_rates(self, row: Sequence[Trig]) -> Trig:
        return inner(row, self.symbols.own(RATE), self.symbols)

    @cached_property
    def g(self) -> list[Trig]:
        """Gravity terms of the equations."""
        s = self.symbols
        tree = s.tree
        weight = s.element(potential_energy(_without_drives(tree), s.q))
        return [weight.derivative(x) for x in s.coordinates]

    @cached_property
    def drives(self) -> list[Trig]:
        """Torques of friction and springs by coordinate."""
        s = self.symbols
        found = [self.law_torques(k) for k in range(len(s.coordinates))]
        return s.of_angles([sum(laws.values(), s.zero()) for laws in found])

    def law_torques(self, k: int) -> dict[str, Trig]:
        """Torques of the drive laws at coordinate k, by the law's name."""
        s, found = self.symbols, dict[str, Trig]()
        for body in s.tree.bodies:
            if body.drive is not None and body.coordinates.v[0] == k:
                for x in body.drive.laws:
                    own = body.coordinates.ratio * _law_torque(body, x.law, s.q, s.qd)
                    found[x.law.name] = s.element(found.get(x.law.name, s.zero()) + own)
        return found

    @cached_property
    def tau(self) -> list[Trig]:
        """Joint torques M q̈ + c + g + friction and springs."""
        s = self.symbols
        parts = zip(self.M, self.c, self.g, self.drives, strict=True)
        qdd = s.own(SECOND)
        return [c + g + drive + inner(row, qdd, s) for row, c, g, drive in parts]

    @cached_property
    def T(self) -> Trig:
        """Kinetic energy ½ q̇ᵀ M q̇."""
        return self._along_rates(list(map(self._along_rates, self.M))) * 0.5

    @cached_property
    def V(self) -> Trig:
        """Potential energy: gravity, zero at the world's origin, and springs."""
        s = self.symbols
        return s.element(potential_energy(s.tree, s.q))

    # ------------------------------------------------------------ for the reader
    def count(self) -> dict[str, int]:
        """Number of terms of M (upper triangle), c and g, as exact polynomials."""
        return {
            "M": sum(len(x) for i, row in enumerate(self.M) for x in row[i:]),
            "c": sum(map(len, self.c)),
            "g": sum(map(len, self.g)),
        }

    @cached_property
    def is_vast(self) -> bool:
        """Whether the mass matrix alone is too long to read; computed from the tip inward before
        anything else.

        The rows and columns of a chain's last joints are the mass matrix of what they carry, the
        rest held still.
        """
        tree, terms = self.symbols.tree, 0
        for first in reversed(range(len(tree.bodies))):
            M = crba(_from_body(tree, first), self.symbols.q)
            terms = sum(len(x) for i, row in enumerate(M) for x in row[i:] if isinstance(x, Trig))
            if terms > _MOST:
                return True
        return False

    @cached_property
    def is_short(self) -> bool:
        """Whether the equations in the named view fit on about a page."""
        if self.is_vast or sum(self.count().values()) > _MOST:
            return False
        return sum(size(line) for group in named(self, self.layout) for line in group) <= SHORT

    @property
    def length(self) -> str:
        """Text of the number of terms; for very long equations only that they are too long."""
        if self.is_vast:
            return f"M alone has more than {_MOST} terms"
        terms = self.count()
        return (
            f"M has {terms['M']} terms (mass matrix), c {terms['c']} (products of rates) and "
            f"g {terms['g']} (gravity)"
        )


def _from_body(tree: Tree, first: int) -> Tree:
    """A tree of the bodies from index `first` on; bodies whose parent is left out are fixed to the
    base."""
    bodies = (replace(body, parent=max(body.parent - first, -1)) for body in tree.bodies[first:])
    return replace(tree, bodies=tuple(bodies))


def _without_drives(tree: Tree) -> Tree:
    return replace(tree, bodies=tuple(replace(body, drive=None) for body in tree.bodies))


_Group = list[Equation]


@dataclass(frozen=True)
class Letters:
    """Letters of the mass matrix, velocity terms and gravity."""

    M: str
    c: str
    g: str
    terms: str = "vector"
    """One of `TERMS` of a notation; c and g are not asked where they are not written."""

    def apart_from(self, names: Iterable[str]) -> Letters:
        """The letters, replaced where an entry's name would look like one of the given names."""
        written = [x for x in map(sym, names) if isinstance(x, Symbol)]
        counted = {x.letter for x in written if x.low and "".join(x.low).isdigit()}
        alone = {x.letter for x in written if not x.low}
        taken = {"M": counted, "c": counted, "g": counted}
        if self.terms == "coefficients":  # the only one is written without a number
            taken["c"] = counted | alone
        own = {key: getattr(self, key) for key in taken}
        for key, others in taken.items():
            spare = (x for x in _SPARE if x not in others and x not in own.values())
            own[key] = own[key] if own[key] not in others else next(spare)
        return replace(self, **own)


_SPARE = "ABDKUWYZ"
"""Letters in the place of those that a model's parameters have."""
NOTES, STANDARD = Letters("H", "h", "G", "coefficients"), Letters("M", "c", "g")
"""H_ij, h, G_i as in (3.20)-(3.27); or M_ij, c_i, g_i."""


def expanded(equations: ClosedForm, layout: Layout) -> list[_Group]:
    """The equations τ_i = … (or 0 = … without motor) fully expanded."""
    left = motors(equations.symbols.model)
    return [[ex.eq(motor, layout.form(x)) for motor, x in zip(left, equations.tau, strict=True)]]


def in_terms(terms: str) -> Letters:
    """The letters that `Lettering` uses for one of a notation's `TERMS`."""
    return NOTES if terms == NOTES.terms else Letters("H", "velocity", "G", terms)


def named(equations: ClosedForm, layout: Layout, names: Letters = NOTES) -> list[_Group]:
    """The equations of τ_i (or 0) by mass matrix, velocity and gravity terms, and then the
    definitions of these: groups τ, M, velocity, gravity."""
    names = names.apart_from(equations.symbols.ring.names)
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
    """The nonzero entries of a column, with their names."""
    return [(entry(letter, i), x) for i, x in enumerate(column, 1) if not x.is_zero]


def symmetric(
    letter: str, rows: Sequence[Sequence[Trig]], form: Callable[[Trig], Expression]
) -> _Group:
    """The nonzero entries of a symmetric matrix, diagonal first; H12 = H21 is one line."""
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
    """Printed terms of the torque τ_i."""
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
    """Velocity terms in a printed form of some notation."""

    def __init__(self, equations: ClosedForm, names: Letters): ...

    def terms(self, i: int) -> Iterator[Expression]:
        """The velocity terms in τ_i."""
        ...

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        """Names used in the velocity terms, with their values."""
        ...


class _VelocityVector:
    """Velocity terms as a vector c, which may include gravity, friction and springs."""

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
    """Velocity terms as the Coriolis matrix C of Christoffel symbols times the rates."""

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
    """Velocity terms by Christoffel symbols, each a multiple of a named coefficient: h, h_1, h_2,
    …, for larger arms h_ijk."""

    equations: ClosedForm
    names: Letters
    found: dict[Trig, tuple[tuple[int, int, int], Trig, Fraction]] = field(default_factory=dict)
    """Christoffel symbols by what is common to their multiples: the indices and value of the first,
    and its factor."""

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
        """The printed name of each Christoffel symbol: h, h_k or h_ijk."""
        n, count, h = len(self.equations.M), len(self.found), self.names.c
        if count == 1:
            return {key: Symbol(h, h) for key in self.found}
        if count <= max(3, n):
            return {key: entry(h, k) for k, key in enumerate(self.found, 1)}
        return {key: entry(h, *(x + 1 for x in first)) for key, (first, _, _) in self.found.items()}

    def definitions(self) -> list[tuple[Symbol, Trig]]:
        """Definitions of the coefficients: (symbol, value)."""
        return [(symbol, self.values[key]) for key, symbol in self.symbols.items()]

    @cached_property
    def values(self) -> dict[Trig, Trig]:
        """The named coefficient of each Christoffel symbol: the first multiple found, with a sign
        that makes its first term positive."""
        is_negative = self.equations.layout.is_negative
        return {
            key: -value if is_negative(value) else value
            for key, (_, value, _) in self.found.items()
        }

    def terms(self, i: int) -> Iterator[Expression]:
        """Terms ± factor · h · rates in τ_i."""
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


def require_polynomial_drives(symbols: Symbols) -> None:
    """Raise an error that names a drive law which is not a polynomial."""
    for body in symbols.tree.bodies:
        for x in () if body.drive is None else body.drive.laws:
            _law_torque(body, x.law, symbols.q, symbols.qd)


def _law_torque(body: TreeBody, law: DriveLaw, q: Vector, qd: Vector) -> Any:
    """The torque of a drive law. Raises FreebodyError if it is not a polynomial."""
    assert body.drive is not None
    try:
        if law.losses is not None:
            raise FreebodyError(law.words)
        return body.drive.only(lambda other: other is law).torque(q, qd)
    except FreebodyError:
        raise law.no_closed_form(f" at body {body.name!r}") from None
