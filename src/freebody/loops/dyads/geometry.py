"""Triangles and right-angled triangles of vectors as complex numbers, and names for their two
solutions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.dyads.chain import Complex, Crossing, Posture

_COINCIDE = 1e-6
"""Sides of a triangle, relative to its perimeter, below which two of its pins are one."""
_LOOSE = 1e-9
"""How far (relative) a square may be negative and still be taken as 0: a straight dyad."""
_NEGATIVE = 1e-7
"""How far (relative) a root may be negative and still be taken as 0: what is found is verified
later."""
_FLAT = 1e-6  # angles (rad) below which two branches count as one


def along(e: Complex, v: Complex) -> Array:
    """Component of v along the direction e: e · v."""
    return np.asarray(np.real(np.conj(e) * v), dtype=float)


def across(e: Complex, v: Complex) -> Array:
    """Component of v across the direction e: e × v."""
    return np.asarray(np.imag(np.conj(e) * v), dtype=float)


def corner(opposite: Array, a: Array, b: Array) -> Array:
    """The angle of a triangle between sides a and b, by half-angles; NaN where the sides make
    none."""
    d = a - b
    above, below = (opposite - d) * (opposite + d), (a + b - opposite) * (a + b + opposite)
    return _by_triangle(above, below, (a + b) ** 2 + opposite**2)


def _by_triangle(above: Array, below: Array, scale: Array) -> Array:
    """The angle ψ = 2 atan √(above / below) by the half-angle formula of a triangle; NaN where one
    of them is below 0."""
    loose = -_NEGATIVE * scale
    with np.errstate(invalid="ignore"):
        good = (above >= loose) & (below >= loose)
        psi = 2.0 * np.arctan2(np.sqrt(np.maximum(above, 0.0)), np.sqrt(np.maximum(below, 0.0)))
    return np.where(good, psi, np.nan)


def root(a: Array, b: Array) -> Array:
    """The leg √(a² - b²) of a right-angled triangle; 0 where a² - b² is negative by rounding only,
    else NaN."""
    square = (a - b) * (a + b)
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where((square < 0) & (square > -_LOOSE * (a * a + b * b)), 0.0, square))


def side(base: Complex, other: Complex, elbow: Complex) -> Array:
    """The sine of the angle from base-other to base-elbow: positive where the elbow lies on the
    left."""
    one, two = other - base, elbow - base
    return across(one, two) / np.maximum(np.abs(one) * np.abs(two), 1e-300)


def side_of(
    value: Array, size: Array | float, positive: str, negative: str, between: str | np.ndarray
) -> np.ndarray:
    """One of three words (...) by the sign of values (...); `between` where they are small relative
    to `size`."""
    flat = np.abs(value) <= _FLAT * size
    return np.where(flat, between, np.where(value > 0, positive, negative))


def shifted(at: Posture, first: Crossing, second: Crossing, way: Complex) -> Array:
    """The positions q after moving two slides so that together they move the bodies behind them by
    the vector `way`."""
    e, g = at.slide(first), at.slide(second)
    det = across(e, g)
    with np.errstate(invalid="ignore", divide="ignore"):
        det = np.where(np.abs(det) > 1e-12, det, np.nan)
        x, y = across(way, g) / det, across(e, way) / det
    return at.moved(at.slid(first, x)).slid(second, y)


def coincident(*sides: Array) -> NDArray[np.bool_]:
    """Where two pins of a triangle with these three sides coincide while its other two sides are
    equal, so that its angle is arbitrary."""
    near = _COINCIDE * np.maximum(np.add.reduce(sides), 1e-300)
    a, b, c = sides
    found = np.zeros(np.shape(near), dtype=bool)
    for short, one, two in ((a, b, c), (b, c, a), (c, a, b)):
        found |= (short <= near) & (np.abs(one - two) <= 2.0 * near)
    return found
