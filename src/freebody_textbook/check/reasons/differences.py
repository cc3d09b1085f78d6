"""Comparison of polynomials: split by their moving factors, and term by term with sines and cosines
of sums of angles, so that each difference occurs once."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from fractions import Fraction

from freebody.expressions.expression import Expression, mul
from freebody.expressions.polynomials.angle_sums import (
    SymbolPowers,
    TrigProduct,
    TrigTerms,
    gathered,
    raw,
)
from freebody.expressions.polynomials.arithmetic import collected
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.scalars.generators import WAVES, function_of, waves_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.right_equations import RightEquations

Parts = dict[SymbolPowers, Trig]
"""Polynomials in the parameters, by the products of coordinates and rates with which they stand."""


def moving(setting: RightEquations) -> frozenset[str]:
    """Ring generators that change with time."""
    names = setting.symbols.coordinates
    waves = (wave for name in names for wave in waves_of(name))
    return frozenset([*setting.order.moving, *names, *waves])


def parts(setting: RightEquations, x: Trig, names: Collection[str] | None = None) -> Parts:
    """A polynomial split by its products of certain generators; by default all that change with
    time."""
    return collected(x, moving(setting) if names is None else names)


def whole(setting: RightEquations, rows: Parts) -> Trig:
    """The polynomial that is the sum of the given parts."""
    return setting.ring.polynomial(
        ({**powers, **dict(key)}, coefficient)
        for key, part in rows.items()
        for powers, coefficient in part.terms()
    )


MOST_TERMS = 20_000

ProductKey = tuple[SymbolPowers, TrigProduct]
"""A product of symbols, and a sine or cosine."""


@dataclass(frozen=True)
class Difference:
    """A term whose coefficient differs between the answer and the correct one; `instead`: the term
    that it replaces."""

    key: ProductKey
    yours: Fraction
    right: Fraction
    instead: ProductKey | None = None

    @property
    def names(self) -> set[str]:
        """Symbols in a term, including those of its angles."""
        monomial, wave = self.key
        return {x for x, _ in monomial} | {x for _, angle, _ in wave for x, _ in angle}


def terms(setting: RightEquations, x: Trig) -> TrigTerms:
    """The terms of a polynomial, with symbols' powers in a fixed order."""
    rows = gathered(raw(x), setting.ring.angles, setting.order.blocks)
    return {(tuple(sorted(m)), w): c for (m, w), c in rows.items()}


def is_too_long(x: Trig) -> bool:
    """Whether a polynomial may have too many terms for a comparison term by term."""
    waves = [name for name in x.ring.index if function_of(name) in WAVES]
    return (
        sum(math.prod(p.get(name, 0) + 1 for name in waves if name in p) for p, _ in x.terms())
        > MOST_TERMS
    )


def differences(setting: RightEquations, yours: Trig, right: Trig) -> list[Difference]:
    """The terms in which two polynomials differ; an extra and a missing term that differ by one
    symbol or angle are paired."""
    a, b = terms(setting, yours), terms(setting, right)
    rows = [
        Difference(key, a.get(key, Fraction(0)), b.get(key, Fraction(0)))
        for key in dict.fromkeys((*b, *a))
        if a.get(key, 0) != b.get(key, 0)
    ]
    return list(_paired(rows))


def _paired(rows: list[Difference]) -> Iterator[Difference]:
    extra = [row for row in rows if row.right == 0]
    for row in rows:
        if row.right == 0:
            continue
        partner = None
        if row.yours == 0:
            partner = next(
                (x for x in extra if abs(x.yours) == abs(row.right) and _alike(x.key, row.key)),
                None,
            )
        if partner is None:
            yield row
        else:
            extra.remove(partner)
            yield Difference(row.key, partner.yours, row.right, partner.key)
    yield from extra


def _alike(a: ProductKey, b: ProductKey) -> bool:
    """Whether two terms differ in only one symbol, or only in sine or cosine."""
    if a[0] == b[0]:
        return True
    first, second = _letters(a[0]), _letters(b[0])
    for name in list(first):
        if name in second:
            first.remove(name)
            second.remove(name)
    return a[1] == b[1] and len(first) <= 1 and len(second) <= 1


def _letters(monomial: SymbolPowers) -> list[str]:
    return [name for name, exponent in monomial for _ in range(exponent)]


def printed(
    layout: Layout, setting: RightEquations, key: ProductKey, value: Fraction
) -> Expression:
    """Printed form of a term with its coefficient."""
    return mul(layout.form(polynomial(setting, key, value)))


def polynomial(setting: RightEquations, key: ProductKey, value: Fraction) -> Trig:
    """Polynomial of one term with its coefficient."""
    monomial, wave = key
    x = setting.ring.polynomial([(dict(monomial), value)])
    for function, argument, exponent in wave:
        angle = sum((setting.ring[name] * k for name, k in argument), setting.zero)
        factor = angle.sin() if function == "sin" else angle.cos()
        for _ in range(exponent):
            x = x * factor
    return x
