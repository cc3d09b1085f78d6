"""The step that says what each term of the equations of motion is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeGuard

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.nodes import Product, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody_textbook.closed_chains.first_kind import MULTIPLIER
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.term_sources import moving, patterns

MANY = 12
"""Terms up to which each has a row of its own."""


@dataclass(frozen=True)
class TermKind:
    """A kind of term: its name; words for one, with {here} for the joint in whose equation it
    stands and {others} for what it comes from, and for all that there are."""

    name: str
    one: str
    all: str
    when: str = ""
    """When such terms are there, of those that are not always."""


INERTIA = TermKind(
    "inertia", "inertia felt at {here}", "inertia felt at a joint that accelerates", "accelerate"
)
COUPLING = TermKind(
    "coupling",
    "coupling: what the acceleration of {others} takes at {here}",
    "coupling: what the acceleration of one joint takes at another",
    "accelerate",
)
CENTRIFUGAL = TermKind(
    "centrifugal",
    "centrifugal, at {here} by the rate of {others}",
    "centrifugal with the square of one rate",
    "move",
)
CORIOLIS = TermKind(
    "Coriolis",
    "Coriolis, at {here} by the rates of {others} together",
    "Coriolis with the rates of two joints",
    "move",
)
GYROSCOPIC = TermKind(
    "gyroscopic", "gyroscopic, at {here} by the rates of {others}", "gyroscopic, by rates", "move"
)
RATES = TermKind(
    "velocity terms", "velocity terms, at {here} by the rate of {others}", "velocity terms", "move"
)
WEIGHT = TermKind("gravity", "gravity: the weight of {others}, at {here}", "gravity: the weights")
WEIGHTS = TermKind("gravity", "gravity, at {here}", "gravity")
VISCOUS = TermKind("viscous friction", "viscous friction of {here}", "viscous friction", "move")
DRY = TermKind("dry friction", "dry friction of {here}", "dry friction", "move")
SPRING = TermKind("spring", "spring of {here}", "springs")
CLOSING = TermKind(
    "closing forces", "what the closing forces take at {here}", "what the closing forces take"
)
_ORDER = (
    INERTIA, COUPLING, CENTRIFUGAL, CORIOLIS, GYROSCOPIC, RATES, WEIGHT, WEIGHTS, VISCOUS, DRY,
    SPRING, CLOSING,
)  # fmt: skip


@dataclass(frozen=True)
class Term:
    """A term of the equation of coordinate i: as printed, its kind, the joints or bodies that it
    comes from, and the symbol that it stands behind in the equation."""

    shown: Expression
    kind: TermKind
    here: str
    others: tuple[str, ...]
    symbol: Expression

    @property
    def words(self) -> str:
        """What it is."""
        return self.kind.one.format(here=self.here, others=listed(self.others))


def term_meanings(s: Setting, closed: Step) -> list[Step]:
    """The terms of the equations of a closed form, one by one or, where there are many, by kind;
    none where it writes no equations."""
    equations = closed.equations
    if not equations:
        return []
    found = _Terms(s, equations)
    terms = [
        term for i, line in enumerate(equations[: len(s.leaders)]) for term in found.of(i, line)
    ]
    if not terms:
        return []
    each = [Meaning((x.shown,), x.words, "") for x in terms]
    rows = tuple(each if len(each) <= MANY else _by_kind(terms))
    return [Step("What each term means", _reason(terms), terms=rows)]


def _by_kind(terms: Iterable[Term]) -> Iterator[Meaning]:
    """A row for the symbols of each kind; of a symbol that stands for several all of these."""
    kinds: dict[Expression, dict[TermKind, None]] = {}
    for term in terms:
        kinds.setdefault(term.symbol, {})[term.kind] = None
    symbols: dict[tuple[TermKind, ...], list[Expression]] = {}
    for symbol, found in kinds.items():
        symbols.setdefault(tuple(sorted(found, key=_ORDER.index)), []).append(symbol)
    for found, those in symbols.items():
        yield Meaning(tuple(those), "; ".join(kind.all for kind in found), "")


def _reason(terms: Iterable[Term]) -> str:
    when: dict[str, dict[str, None]] = {}
    for term in terms:
        if term.kind.when:
            when.setdefault(term.kind.when, {})[term.kind.name] = None
    told = [f"{listed(list(names))} only while joints {verb}" for verb, names in when.items()]
    more = "; ".join(told)
    return "The terms of the equations above by name" + (f": {more}." if more else ".")


class _Terms:
    """The terms of printed equations, by what is in them."""

    def __init__(self, s: Setting, equations: Iterable[Equation]):
        self.s = s
        self.defined = {line.lhs: line.rhs for line in equations if isinstance(line.lhs, Symbol)}
        self.names = moving(s.symbols) | frozenset(
            x.name
            for line in equations
            for x in nodes(line)
            if isinstance(x, Symbol) and x.letter == "λ"
        )
        self.still = all(
            s.symbols.element(x).is_zero for i in s.weighted for x in s.centre_velocity(i)
        )
        self.bodies = {
            name: f"body {body + 1}" for name, (body, _) in s.layout.order.inertial.items()
        }

    def of(self, i: int, line: Equation) -> Iterator[Term]:
        """The terms of the equation of coordinate i."""
        drives = _terms(self.s.layout.form(self.s.equations.drives[i]))
        for term in _terms(line.rhs):
            meant = self.defined.get(term, term) if isinstance(term, Symbol) else term
            for part in _terms(meant):
                yield self._term(i, part, term, part in drives)

    def _term(self, i: int, part: Expression, term: Expression, is_drive: bool) -> Term:
        kind, others = self._kind(i, part, is_drive)
        return Term(part, kind, self._joint(i), others, _symbol(term))

    def _joint(self, i: int) -> str:
        s = self.s
        what = "body" if s.symbols.turned else "joint"
        return f"{what} {s.numbers[s.leaders[i]]}"

    def _kind(self, i: int, part: Expression, is_drive: bool) -> tuple[TermKind, tuple[str, ...]]:
        found = sorted(patterns(part, self.names))
        names = found[0] if found else ()
        coordinates = self.s.symbols.coordinates
        second = [k for k, x in enumerate(coordinates) if x + SECOND in names]
        first = [k for k, x in enumerate(coordinates) if x + RATE in names]
        if second:
            return (INERTIA, ()) if second == [i] else (COUPLING, self._joints(second))
        if any(name.startswith(MULTIPLIER) for name in names) or not found:
            return CLOSING, ()
        if len(names) == 2:
            kind = CENTRIFUGAL if len(first) == 1 else CORIOLIS
            return GYROSCOPIC if self.still else kind, self._joints(first)
        if first:
            return (VISCOUS, ()) if is_drive else (RATES, self._joints(first))
        if names:
            return DRY, ()
        if is_drive:
            return SPRING, ()
        bodies = {self.bodies[x.name]: None for x in nodes(part) if _is_in(x, self.bodies)}
        return (WEIGHT, tuple(bodies)) if bodies else (WEIGHTS, ())

    def _joints(self, places: Iterable[int]) -> tuple[str, ...]:
        return tuple(map(self._joint, places))


def _is_in(x: Expression, names: dict[str, str]) -> TypeGuard[Symbol]:
    return isinstance(x, Symbol) and x.name in names


def _terms(x: Expression) -> tuple[Expression, ...]:
    return x.terms if isinstance(x, ex.Sum) else (x,) if x != ex.ZERO else ()


def _symbol(term: Expression) -> Expression:
    """What stands before the rates: H₁₂ of H₁₂ θ̈₂."""
    inside = term.operand if isinstance(term, ex.Negative) else term
    factors = inside.factors if isinstance(inside, Product) else (inside,)
    return next((x for x in factors if not isinstance(x, ex.Number)), inside)
