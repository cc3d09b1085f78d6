"""Lines along which joints turn and slide: how they lie decides which closed form fits an arm.

Numbers alone, told once for an arm.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from freebody.algorithms.screws import SAME, Screw
from freebody.arrays import Array


def parallel(a: Array, b: Array) -> bool:
    """Whether two unit vectors have one direction, or opposite ones."""
    return bool(_size(np.cross(a, b)) < SAME)


def perpendicular(a: Array, b: Array) -> bool:
    """Whether two unit vectors are at right angles."""
    return bool(abs(a @ b) < SAME)


def off_axis(screw: Screw, point: Array) -> float:
    """The distance of a point (3,) from a screw's axis (m)."""
    arm = point - screw.p
    return _size(arm - (arm @ screw.w) * screw.w)


def common_point(screws: Sequence[Screw], scale: float) -> np.ndarray | None:
    """The point (3,) through which all axes go, if there is one."""
    across = [np.eye(3) - np.outer(s.w, s.w) for s in screws]
    A, b = np.vstack(across), np.concatenate([P @ s.p for P, s in zip(across, screws, strict=True)])
    point = np.linalg.lstsq(A, b, rcond=None)[0]
    return np.asarray(point) if np.abs(A @ point - b).max() < 1e-9 * scale else None


def nearest_points(s1: Screw, s2: Screw) -> tuple[Array, Array]:
    """The feet of the common normal of two axes that are not parallel."""
    A = np.stack([s1.w, -s2.w], axis=-1)
    t = np.linalg.lstsq(A, s2.p - s1.p, rcond=None)[0]
    return s1.p + t[0] * s1.w, s2.p + t[1] * s2.w


def can_meet(s1: Screw, s2: Screw, scale: float) -> bool:
    """Whether two joints move a point along two directions: no common axis, no two parallel
    slides."""
    if s1.turning != s2.turning or not parallel(s1.w, s2.w):
        return True
    return s1.turning and off_axis(s1, s2.p) > SAME * scale


def kept_height(s1: Screw, s2: Screw) -> Array | None:
    """A direction along which neither joint moves any point, if there is one."""
    w1, w2 = s1.w, s2.w
    if s1.turning and s2.turning:
        return w1 if parallel(w1, w2) else None
    if s1.turning != s2.turning:
        return (w1 if s1.turning else w2) if perpendicular(w1, w2) else None
    n = np.cross(w1, w2)
    return n / _size(n)


def kept_centre(s1: Screw, s2: Screw, scale: float) -> Array | None:
    """A point from which neither joint moves any point away, if there is one: where two axes that
    are not parallel meet."""
    if not (s1.turning and s2.turning) or parallel(s1.w, s2.w):
        return None
    o1, o2 = nearest_points(s1, s2)
    return o1 if _size(o2 - o1) < SAME * scale else None


def changes_height(s: Screw, c: Array, n: Array, scale: float) -> bool:
    """Whether a joint moves the point c (3,) along the unit vector n."""
    if not s.turning:
        return not perpendicular(s.w, n)
    return not parallel(s.w, n) and off_axis(s, c) > SAME * scale


def changes_distance(s: Screw, o: Array, scale: float) -> bool:
    """Whether a joint moves points away from o (3,)."""
    return not s.turning or off_axis(s, o) > SAME * scale


def _size(v: Array) -> float:
    return float(np.sqrt(v @ v))
