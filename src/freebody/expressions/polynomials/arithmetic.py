"""Sums of products of polynomials, and polynomials taken apart by some of their symbols."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from fractions import Fraction

from freebody.expressions.polynomials.symbols import Symbols
from freebody.scalars.trig import Trig

Product = tuple[tuple[str, int], ...]
"""Powers of generators, (name, exponent), by name."""


def inner(a: Sequence[Trig], b: Sequence[Trig], s: Symbols) -> Trig:
    """Σ a b."""
    total = s.zero()
    for x, y in zip(a, b, strict=True):
        if not x.is_zero and not y.is_zero:
            total = total + x * y
    return total


def times(A: Sequence[Sequence[Trig]], B: Sequence[Sequence[Trig]], s: Symbols) -> list[list[Trig]]:
    """A B."""
    columns = list(zip(*B, strict=True))
    return [[inner(row, column, s) for column in columns] for row in A]


def collected(x: Trig, names: Collection[str]) -> dict[Product, Trig]:
    """A polynomial by its products of the generators named: what stands with each."""
    rows: dict[Product, list[tuple[dict[str, int], Fraction]]] = {}
    for powers, coefficient in x.terms():
        key = tuple(sorted((name, k) for name, k in powers.items() if name in names))
        rest = {name: k for name, k in powers.items() if name not in names}
        rows.setdefault(key, []).append((rest, coefficient))
    return {key: x.ring.polynomial(terms) for key, terms in rows.items()}
