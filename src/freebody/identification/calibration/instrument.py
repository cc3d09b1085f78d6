"""A first guess of where the instrument stands and where the marker sits, and what is wrong with
poses that no such guess explains: units, axes, order.

With positions alone, R_IWᵀ m = p_E + R_E y - s is linear in R_IWᵀ, y and s, as far as these nine
entries need not be a rotation; the nearest rotation is then taken. With rotations, R_M = R_IW R_E
R_EM gives both unknown rotations as the singular vectors of one matrix (Shah 2013: solving the
robot-world/hand-eye calibration problem using the Kronecker product).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.calibration.chain import MeasuredChain
from freebody.identification.calibration.poses import Poses

_DOUBTFUL, _WRONG = 0.03, 0.15
"""Distances left by the guess, over the size of the cloud of points: from the first on other units
and axes are tried, beyond the second poses are refused."""
_BETTER = 0.2
"""Part of the distances that another reading of the poses may leave to be the one meant."""
_ROUNDS = 10


class FittedPose(NamedTuple):
    """Axes R (3, 3) and origin p (3,)."""

    R: Array
    p: Array


class Guess(NamedTuple):
    """The world in the instrument's axes, the marker in the frame at the end, and the median of the
    distances that they leave, over the size of the cloud of points."""

    instrument: FittedPose
    marker: FittedPose
    left: float


def guess(
    chain: MeasuredChain, poses: Poses, instrument: FittedPose | None, marker: FittedPose | None
) -> Guess:
    """A first guess of what is not known of instrument and marker, for the robot as its model has
    it. Refuses poses that no instrument sees of this robot, with what they may be instead."""
    best = _guess(chain, poses, instrument, marker)
    if not best.left > _DOUBTFUL:
        return best
    for count in (1, 2):
        for readings in combinations(_READINGS, count):
            other: Poses | None = poses
            for reading in readings:
                other = None if other is None else reading.applied(chain, other)
            if other is None:
                continue
            if _guess(chain, other, instrument, marker).left < _BETTER * best.left:
                said = " and ".join(x.words for x in readings)
                raise FreebodyError(f"calibrate: the poses fit {_robot(chain)} only if {said}.")
    if best.left > _WRONG:
        raise FreebodyError(
            f"calibrate: the poses are not those of {_robot(chain)}: wherever instrument and "
            f"marker are, half of them are off by more than {100.0 * best.left:.0f} % of the size "
            f"of the measured space. Give q and poses row by row in one order, and the frame= that "
            f"carries the marker."
        )
    return best


def _robot(chain: MeasuredChain) -> str:
    return f"{chain.model.name!r} with its marker on {chain.frame!r}"


@dataclass(frozen=True)
class _PoseReading:
    """Another way to read poses, and the words that say how to give them; None where it makes no
    difference."""

    words: str
    applied: Callable[[MeasuredChain, Poses], Poses | None]


def _from_degrees(chain: MeasuredChain, poses: Poses) -> Poses | None:
    turns = [k for k, turns in zip(chain.columns, chain.turns, strict=True) if turns]
    q = poses.q.copy()
    q[:, turns] = np.radians(q[:, turns])
    return Poses(q, poses.position, poses.rotation) if turns else None


def _from_millimetres(chain: MeasuredChain, poses: Poses) -> Poses:
    return Poses(poses.q, 1e-3 * poses.position, poses.rotation)


def _mirrored(chain: MeasuredChain, poses: Poses) -> Poses | None:
    if poses.rotation is not None:
        return None  # of left-handed axes, their determinant tells
    return Poses(poses.q, poses.position * [1.0, 1.0, -1.0])


def _transposed(chain: MeasuredChain, poses: Poses) -> Poses | None:
    if poses.rotation is None:
        return None
    return Poses(poses.q, poses.position, np.swapaxes(poses.rotation, 1, 2))


def _inverted(chain: MeasuredChain, poses: Poses) -> Poses | None:
    if poses.rotation is None:
        return None
    R = np.swapaxes(poses.rotation, 1, 2)
    return Poses(poses.q, -(R @ poses.position[:, :, None])[:, :, 0], R)


_READINGS = (
    _PoseReading("the angles in q are degrees (give radians, np.deg2rad(q))", _from_degrees),
    _PoseReading("the positions are in mm (give metres)", _from_millimetres),
    _PoseReading("the instrument's axes are left-handed (turn over one of x, y, z)", _mirrored),
    _PoseReading("the rotations are transposed (give the marker's axes as columns)", _transposed),
    _PoseReading(
        "the poses are of the instrument in the marker's axes (give the inverse)", _inverted
    ),
)


def _guess(
    chain: MeasuredChain, poses: Poses, instrument: FittedPose | None, marker: FittedPose | None
) -> Guess:
    """The guess that leaves the least of some: by points alone, and by rotations, which tell
    nothing of the angle about an axis that all of them share."""
    R, p = chain.frames(poses.q, np.zeros(len(chain.names)))
    R, p = R[:, -1], p[:, -1]
    starts: list[tuple[FittedPose | None, bool]] = [(instrument, instrument is None)]
    if instrument is None:
        starts.append((_by_entries(R, p, poses.position), True))
        if poses.rotation is not None:
            turn = _by_rotations(R, poses.rotation, marker)
            starts.append((FittedPose(turn, np.zeros(3)), False))
    found = []
    for start, turning in starts:
        at, y = _by_points(R, p, poses, start, marker, turning, instrument is not None)
        R_EM: Array = np.eye(3)
        if marker is not None:
            R_EM = marker.R
        elif poses.rotation is not None:
            R_EM = _nearest(np.einsum("nji,njk->ik", at.R @ R, poses.rotation))
        found.append(Guess(at, FittedPose(R_EM, y), _left(R, p, poses, at, y, R_EM)))
    return min(found, key=lambda x: x.left)


def _left(R: Array, p: Array, poses: Poses, instrument: FittedPose, y: Array, R_EM: Array) -> float:
    """The median distance of points, or turn of rotations, that a guess leaves, over the size of
    the cloud of points or over 1 rad."""
    seen = (p + R @ y) @ instrument.R.T + instrument.p
    size = min(_size(seen), _size(poses.position))
    off = float(np.median(np.linalg.norm(seen - poses.position, axis=1)))
    left = off / size if size > 0.0 else np.inf
    if poses.rotation is None:
        return left
    turn = np.swapaxes(poses.rotation, 1, 2) @ (instrument.R @ R @ R_EM)
    cosines = np.clip(0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0), -1.0, 1.0)
    return max(left, float(np.median(np.arccos(cosines))))


def _size(points: Array) -> float:
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))


def _by_points(
    R: Array,
    p: Array,
    poses: Poses,
    start: FittedPose | None,
    marker: FittedPose | None,
    turning: bool,
    fixed: bool,
) -> tuple[FittedPose, Array]:
    """The instrument and the marker's place by turns, each in closed form as if the other were
    known; the instrument is `fixed`, or its rotation is not `turning`."""
    y = np.zeros(3) if marker is None else marker.p
    at = start or _aligned(p + R @ y, poses.position)
    for _ in range(_ROUNDS):
        if marker is None:
            y, shift = _marker(R, p, poses.position, at, fixed)
            at = FittedPose(at.R, at.p + shift)
        if turning:
            at = _aligned(p + R @ y, poses.position)
        elif not fixed:
            at = FittedPose(at.R, np.mean(poses.position - (p + R @ y) @ at.R.T, axis=0))
    return at, y


def _marker(R: Array, p: Array, seen: Array, at: FittedPose, fixed: bool) -> tuple[Array, Array]:
    """The marker's place, and by how much the instrument is off besides, unless it is `fixed`."""
    rows = at.R @ R
    left = seen - (p @ at.R.T + at.p)
    if fixed:
        return _solved(rows.reshape(-1, 3), left.ravel()), np.zeros(3)
    moved = np.broadcast_to(np.eye(3), rows.shape)
    matrix = np.concatenate([rows, moved], axis=2).reshape(-1, 6)
    found = _solved(matrix, left.ravel())
    return found[:3], found[3:]


def _solved(matrix: Array, right: Array) -> Array:
    """The shortest least-squares solution, where something is hardly told as where it is not."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-6)[0], dtype=np.float64)


def _aligned(points: Array, seen: Array) -> FittedPose:
    """The pose (R, p) with seen ≈ R point + p by least squares (Kabsch 1976)."""
    a, b = points.mean(axis=0), seen.mean(axis=0)
    R = _nearest((seen - b).T @ (points - a))
    return FittedPose(R, b - R @ a)


def _nearest(matrix: Array) -> Array:
    """The rotation nearest to a matrix (3, 3)."""
    u, _, vt = np.linalg.svd(matrix)
    return u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt


def _by_entries(R: Array, p: Array, seen: Array) -> FittedPose:
    """The instrument by a linear system in which its rotation has nine unknown entries."""
    n = len(p)
    size = _size(seen) or 1.0
    matrix = np.zeros((n, 3, 15))
    for i in range(3):
        matrix[:, i, 3 * i : 3 * i + 3] = (seen - seen.mean(axis=0)) / size
    matrix[:, :, 9:12] = -R
    matrix[:, :, 12:] = -np.eye(3)
    found = _solved(matrix.reshape(-1, 15), p.ravel())
    R_IW = _nearest(found[:9].reshape(3, 3).T)
    return FittedPose(R_IW, np.mean(seen - (p + R @ found[9:12]) @ R_IW.T, axis=0))


def _by_rotations(R: Array, seen: Array, marker: FittedPose | None) -> Array:
    """The instrument's rotation by those that it saw."""
    if marker is not None:
        return _nearest(np.einsum("nij,nkj->ik", seen, R @ marker.R))
    # R_IW = R_M R_EMᵀ R_Eᵀ, entry by entry, added up over the poses
    matrix = np.einsum("ncd,nab->cadb", seen, R).reshape(9, 9)
    X = np.linalg.svd(matrix)[0][:, 0].reshape(3, 3)
    return _nearest(X if np.linalg.det(X) > 0.0 else -X)
