"""A polynomial by what moves: each product of coordinates and rates, and what stands with it."""

from __future__ import annotations

from collections.abc import Collection

from freebody.expressions.polynomials.arithmetic import Product, collected
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.right_equations import RightEquations

Parts = dict[Product, Trig]
"""What stands with each: a polynomial in the parameters."""


def moving(setting: RightEquations) -> frozenset[str]:
    """Generators that change in time."""
    names = setting.symbols.coordinates
    waves = (f"{function}_{name}" for function in ("sin", "cos") for name in names)
    return frozenset([*setting.order.moving, *names, *waves])


def parts(setting: RightEquations, x: Trig, names: Collection[str] | None = None) -> Parts:
    """A polynomial by its products of the generators named, by default of all that move."""
    return collected(x, moving(setting) if names is None else names)


def whole(setting: RightEquations, rows: Parts) -> Trig:
    """The polynomial that has these parts."""
    return setting.ring.polynomial(
        ({**powers, **dict(key)}, coefficient)
        for key, part in rows.items()
        for powers, coefficient in part.terms()
    )
