"""Polynomials as a textbook prints them: m₁ lc₁² + I₁ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂.

Terms are grouped by products of rates, then by mass and moment of inertia in the order of the
bodies; inside a group what is constant stands first, then cosines and sines by their angles. A
group's numbers and common symbols stand in front of it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from freebody.arrays import Array
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.grammar.atoms import undotted
from freebody.expressions.polynomials.angle_sums import (
    Raw,
    SymbolPowers,
    TrigProduct,
    TrigTerms,
    as_products,
    gathered,
    paired,
    raw,
)
from freebody.expressions.polynomials.symbol_order import Order
from freebody.expressions.polynomials.symbols import SECOND, Symbols
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of, symbol_of
from freebody.scalars.trig import Trig

Poly = dict[SymbolPowers, Fraction]
"""A polynomial in symbols without sines and cosines."""

InertiaGroups = dict[str, TrigTerms]
"""Terms by the inertial parameter that they are multiplied with."""


@dataclass(frozen=True)
class Layout:
    """The printed layout of one model's polynomials, which become expressions."""

    symbols: Symbols

    @cached_property
    def order(self) -> Order:
        """The kinds of the model's symbols, and their order in print."""
        return Order(self.symbols)

    def symbol(self, name: str) -> Expression:
        """A generator of the ring as it is printed."""
        return sym(name)

    def form(self, x: Trig) -> Expression:
        """A polynomial in the layout described above."""
        return ex.add(*(term for _, term in self.by_rates(x)))

    def is_negative(self, x: Trig) -> bool:
        """Whether the printed form of a polynomial begins with a minus."""
        form = self.form(x)
        return isinstance(form.terms[0] if isinstance(form, ex.Sum) else form, ex.Negative)

    def by_rates(self, x: Trig) -> list[tuple[SymbolPowers, Expression]]:
        """The printed parts of a polynomial by their product of rates, each with those rates behind
        it."""
        parts: defaultdict[SymbolPowers, Raw] = defaultdict(list)
        for powers, coefficient in raw(x):
            rates = self._sorted((n, e) for n, e in powers.items() if n in self.order.moving)
            parts[rates].append(
                ({n: e for n, e in powers.items() if n not in self.order.moving}, coefficient)
            )
        rows = []
        for rates in sorted(parts, key=self.rate_rank):
            groups = self.by_inertia(parts[rates])
            rows.append((rates, self._times_rates(groups, rates) if rates else self._sum(groups)))
        return rows

    def _times_rates(self, groups: InertiaGroups, rates: SymbolPowers) -> Expression:
        """The expression number · (terms) · rates, from terms grouped by inertia."""
        content = self.content(
            {(((n, 1), *m), w): c for n, terms in groups.items() for (m, w), c in terms.items()}
        )
        coefficient = self._sum(
            {n: {k: c / content for k, c in terms.items()} for n, terms in groups.items()}
        )
        if starts_with_minus(coefficient):
            content, coefficient = -content, ex.neg_each(coefficient)
        return ex.mul(self.order.number(content), coefficient, *self._monomial(rates))

    def rate_rank(self, rates: SymbolPowers) -> tuple:
        """The sort key of a product of rates: accelerations, squares of velocities, products, none,
        single velocities, signs, components of loads."""
        names = [n for n, e in rates for _ in range(e)]
        extra = self.symbols.extra
        if any(n in extra for n in names):
            return 6, [extra.index(n) if n in extra else -1 for n in names]
        order = [self.symbols.coordinates.index(undotted(symbol_of(n))) for n in names]
        if not names:
            kind = 3
        elif function_of(names[0]):
            kind = 5
        elif any(n.endswith(SECOND) for n in names):
            kind = 0
        else:
            kind = 4 if len(names) == 1 else 1 if len(rates) == 1 else 2
        return kind, order

    def by_inertia(self, terms: Raw) -> InertiaGroups:
        """Terms grouped by the mass or moment of inertia in them, in the order of the bodies; terms
        without any are under ""."""
        groups: defaultdict[str, Raw] = defaultdict(list)
        for powers, coefficient in terms:
            name = next((n for n in powers if n in self.order.inertial), "")
            rest = {
                n: e - (n == name) for n, e in powers.items()
            }  # a file may call a length by the mass's name
            groups[name].append(({n: e for n, e in rest.items() if e}, coefficient))
        last = (len(self.symbols.model.bodies), 0)
        order = sorted(groups, key=lambda n: (self.order.inertial.get(n, last), self.order.rank(n)))
        return {name: self._shortest(groups[name]) for name in order}

    def _shortest(self, terms: Raw) -> TrigTerms:
        """The terms in the form with the fewest: with sums of all angles, with sums of angles about
        parallel axes, or with products."""
        angles, blocks = self.order.angles, self.order.blocks
        sums = gathered(terms, angles, (angles,))
        forms = [sums]
        if len(sums) > 1:
            by_axis = sums if len(blocks) == 1 else gathered(terms, angles, blocks)
            forms += [by_axis, paired(by_axis, blocks), as_products(terms, angles)]
        return min(forms, key=len)

    def _sum(self, groups: InertiaGroups) -> Expression:
        return ex.add(*(self._group(name, terms) for name, terms in groups.items()))

    def _group(self, name: str, terms: TrigTerms) -> Expression:
        """The expression inertia · number · common symbols · (the rest), from the terms of one mass
        or moment of inertia."""
        common = self._common(terms)
        content = self.content(terms)
        inside = {(_without(m, common), w): c / content for (m, w), c in terms.items()}
        front = [*([self.symbol(name)] if name else []), *self._monomial(common)]
        rest = self._by_products(inside)
        if isinstance(rest, ex.Sum) and not front:
            if abs(content) == 1:
                return rest if content == 1 else ex.neg_each(rest)
            if self.order.decimal:
                return self._by_products(terms)
        return ex.mul(self.order.number(content), *front, rest)

    def _common(self, terms: TrigTerms) -> SymbolPowers:
        """The symbols that all terms share; none where a term without angles would keep others (lc²
        + l lc cos θ stays)."""
        exponents = [dict(monomial) for monomial, _ in terms]
        shared = {n: min(e.get(n, 0) for e in exponents) for n in exponents[0]}
        common = self._sorted((n, e) for n, e in shared.items() if e)
        constant = [_without(m, common) for m, wave in terms if not wave]
        if len(terms) > 1 and any(constant) and any(wave for _, wave in terms):
            return tuple((n, e) for n, e in common if n == self.order.gravity)
        return common

    def content(self, terms: TrigTerms) -> Fraction:
        """The greatest number that divides all coefficients, with the sign of the first term."""
        first = terms[
            min(
                terms,
                key=lambda key: (
                    product_rank(key[1], self.order.angles),
                    self.monomial_rank(key[0]),
                ),
            )
        ]
        if self.order.decimal:
            alike = all(abs(c) == abs(first) for c in terms.values())
            is_negative = first < 0 if alike else all(c < 0 for c in terms.values())
            return (abs(first) if alike else Fraction(1)) * (-1 if is_negative else 1)
        top = math.gcd(*(c.numerator for c in terms.values()))
        return Fraction(
            top if first > 0 else -top, math.lcm(*(c.denominator for c in terms.values()))
        )

    def _by_products(self, terms: TrigTerms) -> Expression:
        """The expression Σ polynomial · function of angles, terms without angles first."""
        groups: defaultdict[TrigProduct, Poly] = defaultdict(dict)
        for (monomial, wave), coefficient in terms.items():
            groups[wave][monomial] = coefficient
        rows = []
        for wave in sorted(groups, key=lambda w: product_rank(w, self.order.angles)):
            functions = [function(*f) for f in wave]
            rows.append(
                self.poly(groups[wave]) if not wave else self.scaled(groups[wave], functions)
            )
        return ex.add(*rows)

    def scaled(self, poly: Poly, functions: list[Expression]) -> Expression:
        """The expression number · common symbols · (the rest) · functions."""
        flat: TrigTerms = {(m, ()): c for m, c in poly.items()}
        common, content = self._common(flat), self.content(flat)
        rest = self.poly({_without(m, common): c / content for m, c in poly.items()})
        if functions and starts_with_minus(rest):
            content, rest = -content, ex.neg_each(rest)
        return ex.mul(self.order.number(content), *self._monomial(common), rest, *functions)

    # ------------------------------------------------------------ polynomials without angles
    def poly(self, poly: Poly) -> Expression:
        """The expression of a polynomial: by falling degree, with a square completed, or as a
        product, whichever is shortest."""
        forms = [self._plain(poly)]
        if len(poly) > 2:
            square = self._square(poly)
            if square is not None:
                (top, front, value), base, rest = square
                squared = ex.mul(
                    self.order.number(value), *self._monomial(front), ex.power(self.poly(base), 2)
                )
                late = bool(rest) and min(map(self.monomial_rank, rest)) < self.monomial_rank(top)
                parts = [squared, *([self.poly(rest)] if rest else [])]
                forms.append(ex.add(*(reversed(parts) if late else parts)))
        if len(poly) > 3:
            content, factors = self._factors(poly)
            if len(factors) > 1 or factors[0][1] > 1:
                powers = (ex.power(self.poly(factor), exponent) for factor, exponent in factors)
                forms.append(ex.mul(self.order.number(content), *powers))
        return min(forms, key=ex.size)

    def _plain(self, poly: Poly) -> Expression:
        order = sorted(poly, key=self.monomial_rank)
        return ex.add(*(ex.mul(self.order.number(poly[m]), *self._monomial(m)) for m in order))

    def _factors(self, poly: Poly) -> tuple[Fraction, list[tuple[Poly, int]]]:
        """The number and the factors with exponents of a polynomial; coefficients are whole, and
        the first term of each factor is positive."""
        x = self.symbols.ring.polynomial((dict(m), c) for m, c in poly.items())
        content, factors = x.leading_coefficient, []
        for factor, exponent in x.factors():
            terms: Poly = {tuple(powers.items()): c for powers, c in factor.terms()}
            scale = self.content({(m, ()): c for m, c in terms.items()})
            content /= (factor.leading_coefficient / scale) ** exponent
            factors.append(({m: c / scale for m, c in terms.items()}, exponent))
        return content, sorted(factors, key=lambda row: min(map(self.monomial_rank, row[0])))

    def _square(
        self, poly: Poly
    ) -> tuple[tuple[SymbolPowers, SymbolPowers, Fraction], Poly, Poly] | None:
        """The square completed in the first symbol x for which that saves terms: (A x², A / number,
        number), x + b, and the rest of A (x + b)² + rest; None where no symbol does."""
        names = sorted(
            {n for m in poly for n, _ in m},
            key=lambda n: (n not in self.symbols.coordinates, self.order.rank(n)),
        )
        completed = (self._completed(poly, x) for x in names)
        return next((found for found in completed if found is not None), None)

    def _completed(
        self, poly: Poly, x: str
    ) -> tuple[tuple[SymbolPowers, SymbolPowers, Fraction], Poly, Poly] | None:
        """The square completed in the symbol x: (A x², A / number, number), x + b, and the rest of
        A (x + b)² + rest; None where that is impossible or saves no terms."""
        squares = [(m, c) for m, c in poly.items() if dict(m).get(x) == 2]
        if len(squares) != 1 or any(dict(m).get(x, 0) > 2 for m in poly):
            return None
        (top, a) = squares[0]
        front = _without(top, ((x, 2),))
        linear = {m: c for m, c in poly.items() if dict(m).get(x) == 1}
        divisor = self._sorted((*front, (x, 1)))
        if not linear or not all(_divides(divisor, m) for m in linear):
            return None
        base: Poly = {((x, 1),): Fraction(1)} | {
            _without(m, divisor): c / (2 * a) for m, c in linear.items()
        }
        rest = defaultdict(Fraction, poly)
        for m, c in base.items():
            for n, d in base.items():
                rest[self._product(front, m, n)] -= a * c * d
        left = {m: c for m, c in rest.items() if c}
        numbers = [*base.values(), *left.values()]
        printed = not self.order.decimal or all(map(_is_short, numbers))
        return ((top, front, a), base, left) if printed and len(left) + 1 < len(poly) else None

    def _product(self, *monomials: SymbolPowers) -> SymbolPowers:
        total: defaultdict[str, int] = defaultdict(int)
        for monomial in monomials:
            for name, exponent in monomial:
                total[name] += exponent
        ring = self.symbols.ring.index
        return tuple(sorted(total.items(), key=lambda item: ring[item[0]]))

    def _monomial(self, monomial: SymbolPowers) -> list[Expression]:
        return [ex.power(self.symbol(n), e) for n, e in self._sorted(monomial)]

    def monomial_rank(self, monomial: SymbolPowers) -> tuple:
        """The sort key of a monomial: by falling degree, then by its symbols in their order."""
        ranked = [(self.order.rank(n), -e) for n, e in self._sorted(monomial)]
        return -sum(e for _, e in monomial), ranked

    def _sorted(self, monomial: Iterable[tuple[str, int]]) -> SymbolPowers:
        return tuple(sorted(monomial, key=lambda item: self.order.rank(item[0])))


class InTextbookForm:
    """Closed forms of a model in `symbols`: the base of results that can be printed and
    evaluated."""

    symbols: Symbols

    @cached_property
    def layout(self) -> Layout:
        """The printed layout of the model's polynomials: `layout.form(x)` is an expression."""
        return Layout(self.symbols)

    def form(self, x: Trig) -> Expression:
        """A polynomial as it is printed; it has text, LaTeX and MathML of its own."""
        return self.layout.form(x)

    def evaluate(self, quantity: Any, q: Any, qd: Any = None, qdd: Any = None) -> Array:
        """Values of a polynomial, or of lists of polynomials, at q, qd, qdd (..., n), with the
        model's parameter values."""
        return self.symbols.evaluate(quantity, q, qd, qdd)


def starts_with_minus(x: Expression) -> bool:
    """Whether x is a sum whose first term is negative."""
    return isinstance(x, ex.Sum) and isinstance(x.terms[0], ex.Negative)


def _is_short(x: Fraction) -> bool:
    """Whether a fraction has a short decimal, which prints all its digits."""
    return Fraction(f"{float(x):.6g}") == x


def _without(monomial: SymbolPowers, divisor: SymbolPowers) -> SymbolPowers:
    """Quotient of two monomials: monomial / divisor."""
    below = dict(divisor)
    return tuple((n, e - below.get(n, 0)) for n, e in monomial if e > below.get(n, 0))


def _divides(divisor: SymbolPowers, monomial: SymbolPowers) -> bool:
    above = dict(monomial)
    return all(above.get(n, 0) >= e for n, e in divisor)


def product_rank(wave: TrigProduct, angles: tuple[str, ...]) -> tuple:
    """The sort key of a product of functions: few functions first, then few angles, small
    multiples, inner joints, cosines before sines."""
    total = sum(abs(k) * e for _, argument, e in wave for _, k in argument)
    used = sorted(angles.index(x) for _, argument, _ in wave for x, _ in argument)
    signs = [(-k, e, f) for f, argument, e in wave for _, k in argument]
    return len(set(used)), total, used, [f for f, _, _ in wave], signs


def function(name: str, argument: SymbolPowers, exponent: int) -> Expression:
    angle = ex.add(*(ex.mul(k, sym(x)) for x, k in argument))
    return ex.power(ex.Function(name, angle), exponent)
