"""A polynomial by what moves: each product of coordinates and rates, and what stands with it."""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction

from freebody.derivations.check.right_equations import RightEquations
from freebody.scalars.trig import Trig

Product = tuple[tuple[str, int], ...]
"""A product of coordinates, their sines and cosines, and rates."""

Parts = dict[Product, Trig]
"""What stands with each: a polynomial in the parameters."""


def moving(setting: RightEquations) -> frozenset[str]:
    """Generators that change in time."""
    names = setting.symbols.coordinates
    waves = (f"{function}_{name}" for function in ("sin", "cos") for name in names)
    return frozenset([*setting.order.moving, *names, *waves])


def parts(setting: RightEquations, x: Trig, names: Collection[str] | None = None) -> Parts:
    """A polynomial by its products of the generators named, by default of all that move."""
    names = moving(setting) if names is None else names
    rows: dict[Product, list[tuple[dict[str, int], Fraction]]] = {}
    for powers, coefficient in x.terms():
        key = tuple(sorted((name, k) for name, k in powers.items() if name in names))
        still = {name: k for name, k in powers.items() if name not in names}
        rows.setdefault(key, []).append((still, coefficient))
    return {key: setting.ring.polynomial(terms) for key, terms in rows.items()}


def whole(setting: RightEquations, rows: Parts) -> Trig:
    """The polynomial that has these parts."""
    return setting.ring.polynomial(
        ({**powers, **dict(key)}, coefficient)
        for key, part in rows.items()
        for powers, coefficient in part.terms()
    )
