"""Velocities, accelerations and forces as a book writes them: -l₁ (θ̈₁ sin θ₁ + θ̇₁² cos θ₁) - lc₂
(…).

Terms are grouped by mass, then by the length that moves, then by its direction; squares of sums of
rates stay together.
"""

from __future__ import annotations

from collections import defaultdict
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.angle_sums import Monomial, Terms, Wave, raw
from freebody.expressions.polynomials.textbook_form import (
    Layout,
    Poly,
    function,
    starts_with_minus,
    wave_rank,
)
from freebody.scalars.trig import Trig

Inner = dict[tuple[Monomial, Wave], Fraction]
"""Coefficients of products of rates times a direction."""

_UNITS = tuple(ex.num(sign, decimal) for sign in (1, -1) for decimal in (False, True))


def by_lengths(layout: Layout, x: Trig) -> Expression:
    """A polynomial in the layout described above."""
    groups = layout.by_inertia(raw(x))
    return ex.add(*(_times_mass(layout, name, terms) for name, terms in groups.items()))


def _times_mass(layout: Layout, name: str, terms: Terms) -> Expression:
    """mass · Σ length · (…)."""
    parts = ex.add(
        *(_moved(layout, lengths, inner) for lengths, inner in _by_length(layout, terms))
    )
    if not name:
        return parts
    if isinstance(parts, ex.Sum) and all(isinstance(term, ex.Negative) for term in parts.terms):
        return ex.neg(ex.mul(layout.symbol(name), ex.neg_each(parts)))
    return ex.mul(layout.symbol(name), parts)


def _by_length(layout: Layout, terms: Terms) -> list[tuple[Poly, Inner]]:
    """(lengths, motion): lengths that move alike are added up."""
    inner: defaultdict[Monomial, Inner] = defaultdict(dict)
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


def _rank(layout: Layout, key: tuple[Monomial, Wave]) -> tuple:
    """Accelerations before products of velocities, then by direction."""
    rates, wave = key
    return layout.rate_rank(rates), wave_rank(wave, layout.order.angles)


def _moved(layout: Layout, lengths: Poly, inner: Inner) -> Expression:
    """lengths · Σ rates · direction."""
    directions: defaultdict[Wave, Poly] = defaultdict(dict)
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
