"""Vectors of mechanics in textbook form: by masses, lengths that move, and rotating directions.

A velocity, acceleration or force is -l₁ (θ̈₁ sin θ₁ + θ̇₁² cos θ₁) - lc₂ (…): terms are grouped by
mass, then by the length that moves, then by its direction; squares of sums of rates stay together.
A vector of the plane is also a sum of parts along directions: (-l₁ θ̇₁ sin θ₁, l₁ θ̇₁ cos θ₁) is l₁
θ̇₁ across the direction θ₁.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.angle_sums import (
    SymbolPowers,
    TrigProduct,
    TrigTerms,
    gathered,
    raw,
)
from freebody.expressions.polynomials.textbook_form import (
    Layout,
    Poly,
    function,
    product_rank,
    starts_with_minus,
)
from freebody.scalars.trig import Trig

Inner = dict[tuple[SymbolPowers, TrigProduct], Fraction]
"""Coefficients of products of rates times a direction."""

_UNITS = tuple(ex.num(sign, decimal) for sign in (1, -1) for decimal in (False, True))


def by_lengths(layout: Layout, x: Trig) -> Expression:
    """A polynomial printed by masses, lengths and directions."""
    groups = layout.by_inertia(raw(x))
    return ex.add(*(_times_mass(layout, name, terms) for name, terms in groups.items()))


def _times_mass(layout: Layout, name: str, terms: TrigTerms) -> Expression:
    """Terms printed as mass · Σ length · (…)."""
    parts = ex.add(
        *(_moved(layout, lengths, inner) for lengths, inner in _by_length(layout, terms))
    )
    if not name:
        return parts
    if isinstance(parts, ex.Sum) and all(isinstance(term, ex.Negative) for term in parts.terms):
        return ex.neg(ex.mul(layout.symbol(name), ex.neg_each(parts)))
    return ex.mul(layout.symbol(name), parts)


def _by_length(layout: Layout, terms: TrigTerms) -> list[tuple[Poly, Inner]]:
    """Terms grouped as (lengths, motion): lengths with the same motion are added."""
    inner: defaultdict[SymbolPowers, Inner] = defaultdict(dict)
    for (monomial, wave), coefficient in terms.items():
        still = tuple((n, e) for n, e in monomial if n not in layout.order.moving)
        rates = tuple((n, e) for n, e in monomial if n in layout.order.moving)
        inner[still][rates, wave] = coefficient
    rows: dict[frozenset, tuple[Poly, Inner]] = {}
    for still in sorted(inner, key=layout.monomial_rank):
        motion = inner[still]
        first = motion[min(motion, key=lambda key: _rank(layout, key))]
        content = abs(layout.content(motion)) * (1 if first > 0 else -1)
        alike = {key: value / content for key, value in motion.items()}
        lengths, _ = rows.setdefault(frozenset(alike.items()), ({}, alike))
        lengths[still] = content
    return list(rows.values())


def _rank(layout: Layout, key: tuple[SymbolPowers, TrigProduct]) -> tuple:
    """Sort key: accelerations before products of velocities, then by direction."""
    rates, wave = key
    return layout.rate_rank(rates), product_rank(wave, layout.order.angles)


def _moved(layout: Layout, lengths: Poly, inner: Inner) -> Expression:
    """Printed product lengths · Σ rates · direction."""
    directions: defaultdict[TrigProduct, Poly] = defaultdict(dict)
    for rates, wave in sorted(inner, key=lambda key: _rank(layout, key)):
        directions[wave][rates] = inner[rates, wave]
    motion = ex.add(
        *(layout.scaled(poly, [function(*f) for f in wave]) for wave, poly in directions.items())
    )
    front = layout.scaled(lengths, [])
    if starts_with_minus(front):
        return ex.neg(ex.mul(ex.neg_each(front), motion))
    if front in _UNITS and isinstance(motion, ex.Sum):
        return ex.neg_each(motion) if isinstance(front, ex.Negative) else motion
    if motion == ex.ONE and isinstance(front, ex.Negative):
        return ex.neg_each(front.operand)
    return ex.mul(front, motion)


@dataclass(frozen=True)
class Directed:
    """A planar vector along · (cos φ, sin φ) + across · (-sin φ, cos φ); angle: φ as multiples of
    coordinates, () for the x axis."""

    angle: SymbolPowers
    along: Trig
    across: Trig

    @property
    def square(self) -> Trig:
        """The squared length of the vector."""
        return self.along * self.along + self.across * self.across


def directed(layout: Layout, vector: Sequence[Trig]) -> list[Directed]:
    """The parts of a planar vector by their angles, inner ones first; empty if it is not a sum of
    such parts."""
    symbols, angles = layout.symbols, layout.order.angles
    parts: defaultdict[SymbolPowers, list[dict[str, Trig]]] = defaultdict(lambda: [{}, {}])
    for k, component in enumerate(vector):
        for (monomial, wave), coefficient in gathered(raw(component), angles, (angles,)).items():
            ((name, angle, exponent),) = wave or (("cos", (), 1),)
            assert exponent == 1, "products were gathered"
            term = symbols.ring.polynomial([(dict(monomial), coefficient)])
            row = parts[angle][k]
            row[name] = row.get(name, symbols.zero()) + term
    found = []
    for angle, (x, y) in parts.items():
        one = _turned(
            angle, *(row.get(f, symbols.zero()) for row in (x, y) for f in ("cos", "sin"))
        )
        if one is None:
            return []
        found.append(one)
    return sorted(found, key=lambda part: len(part.angle))


def _turned(angle: SymbolPowers, xc: Trig, xs: Trig, yc: Trig, ys: Trig) -> Directed | None:
    """The directed part with components xc cos φ + xs sin φ and yc cos φ + ys sin φ."""
    if not angle or (xc == ys and xs == -yc):
        return Directed(angle, xc, yc)
    if xc == -ys and xs == yc:  # it turns the other way
        return Directed(tuple((x, -k) for x, k in angle), xc, yc)
    return None


def _both(one: Directed, other: Directed, names: tuple[str, str]) -> Expression:
    """A product of functions of two vectors' angles, such as cos φ₁ sin φ₂."""
    return ex.mul(*(_wave(f, x.angle) for f, x in zip(names, (one, other), strict=True)))


def _wave(name: str, angle: SymbolPowers) -> Expression:
    if not angle:
        return ex.ONE if name == "cos" else ex.ZERO
    return function(name, angle, 1)


def cosine(one: Directed, other: Directed) -> Expression:
    """The expression cos φ₁ cos φ₂ + sin φ₁ sin φ₂, which equals cos(φ₂ - φ₁)."""
    return ex.add(_both(one, other, ("cos", "cos")), _both(one, other, ("sin", "sin")))


def sine(one: Directed, other: Directed) -> Expression:
    """The expression cos φ₁ sin φ₂ - sin φ₁ cos φ₂, which equals sin(φ₂ - φ₁)."""
    return ex.sub(_both(one, other, ("cos", "sin")), _both(one, other, ("sin", "cos")))
