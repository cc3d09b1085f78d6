"""Terms of equations of motion: the step that explains each, and the derivative of the energies
from which it comes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import TypeGuard

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.evaluate import NoValue, Rules, arithmetic, evaluate
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.nodes import Function, Negative, Product, Sourced, Sum, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.model.drives import LAWS
from freebody.scalars.generators import sign_of
from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.first_kind import is_multiplier
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods.setting import Setting

_MANY = 12
"""Terms up to which each has a row of its own."""


_MovingFactors = tuple[str, ...]
"""The rates, accelerations and other such factors of a product, sorted."""


TIME, KINETIC, POTENTIAL, SEVERAL = "time", "kinetic", "potential", "several"
"""Sources: d/dt ∂L/∂q̇, ∂T/∂q, ∂V/∂q, and more than one of them."""


@dataclass(frozen=True)
class TermKind:
    """A kind of term in equations of motion: its name, and its description in singular and plural;
    {here} stands for the equation's joint, {others} for the term's origin."""

    name: str
    one: str
    all: str
    when: str = ""
    """Words on when such terms occur; "" for terms that always do."""


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
LAWS_OF_DRIVES = {
    law.name: TermKind(
        law.term,
        f"{law.term} of {{here}}",
        f"{law.term}s" if law.energy is not None else law.term,
        "move" if law.only_moving else "",
    )
    for law in LAWS.values()
}
CLOSING = TermKind(
    "closing forces", "what the closing forces take at {here}", "what the closing forces take"
)
_ORDER = (
    INERTIA, COUPLING, CENTRIFUGAL, CORIOLIS, GYROSCOPIC, RATES, WEIGHT, WEIGHTS,
    *LAWS_OF_DRIVES.values(), CLOSING,
)  # fmt: skip


@dataclass(frozen=True)
class Term:
    """A term in the equation of coordinate i: printed form, kind, the joints or bodies of its
    origin, and the symbol in front of its rates."""

    shown: Expression
    kind: TermKind
    here: str
    others: tuple[str, ...]
    symbol: Expression

    @property
    def words(self) -> str:
        """Description of the term in words."""
        return self.kind.one.format(here=self.here, others=listed(self.others))


def term_meanings(s: Setting, closed: Step) -> list[Step]:
    """Step: the meaning of the closed form's terms, one by one, or by kind if there are many; none
    if no equations are printed."""
    equations = closed.equations
    if not equations:
        return []
    found = _PrintedTerms(s, equations)
    terms = [
        term for i, line in enumerate(equations[: len(s.leaders)]) for term in found.of(i, line)
    ]
    if not terms:
        return []
    each = [Meaning((x.shown,), x.words, "") for x in terms]
    rows = tuple(each if len(each) <= _MANY else _by_kind(terms))
    return [Step("What each term means", _reason(terms), terms=rows)]


def _by_kind(terms: Iterable[Term]) -> Iterator[Meaning]:
    """Glossary rows for the symbols of each kind of term; a symbol of several terms gets all
    meanings."""
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


class _PrintedTerms:
    """Terms of printed equations, classified by the symbols they contain."""

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
                kind, others = self._law(i, part) if part in drives else self._kind(i, part)
                yield self._term(i, part, term, kind, others)

    def _law(self, i: int, part: Expression) -> tuple[TermKind, tuple[str, ...]]:
        """The kind of a drive's term: that of the law which contains it or a similar term."""
        like: list[TermKind] = []
        for name, torque in self.s.equations.law_torques(i).items():
            form, kind = self.s.layout.form(torque), LAWS_OF_DRIVES[name]
            if part in _terms(form):
                return kind, ()
            if set(_patterns(part, self.names)) & set(_patterns(form, self.names)):
                like.append(kind)
        return like[0], ()

    def _term(
        self, i: int, part: Expression, term: Expression, kind: TermKind, others: tuple[str, ...]
    ) -> Term:
        return Term(part, kind, self._joint(i), others, _symbol(term))

    def _joint(self, i: int) -> str:
        s = self.s
        what = "body" if s.symbols.turned else "joint"
        return f"{what} {s.numbers[s.leaders[i]]}"

    def _kind(self, i: int, part: Expression) -> tuple[TermKind, tuple[str, ...]]:
        found = sorted(_patterns(part, self.names))
        names = found[0] if found else ()
        second = self._places(names, SECOND)
        if second:
            return (INERTIA, ()) if second == [i] else (COUPLING, self._joints(second))
        if any(is_multiplier(name) for name in names) or not found:
            return CLOSING, ()
        if names:
            return self._kind_by_rates(names)
        return self._kind_by_weights(part)

    def _places(self, names: Collection[str], dots: str) -> list[int]:
        """Indices of coordinates whose rates (or accelerations) are among the names."""
        return [k for k, x in enumerate(self.s.symbols.coordinates) if x + dots in names]

    def _kind_by_rates(self, names: Collection[str]) -> tuple[TermKind, tuple[str, ...]]:
        """The kind of a term with rates, and the joints that these belong to."""
        first = self._places(names, RATE)
        if len(names) == 2:
            kind = CENTRIFUGAL if len(first) == 1 else CORIOLIS
            return GYROSCOPIC if self.still else kind, self._joints(first)
        return RATES, self._joints(first)

    def _kind_by_weights(self, part: Expression) -> tuple[TermKind, tuple[str, ...]]:
        """The kind of a term without rates, gravity, and the bodies whose weights it contains."""
        bodies = {self.bodies[x.name]: None for x in nodes(part) if _is_in(x, self.bodies)}
        return (WEIGHT, tuple(bodies)) if bodies else (WEIGHTS, ())

    def _joints(self, places: Iterable[int]) -> tuple[str, ...]:
        return tuple(map(self._joint, places))


def _is_in(x: Expression, names: dict[str, str]) -> TypeGuard[Symbol]:
    return isinstance(x, Symbol) and x.name in names


def _terms(x: Expression) -> tuple[Expression, ...]:
    return x.terms if isinstance(x, ex.Sum) else (x,) if x != ex.ZERO else ()


def _symbol(term: Expression) -> Expression:
    """The coefficient symbol in a term: H₁₂ of H₁₂ θ̈₂."""
    inside = term.operand if isinstance(term, ex.Negative) else term
    factors = inside.factors if isinstance(inside, Product) else (inside,)
    return next((x for x in factors if not isinstance(x, ex.Number)), inside)


class TermSources:
    """Origins of terms: polynomials by the derivative that they are; a printed term comes from
    those that contain its product of rates and accelerations.

    Two of them may hold such a product and cancel in part; then the term is from several.
    """

    def __init__(self, symbols: Symbols, polynomials: Mapping[str, Trig]):
        self._moving = moving(symbols)
        self._sources: dict[_MovingFactors, set[str]] = {}
        for source, polynomial in polynomials.items():
            for powers, _ in polynomial.terms():
                pattern = tuple(
                    name for name in sorted(powers) if name in self._moving
                    for _ in range(powers[name])
                )  # fmt: skip
                self._sources.setdefault(pattern, set()).add(source)

    def marked(self, shown: Expression) -> Expression:
        """An expression with each term marked by its origin; terms of unknown origin are
        unchanged."""
        terms = shown.terms if isinstance(shown, Sum) else (shown,)
        return ex.add(*map(self._marked, terms))

    def _marked(self, term: Expression) -> Expression:
        if isinstance(term, Negative):
            return Negative(self._marked(term.operand))
        found = {
            source
            for pattern in _patterns(term, self._moving)
            for source in self._sources.get(pattern, ())
        }
        if not found & {TIME, KINETIC, POTENTIAL}:
            return term
        return Sourced(term, found.pop() if len(found) == 1 else SEVERAL)


def moving(symbols: Symbols) -> frozenset[str]:
    """Names of rates, accelerations, signs of rates, and symbols that the model itself does not
    have."""
    names = symbols.coordinates
    return frozenset(
        (
            *(x + dots for x in names for dots in (RATE, SECOND)),
            *(sign_of(x + RATE) for x in names),
            *symbols.extra,
        )
    )


def _patterns(term: Expression, names: Collection[str]) -> Collection[_MovingFactors]:
    """The products of the given names in a printed term; empty if it is not a product or sum of
    scalars."""
    nothing: frozenset[_MovingFactors] = frozenset({()})

    def function(
        node: Function, at: Callable[[Expression], Collection[_MovingFactors]]
    ) -> Collection[_MovingFactors]:
        if node.name == "sgn":
            return frozenset((sign_of(name),) for pattern in at(node.argument) for name in pattern)
        return nothing

    rules: Rules = {
        **arithmetic(
            lambda number: nothing,
            total=lambda terms: frozenset().union(*terms),
            product=_product,
            negative=lambda operand: operand,
            quotient=lambda above, below: above,
            power=lambda base, exponent: _product([base] * max(exponent, 0)),
        ),
        Symbol: lambda node, at: frozenset({(node.name,)}) if node.name in names else nothing,
        Function: function,
    }
    try:
        return evaluate(term, rules)
    except NoValue:
        return ()


def _product(factors: Iterable[Collection[_MovingFactors]]) -> Collection[_MovingFactors]:
    def times(
        a: Collection[_MovingFactors], b: Collection[_MovingFactors]
    ) -> Collection[_MovingFactors]:
        return frozenset(tuple(sorted((*x, *y))) for x in a for y in b)

    return reduce(times, factors, frozenset({()}))
