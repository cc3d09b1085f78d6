"""Sums of products of polynomials, determinants, and polynomials taken apart by some of their
symbols."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from fractions import Fraction

from freebody.expressions.polynomials.angle_sums import SymbolPowers
from freebody.expressions.polynomials.symbols import Symbols
from freebody.scalars.trig import Trig

PolynomialRows = list[list[Trig]]
"""A matrix of polynomials by its rows."""


def inner(a: Sequence[Trig], b: Sequence[Trig], s: Symbols) -> Trig:
    """Inner product Σ a b of two rows."""
    total = s.zero()
    for x, y in zip(a, b, strict=True):
        if not x.is_zero and not y.is_zero:
            total = total + x * y
    return total


def times(A: Sequence[Sequence[Trig]], B: Sequence[Sequence[Trig]], s: Symbols) -> list[list[Trig]]:
    """Product A B of two matrices."""
    columns = list(zip(*B, strict=True))
    return [[inner(row, column, s) for column in columns] for row in A]


def collected(x: Trig, names: Collection[str]) -> dict[SymbolPowers, Trig]:
    """A polynomial grouped by products of the named generators: the coefficient of each product."""
    rows: dict[SymbolPowers, list[tuple[dict[str, int], Fraction]]] = {}
    for powers, coefficient in x.terms():
        key = tuple(sorted((name, k) for name, k in powers.items() if name in names))
        rest = {name: k for name, k in powers.items() if name not in names}
        rows.setdefault(key, []).append((rest, coefficient))
    return {key: x.ring.polynomial(terms) for key, terms in rows.items()}


def determinant(rows: Sequence[Sequence[Trig]], s: Symbols) -> Trig:
    """The determinant by Laplace's expansion, every minor once, sparse rows first."""
    n = len(rows)
    order = sorted(range(n), key=lambda i: sum(not x.is_zero for x in rows[i]))
    sign = _parity(order)
    minors: dict[int, Trig] = {0: s.element(float(sign))}
    for i in order:  # minors of the rows so far, by the columns they use
        wider: dict[int, Trig] = {}
        for used, minor in minors.items():
            for j, x in enumerate(rows[i]):
                if used >> j & 1 or x.is_zero:
                    continue
                after = (used >> (j + 1)).bit_count()
                term = minor * x if after % 2 == 0 else -(minor * x)
                key = used | 1 << j
                wider[key] = wider[key] + term if key in wider else term
        minors = {key: minor for key, minor in wider.items() if not minor.is_zero}
    return minors.get((1 << n) - 1, s.zero())


def _parity(order: list[int]) -> int:
    inversions = sum(a > b for i, a in enumerate(order) for b in order[i + 1 :])
    return -1 if inversions % 2 else 1
