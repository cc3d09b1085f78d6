"""The two solutions of a triangle, and words for them: what postures of arms and of closed chains
have in common."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array

LOOSE = 1e-7
"""How far (relative) a root may be negative and still be taken as 0: what is found is verified
later."""

_FLAT = 1e-6  # angles (rad) below which two branches count as one


def by_triangle(above: Array, below: Array, scale: Array) -> Array:
    """ψ = 2 atan √(above / below), the half-angle formula of a triangle; NaN where one is below
    0."""
    loose = -LOOSE * scale
    with np.errstate(invalid="ignore"):
        good = (above >= loose) & (below >= loose)
        psi = 2.0 * np.arctan2(np.sqrt(np.maximum(above, 0.0)), np.sqrt(np.maximum(below, 0.0)))
    return np.where(good, psi, np.nan)


def side_of(
    value: Array, size: Array | float, positive: str, negative: str, between: str | np.ndarray
) -> np.ndarray:
    """One of three words (...) by the sign of values (...), `between` where they are small beside
    `size`."""
    flat = np.abs(value) <= _FLAT * size
    return np.where(flat, between, np.where(value > 0, positive, negative))
