"""Admittance: the motion that a measured wrench gives a reference with mass, damper and spring."""

from __future__ import annotations

from freebody.elementary import Scalar
from freebody.spatial import Vector, add, scale


def admittance(
    h: Scalar,
    offset: Vector,
    offset_rate: Vector,
    w_ext: Vector,
    inertia: Vector,
    stiffness: Vector,
    damping: Vector,
) -> tuple[Vector, Vector]:
    """The offset and its rate h later, of inertia ẍ + damping ẋ + stiffness x = w_ext, which is
    held.

    By the trapezoidal rule: of order 2, and stable for every h.
    """
    half = 0.5 * h
    rates = tuple(
        ((m - half * (d + half * k)) * v + h * (w - k * x)) / (m + half * (d + half * k))
        for x, v, w, m, d, k in zip(
            offset, offset_rate, w_ext, inertia, damping, stiffness, strict=True
        )
    )
    return add(offset, scale(half, add(offset_rate, rates))), rates
