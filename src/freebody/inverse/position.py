"""Two and three joints that bring a point to a point: e1 e2 c = p, and e1 e2 e3 c = p (Pieper
1968).

With y = e2 e3 c = e1⁻¹ p, the point y lies on the circle (or line) of p about joint 1 and on that
of c about joint 2. Three joints: the third is found first, from a height or a distance that joints
1 and 2 leave alone, else from a polynomial of degree four.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.joint_lines import (
    can_meet,
    changes_distance,
    changes_height,
    kept_centre,
    kept_height,
    nearest_points,
    parallel,
    perpendicular,
)
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.inverse import subproblems as sp

Polynomial = Callable[[Array], Array]


@dataclass(frozen=True)
class Candidates:
    """Candidates x (..., k, n), NaN where there is none; free marks the joints that could stand
    anywhere."""

    x: Array
    free: np.ndarray


def meet(s1: Screw, s2: Screw, c: Array, p: Array, prefer: Array, scale: float) -> Candidates:
    """Positions (..., 2, 2) of two joints with e1 e2 c = p; c, p (..., 3)."""
    y = _meeting_points(s1, s2, c, p)
    c, p = np.broadcast_arrays(c[..., None, :], p[..., None, :])
    x2, free2 = sp.onto(s2, c, y, prefer[1], scale)
    x1, free1 = sp.onto(s1, s2.moved(x2, c), p, prefer[0], scale)
    return Candidates(np.stack([x1, x2], axis=-1), np.stack([free1, free2], axis=-1))


def _meeting_points(s1: Screw, s2: Screw, c: Array, p: Array) -> Array:
    """y (..., 2, 3) on the path of p under joint 1 backwards and on the path of c under joint 2."""
    w1, w2 = s1.w, s2.w
    if s1.turning and s2.turning:
        if parallel(w1, w2):
            x2 = sp.at_chord(s2, c, s1.p, sp.size(sp.across(w1, p - s1.p)))
            return s2.moved(x2, c[..., None, :])
        return _on_circle(s1, p, w2, (c - s1.p) @ w2)
    if s1.turning != s2.turning:
        turning, sliding = (s1, s2) if s1.turning else (s2, s1)
        on_circle, on_line = (p, c) if s1.turning else (c, p)
        if perpendicular(w1, w2):
            n = np.cross(turning.w, sliding.w)
            return _on_circle(turning, on_circle, n, (on_line - turning.p) @ n)
        y = on_line + (((on_circle - on_line) @ turning.w) / (w1 @ w2))[..., None] * sliding.w
    else:
        y = c + _second_slide(w1, w2, p - c)[..., None] * w2
    return np.stack([y, np.full_like(y, np.nan)], axis=-2)


def _on_circle(screw: Screw, point: Array, n: Array, height: Array) -> Array:
    """Where the circle of a point about a screw meets the plane n · (y - screw.p) = height: (...,
    2, 3)."""
    w = screw.w
    lift = (point - screw.p) @ w
    across = sp.across(w, n)
    sine = float(sp.size(across))
    m = across / sine
    g = (height - lift * (w @ n)) / sine
    side = sp.root(sp.size(sp.across(w, point - screw.p)), np.abs(g))
    middle = screw.p + lift[..., None] * w + g[..., None] * m
    step = side[..., None] * np.cross(w, m)
    return np.stack([middle + step, middle - step], axis=-2)


def _second_slide(w1: Array, w2: Array, way: Array) -> Array:
    """x2 of the way x1 w1 + x2 w2."""
    m = sp.across(w1, w2)
    return (way @ m) / (m @ m)


def last_of_three(s1: Screw, s2: Screw, s3: Screw, c: Array, scale: float) -> Polynomial | None:
    """The equation of the third joint: a function p (..., 3) -> x3 (..., k), or None where it
    decides nothing."""
    if not can_meet(s1, s2, scale):
        return None
    normal = kept_height(s1, s2)
    if normal is not None:
        if not changes_height(s3, c, normal, scale):
            return None
        return lambda p: sp.at_height(s3, c, normal, p @ normal)
    centre = kept_centre(s1, s2, scale)
    if centre is not None:
        if not changes_distance(s3, centre, scale):
            return None
        return lambda p: sp.at_distance(s3, c, centre, sp.size(p - centre))
    return lambda p: _by_polynomial(s1, s2, s3, c, p, scale)


def _by_polynomial(s1: Screw, s2: Screw, s3: Screw, c: Array, p: Array, scale: float) -> Array:
    """x3 (..., 4): y as a function of x3 from three planes, put into the equation of the sphere it
    must lie on."""
    points = p.reshape(-1, 3)
    nodes = (
        2 * np.pi * np.arange(5) / 5
        if s3.turning
        else scale * np.cos(np.pi * (np.arange(5) + 0.5) / 5)
    )
    samples = _miss(s1, s2, s3.moved(nodes, c), points[:, None, :])
    roots = np.full((len(points), 4), np.nan)
    for row, values in zip(roots, samples, strict=True):
        found = _circle_roots(values) if s3.turning else _line_roots(nodes, values, scale)
        row[: len(found)] = found
    return roots.reshape(*p.shape[:-1], 4)


def _miss(s1: Screw, s2: Screw, c3: Array, p: Array) -> Array:
    """How far |y|² is from its due, for y from the linear conditions; c3 (5, 3), p (N, 1, 3)."""
    if s1.turning and s2.turning:
        o1, o2 = nearest_points(s1, s2)
        A = np.stack([s1.w, s2.w, o2 - o1])
        squares = sp.dot(p - o1, p - o1) - sp.dot(c3 - o2, c3 - o2) + o2 @ o2 - o1 @ o1
        b = np.stack(np.broadcast_arrays(p @ s1.w, c3 @ s2.w, squares / 2), axis=-1)
        y = b @ np.linalg.inv(A).T
        return sp.dot(y - o1, y - o1) - sp.dot(p - o1, p - o1)
    turning, sliding = (s1, s2) if s1.turning else (s2, s1)
    on_circle, on_line = np.broadcast_arrays(*((p, c3) if s1.turning else (c3, p)))
    y = on_line + (((on_circle - on_line) @ turning.w) / (s1.w @ s2.w))[..., None] * sliding.w
    o = turning.p
    return sp.dot(y - o, y - o) - sp.dot(on_circle - o, on_circle - o)


def _circle_roots(values: Array) -> Array:
    """Angles at which a trigonometric polynomial of degree 2, given at 5 even angles, is zero."""
    coefficients = np.fft.fft(values) / 5  # of e^(ikx), k = 0, 1, 2, -2, -1
    z = _roots(coefficients[[2, 1, 0, 4, 3]])
    return np.angle(z[np.abs(np.log(np.abs(z) + 1e-300)) < 1e-3])


def _line_roots(nodes: Array, values: Array, scale: float) -> Array:
    z = _roots(np.polyfit(nodes / scale, values, 4)) * scale
    return z.real[np.abs(z.imag) < 1e-3 * scale]


def _roots(coefficients: np.ndarray) -> np.ndarray:
    """Roots of a polynomial, its vanishing first and last coefficients left out."""
    negligible = np.abs(coefficients) < 1e-12 * np.abs(coefficients).max()
    return np.roots(np.where(negligible, 0.0, coefficients))


def reach(
    screws: Sequence[Screw], c: Array, p: Array, prefer: Array, scale: float
) -> Candidates | None:
    """Positions (..., k, 3) of three joints with e1 e2 e3 c = p, c (3,), p (..., 3); None where
    they are no arm."""
    s1, s2, s3 = screws
    equation = last_of_three(s1, s2, s3, c, scale)
    if equation is None:
        return None
    x3 = equation(p)
    pair = meet(s1, s2, s3.moved(x3, c), p[..., None, :], prefer, scale)
    x3 = np.broadcast_to(x3[..., None, None], (*pair.x.shape[:-1], 1))
    x = np.concatenate([pair.x, x3], axis=-1)
    free = np.concatenate([pair.free, np.zeros_like(x3, dtype=bool)], axis=-1)
    shape = (*p.shape[:-1], -1, 3)
    return Candidates(x.reshape(shape), free.reshape(shape))
