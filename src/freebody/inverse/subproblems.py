"""One and two joints at a time: what angles bring a point or a direction to where it is wanted.

These are the subproblems of Paden and Kahan (Murray, Li, Sastry 1994, section 3.3; Elias and Wen,
IK-Geo, 2022), written with half angles and products of differences, so that nothing is lost by
cancellation where an arm is straight or folded. Arrays have any batch in front; two solutions stand
on the last axis, NaN where there is none.
"""

from __future__ import annotations

import numpy as np

from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.trees.triangle_solutions import LOOSE, by_triangle

_ON_AXIS = 1e-11


def dot(a: Array, b: Array) -> Array:
    """Σ a b over the last axis."""
    return np.sum(a * b, axis=-1)


def cross(a: Array, b: Array) -> Array:
    """a × b over the last axis."""
    a, b = np.broadcast_arrays(a, b)
    return np.cross(a, b)


def across(w: Array, v: Array) -> Array:
    """The part of v at right angles to the unit vector w."""
    return v - (v @ w)[..., None] * w


def size(v: Array) -> Array:
    """Length over the last axis."""
    return np.sqrt(dot(v, v))


def root(a: Array, b: Array) -> Array:
    """√((a - b)(a + b)): the other side of a right triangle; 0 where a is short of b by rounding,
    else NaN."""
    square = (a - b) * (a + b)
    loose = LOOSE * (a * a + b * b)
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where((square < 0) & (square >= -loose), 0.0, square))


def either(base: Array, change: Array) -> Array:
    """base + change and base - change, on a new last axis."""
    return np.stack(np.broadcast_arrays(base + change, base - change), axis=-1)


def onto(
    screw: Screw, a: Array, b: Array, prefer: float = 0.0, scale: float = 1.0
) -> tuple[Array, np.ndarray]:
    """(angle, free): the turn about a screw that brings point a as near to b as it can; sliding:
    the shift.

    free: a or b lies on the axis, where any angle does; it is then `prefer`.
    """
    if not screw.turning:
        x = (b - a) @ screw.w
        return x, np.zeros(x.shape, dtype=bool)
    u, v = across(screw.w, a - screw.p), across(screw.w, b - screw.p)
    free = np.minimum(size(u), size(v)) < _ON_AXIS * scale
    angle = np.arctan2(cross(u, v) @ screw.w, dot(u, v))
    return np.where(free, prefer, angle), free


def at_chord(screw: Screw, c: Array, o: Array, chord: Array) -> Array:
    """Turns (..., 2) after which c is seen at the distance `chord` from o, looking along the
    screw's axis."""
    u, v = across(screw.w, c - screw.p), across(screw.w, o - screw.p)
    a, b = size(u), size(v)
    base = np.arctan2(cross(u, v) @ screw.w, dot(u, v))
    d = np.abs(a - b)
    psi = by_triangle(
        (chord - d) * (chord + d), (a + b - chord) * (a + b + chord), (a + b) ** 2 + chord**2
    )
    return either(base, psi)


def at_distance(screw: Screw, c: Array, o: Array, distance: Array) -> Array:
    """Positions (..., 2) of a joint that bring c to a distance from o (subproblem 3)."""
    if screw.turning:
        return at_chord(screw, c, o, root(distance, np.abs((c - o) @ screw.w)))
    return either((o - c) @ screw.w, root(distance, size(across(screw.w, c - o))))


def at_height(screw: Screw, c: Array, n: Array, height: Array) -> Array:
    """Positions (..., 2) of a joint after which n · c = height, n (3,) constant (subproblem 4)."""
    if not screw.turning:
        x = (height - c @ n) / (screw.w @ n)
        return np.stack([x, np.full(np.shape(x), np.nan)], axis=-1)
    arm = c - screw.p
    u = across(screw.w, arm)
    a, b = u @ n, cross(screw.w, arm) @ n
    wanted = height - (c - u) @ n
    radius = np.hypot(a, b)
    return either(np.arctan2(b, a), np.arctan2(root(radius, np.abs(wanted)), wanted))


def at_height_of(screw: Screw, points: Array, n: Array, height: float | Array) -> Array:
    """As `at_height` for one height and many points (..., 3)."""
    return at_height(screw, points, n, np.full(points.shape[:-1], float(height)))


def at_angle(screw: Screw, v: Array, u: Array, angle: Array) -> Array:
    """Turns (..., 2) after which the unit vector v (3,) makes an angle (0 … π) with the unit vector
    u (3,).

    By the half angles of the spherical triangle u, w, v, exact where v comes to lie along u.
    """
    w = screw.w
    alpha, beta = angle_between(w, u), angle_between(w, v)
    base = np.arctan2(u @ cross(w, v), u @ across(w, v))
    above = np.sin((angle + alpha - beta) / 2) * np.sin((angle - alpha + beta) / 2)
    below = np.sin((alpha + beta + angle) / 2) * np.sin((alpha + beta - angle) / 2)
    return either(base, by_triangle(above, below, np.ones_like(angle)))


def angle_between(a: Array, b: Array) -> Array:
    """Angle (0 … π) between two directions, exact when small."""
    return np.arctan2(size(cross(a, b)), dot(a, b))


def turn_of(R: Array, w: Array) -> Array:
    """Angle (...) of a rotation (..., 3, 3) about the known axis w."""
    skew = np.stack(
        [R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]],
        axis=-1,
    )
    return np.arctan2(skew @ w, np.trace(R, axis1=-2, axis2=-1) - 1.0)
