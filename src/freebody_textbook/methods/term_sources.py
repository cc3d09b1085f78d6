"""Which derivative of the energies each term of an equation came from."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import reduce

from freebody.expressions import expression as ex
from freebody.expressions.evaluate import NoValue, Rules, arithmetic, evaluate
from freebody.expressions.nodes import Expression, Function, Negative, Sourced, Sum, Symbol
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.scalars.trig import Trig

Pattern = tuple[str, ...]
"""The rates, accelerations and other such factors of a product, sorted."""

TIME, KINETIC, POTENTIAL, SEVERAL = "time", "kinetic", "potential", "several"
"""Sources: d/dt ∂L/∂q̇, ∂T/∂q, ∂V/∂q, and more than one of them."""


class TermSources:
    """Polynomials by what they are derivatives of; a printed term is from those that hold its
    products of rates and accelerations.

    Two of them may hold such a product and cancel in part; then the term is from several.
    """

    def __init__(self, symbols: Symbols, polynomials: Mapping[str, Trig]):
        self._moving = moving(symbols)
        self._sources: dict[Pattern, set[str]] = {}
        for source, polynomial in polynomials.items():
            for powers, _ in polynomial.terms():
                pattern = tuple(
                    name for name in sorted(powers) if name in self._moving
                    for _ in range(powers[name])
                )  # fmt: skip
                self._sources.setdefault(pattern, set()).add(source)

    def marked(self, shown: Expression) -> Expression:
        """An expression with its terms marked; those from elsewhere stay as they are."""
        terms = shown.terms if isinstance(shown, Sum) else (shown,)
        return ex.add(*map(self._marked, terms))

    def _marked(self, term: Expression) -> Expression:
        if isinstance(term, Negative):
            return Negative(self._marked(term.operand))
        found = {
            source
            for pattern in patterns(term, self._moving)
            for source in self._sources.get(pattern, ())
        }
        if not found & {TIME, KINETIC, POTENTIAL}:
            return term
        return Sourced(term, found.pop() if len(found) == 1 else SEVERAL)


def moving(symbols: Symbols) -> frozenset[str]:
    """Names of rates, accelerations, signs of rates, and of what the model itself does not hold."""
    names = symbols.coordinates
    return frozenset(
        (
            *(x + dots for x in names for dots in (RATE, SECOND)),
            *(f"sgn_{x}{RATE}" for x in names),
            *symbols.extra,
        )
    )


def patterns(term: Expression, names: Collection[str]) -> Collection[Pattern]:
    """The products of these names that occur in a printed term; none where it is no product or sum
    of scalars."""
    nothing: frozenset[Pattern] = frozenset({()})

    def function(
        node: Function, at: Callable[[Expression], Collection[Pattern]]
    ) -> Collection[Pattern]:
        if node.name == "sgn":
            return frozenset((f"sgn_{name}",) for pattern in at(node.argument) for name in pattern)
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


def _product(factors: Iterable[Collection[Pattern]]) -> Collection[Pattern]:
    def times(a: Collection[Pattern], b: Collection[Pattern]) -> Collection[Pattern]:
        return frozenset(tuple(sorted((*x, *y))) for x in a for y in b)

    return reduce(times, factors, frozenset({()}))
