"""Paths of a frame, in position and orientation together: lines, arcs, and lines with rounded
corners.

The way along a path is measured in m; a turn counts as the arm's length times its angle where that
is more. Between two poses the position moves straight and the orientation about a fixed axis. Near
a corner, from `radius` before it to `radius` behind it, both pass smoothly from the one movement to
the other: with g(σ) rising from slope 0 to slope 1, the way still moved before the corner is
σ - radius - g, that behind it g. Path and curvature are continuous, and so are rates and
accelerations of whoever follows smoothly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.task import rotation_vector

_HALF_TURN = 1e-6
_STRAIGHT = 1e-6  # of the distances: points this near to a line have no circle through them


@dataclass(frozen=True, eq=False)
class TipPath:
    """The poses of a frame along a path length s from 0 to `length`.

    marks: (k,) from 0 to length, where stretches meet. stretches: for each, its poses at the way
    (N,) from its begin.
    """

    marks: Array
    stretches: tuple[Callable[[Array], Array], ...]
    words: str

    @property
    def length(self) -> float:
        """Length of the whole path."""
        return float(self.marks[-1])

    def at(self, s: Array) -> Array:
        """Poses (N, dim + 1, dim + 1) at s (N,)."""
        of = np.clip(np.searchsorted(self.marks, s, side="right") - 1, 0, len(self.stretches) - 1)
        poses = [self.stretches[k](s[of == k] - self.marks[k]) for k in range(len(self.stretches))]
        return np.concatenate(poses)[np.argsort(np.argsort(of, kind="stable"), kind="stable")]


@dataclass(frozen=True, eq=False)
class _Leg:
    """A straight motion from one pose to the next: shift (m) and turn (rad, body axes) per m of
    path."""

    start: Array
    length: float
    shift: Array
    turn: Array

    def moved(self, pose: Array, way: Array) -> Array:
        """The pose (dim + 1, dim + 1), or poses (N, ...), moved along this leg's direction by path
        lengths `way` (N,)."""
        d = len(self.shift)
        found = np.broadcast_to(pose, (len(way), d + 1, d + 1)).copy()
        found[:, :d, d] += way[:, None] * self.shift
        found[:, :d, :d] = found[:, :d, :d] @ rotations(way[:, None] * self.turn)
        return found


def rotations(vectors: Array) -> Array:
    """Rotation matrices (N, 3, 3) of rotation vectors (N, 3), or (N, 2, 2) of angles (N, 1)."""
    if not len(vectors):  # SciPy 1.14, which Pyodide 0.27 has, takes no empty arrays
        return np.empty((0, 3, 3) if vectors.shape[1] == 3 else (0, 2, 2))
    if vectors.shape[1] == 3:
        return Rotation.from_rotvec(vectors).as_matrix()
    c, s = np.cos(vectors[:, 0]), np.sin(vectors[:, 0])
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def rounded_lines(
    function: str, poses: Sequence[Array], radius: float, arm_length: float
) -> TipPath:
    """The path straight from pose to pose, with corners rounded from `radius` (m) before to
    `radius` behind them."""
    legs = [_leg(function, k, *pair, arm_length) for k, pair in enumerate(pairwise(poses))]
    corners = len(legs) - 1
    cut = np.array([0.0, *[radius] * corners, 0.0])
    for k, leg in enumerate(legs):
        if cut[k] + cut[k + 1] > leg.length * (1.0 + 1e-12):
            share = "half of it" if cut[k] and cut[k + 1] else "as much"
            raise FreebodyError(
                f"{function}: the way to target {k} is {leg.length:.4g} m long, too short for the "
                f"radius {radius:.4g} m at its corners; a radius of at most {share} fits."
            )
    marks, stretches = [0.0], []
    for k, leg in enumerate(legs):
        straight = leg.length - cut[k] - cut[k + 1]
        if straight > 1e-12 * leg.length:
            stretches.append(lambda way, leg=leg, cut=cut[k]: leg.moved(leg.start, cut + way))
            marks.append(marks[-1] + straight)
        if k < corners and radius > 0.0:
            stretches.append(_corner(leg, legs[k + 1], radius))
            marks.append(marks[-1] + 2.0 * radius)
    whole = sum(float(np.linalg.norm(leg.shift)) * leg.length for leg in legs)
    words = f"a line of {whole:.4g} m"
    if whole < 1e-12 * arm_length:
        turns = sum(float(np.linalg.norm(leg.turn)) * leg.length for leg in legs)
        words = f"a turn of {np.degrees(turns):.4g} °"
    elif corners:
        words = f"{len(legs)} lines of {whole:.4g} m with corners rounded within {radius:.4g} m"
    return TipPath(np.array(marks), tuple(stretches), words)


def arc_path(function: str, start: Array, via: Array, end: Array, arm_length: float) -> TipPath:
    """The path on a circle from a pose through a point (dim,) to a pose; the orientation turns
    evenly."""
    d = len(via)
    p0, p1, p2 = (np.pad(p, (0, 3 - d)) for p in (start[:d, d], via, end[:d, d]))
    a, b = p1 - p0, p2 - p0
    normal = np.cross(a, b)
    size = float(normal @ normal)
    far = max(np.linalg.norm(a), np.linalg.norm(b), np.linalg.norm(b - a))
    if not np.sqrt(size) > _STRAIGHT * far**2:
        raise FreebodyError(
            f"{function}: start, via and target lie on a line, or are not three points; no circle "
            f"goes through them. For a full circle give two arcs."
        )
    centre = p0 + np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * size)
    e1 = p0 - centre
    e2 = np.cross(normal / np.sqrt(size), e1)
    sweep = float(np.arctan2((p2 - centre) @ e2, (p2 - centre) @ e1) % (2.0 * np.pi))
    leg = _leg(function, 0, start, end, arm_length)
    radius = float(np.linalg.norm(e1))
    length = max(radius * sweep, arm_length * float(np.linalg.norm(leg.turn)) * leg.length)
    turning = _Leg(leg.start, length, np.zeros(d), leg.turn * (leg.length / length))

    def poses(way: Array) -> Array:
        found = turning.moved(start, way)
        angle = (sweep / length * way)[:, None]
        found[:, :d, d] = (centre + np.cos(angle) * e1 + np.sin(angle) * e2)[:, :d]
        return found

    words = f"an arc of {np.degrees(sweep):.4g} ° with a radius of {radius:.4g} m"
    return TipPath(np.array([0.0, length]), (poses,), words)


def _leg(function: str, k: int, start: Array, end: Array, arm_length: float) -> _Leg:
    d = len(start) - 1
    shift = end[:d, d] - start[:d, d]
    turn = rotation_vector(start[:d, :d].T @ end[:d, :d])
    angle = float(np.linalg.norm(turn))
    if d == 3 and angle > np.pi - _HALF_TURN:
        raise FreebodyError(
            f"{function}: the orientation of target {k} is half a turn from the one before, so "
            f"the direction of rotation is not determined; give a pose between them."
        )
    length = max(float(np.linalg.norm(shift)), arm_length * angle)
    if not length > 1e-12 * arm_length:
        raise FreebodyError(
            f"{function}: target {k} is the pose before it; leave it out, and to wait there use "
            f"fb.dwell."
        )
    return _Leg(start, length, shift / length, turn / length)


def _corner(before: _Leg, behind: _Leg, radius: float) -> Callable[[Array], Array]:
    """A function that gives the poses around the rounded corner where one leg meets the next."""

    def poses(way: Array) -> Array:
        x = way / (2.0 * radius)
        left = 2.0 * radius * (x**3 - 0.5 * x**4)  # slope 3 x² - 2 x³
        return behind.moved(before.moved(behind.start, way - radius - left), left)

    return poses
