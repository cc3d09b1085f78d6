"""The third of three joints where the other two leave neither a height nor a distance alone: from a
polynomial of degree four (Pieper 1968).

Over numbers alone: the roots are those of a companion matrix.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import Choice, JointPlace, line
from freebody.algorithms.joint_lines import nearest_points
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.spatial import Vector

_NODES = 2.0 * np.pi * np.arange(5) / 5
_REAL = 1e-3
"""How far a root may be from a real one and still be tried: what is found is verified later."""


def quartic(
    s1: Screw, s2: Screw, s3: Screw, length: float
) -> Callable[[Vector, Vector], list[Choice]]:
    """(c, p) -> the four places of joint 3, NaN where there are fewer, none of them clear."""
    l3 = line(s3)

    def places(c: Vector, p: Vector) -> list[Choice]:
        points = np.stack(np.broadcast_arrays(*p), axis=-1)
        values = _values(s1, s2, s3, np.array(c, dtype=float), points.reshape(-1, 3), length)
        half = np.array([_half_angles(row) for row in values]).reshape(*points.shape[:-1], 4)
        if s3.turning:
            at = [JointPlace(l3, np.sin(x), np.cos(x)) for x in np.moveaxis(2.0 * half, -1, 0)]
        else:
            shifts = np.moveaxis(length * np.tan(half), -1, 0)
            at = [JointPlace(l3, shift=x) for x in shifts]
        return [(place, np.zeros(points.shape[:-1])) for place in at]

    return places


def _values(s1: Screw, s2: Screw, s3: Screw, c: Array, p: Array, length: float) -> Array:
    """The polynomial (N, 5) at five angles, of a slide by length tan(angle / 2), which makes it
    one of sines and cosines too."""
    if s3.turning:
        return _miss(s1, s2, s3.moved(_NODES, c), p[:, None])
    c3 = s3.moved(length * np.tan(_NODES / 2), c)
    return _miss(s1, s2, c3, p[:, None]) * np.cos(_NODES / 2) ** 4


def _miss(s1: Screw, s2: Screw, c3: Array, p: Array) -> Array:
    """How far |y|² is from its due, for y = e1⁻¹ p = e2 c3 from the linear conditions; c3 (5, 3),
    p (N, 1, 3)."""
    if s1.turning and s2.turning:
        o1, o2 = nearest_points(s1, s2)
        A = np.stack([s1.w, s2.w, o2 - o1])
        squares = _square(p - o1) - _square(c3 - o2) + o2 @ o2 - o1 @ o1
        b = np.stack(np.broadcast_arrays(p @ s1.w, c3 @ s2.w, squares / 2), axis=-1)
        return _square(b @ np.linalg.inv(A).T - o1) - _square(p - o1)
    turning, sliding = (s1, s2) if s1.turning else (s2, s1)
    on_circle, on_line = np.broadcast_arrays(*((p, c3) if s1.turning else (c3, p)))
    far = ((on_circle - on_line) @ turning.w) / (s1.w @ s2.w)
    y = on_line + far[..., None] * sliding.w
    return _square(y - turning.p) - _square(on_circle - turning.p)


def _square(v: Array) -> Array:
    return np.sum(v * v, axis=-1)


def _half_angles(values: Array) -> Array:
    """Halves of the angles (4,) at which a polynomial of degree 2 in sine and cosine, given at five
    even angles, is zero."""
    coefficients = (np.fft.fft(values) / 5)[[2, 1, 0, 4, 3]]  # of e^(ikx), k = 2, 1, 0, -1, -2
    negligible = np.abs(coefficients) < 1e-12 * np.abs(coefficients).max()
    z = np.roots(np.where(negligible, 0.0, coefficients))
    on_circle = np.angle(z[np.abs(np.log(np.abs(z) + 1e-300)) < _REAL])
    found = np.full(4, np.nan)
    found[: len(on_circle)] = on_circle / 2
    return found
