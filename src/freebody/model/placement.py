"""Constant poses: a chain of shifts and turns, whose entries may be parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.lazy import Keeps
from freebody.model.parameters import Quantity, each_parameter
from freebody.model.quantity_reader import EXACT, VALUES, QuantityReader, exact_sin_cos
from freebody.spatial import AnySpace, Matrix, Vector, add, identity, of_dimension, product, times

_LONGEST = 24
"""Steps that a placement keeps one by one. Links fixed to one another in a row would otherwise,
each with all the steps to it, take time and memory that grow with their number squared."""


ArrayPose = tuple[Array, Array]
"""A rotation (dim, dim) and a position (dim,)."""


@dataclass(frozen=True)
class Shift:
    """Translation by a constant vector (m), in the axes reached so far."""

    by: tuple[Quantity, ...]


@dataclass(frozen=True)
class AxisRotation:
    """Rotation about one of the axes reached so far by a constant angle (rad)."""

    axis: str
    angle: Quantity


@dataclass(frozen=True)
class Rotate:
    """A constant rotation matrix."""

    matrix: Matrix


@dataclass(frozen=True)
class Placement(Keeps):
    """A constant pose T_AB: the steps that lead from frame A to frame B, first step first."""

    steps: tuple[Shift | AxisRotation | Rotate, ...] = ()

    def then(self, other: Placement) -> Placement:
        """The placement T_AB T_BC; where one of the two has no steps the other object itself, which
        keeps what has been computed for it."""
        if not (self.steps and other.steps):
            return self if self.steps else other
        return Placement(self.steps + other.steps)

    def folded(self, space: AnySpace) -> Placement:
        """The pose in few steps: of long chains, successive numeric steps are combined to one shift
        and one rotation."""
        if len(self.steps) <= _LONGEST:
            return self
        steps: list[Shift | AxisRotation | Rotate] = []
        for named, together in groupby(self.steps, key=lambda step: any(each_parameter(step))):
            run = tuple(together)
            steps += run if named else _as_numbers(Placement(run), space)
        return Placement(tuple(steps))

    def arrays(self, dim: int = 3) -> ArrayPose:
        """The rotation and position as arrays, of a pose in which every parameter has a value."""
        R, p = self.lower(of_dimension(dim), VALUES)
        return np.array(R, dtype=float), np.array(p, dtype=float)

    def lower(self, space: AnySpace, reader: QuantityReader) -> tuple[Matrix, Vector]:
        """The rotation and position (R_AB, p_AB) in scalars."""
        R: Matrix | None = (
            None  # most placements turn once at most, and a changed length is to cost little
        )
        p: Vector = space.zero
        for step in self.steps:
            if isinstance(step, Shift):
                if step.by == space.zero:
                    continue
                by = tuple(reader.quantities(step.by))
                p = add(p, by if R is None else times(R, by))
                continue
            if isinstance(step, Rotate):
                turn = reader.rotation(step.matrix)
            else:
                s, c = reader.sin_cos(step.angle)
                if type(s) is float and s == 0.0 and c == 1.0:
                    continue
                turn = ((c, -s), (s, c)) if space.dim == 2 else about(step.axis, s, c)
            R = turn if R is None else product(R, turn)
        return identity(space.dim) if R is None else R, p


def _as_numbers(placement: Placement, space: AnySpace) -> tuple[Shift | Rotate, ...]:
    R, p = placement.lower(space, VALUES)
    return (Shift(p), Rotate(R))


def about(axis: str, s: Scalar, c: Scalar) -> Matrix:
    """Rotation about a coordinate axis with sine s and cosine c."""
    return {
        "x": ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)),
        "y": ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)),
        "z": ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)),
    }[axis]


def shift(*by: Quantity) -> Placement:
    """A translation; no steps at all where it is zero."""
    return Placement((Shift(tuple(by)),)) if any(x != 0.0 for x in by) else Placement()


def turn(axis: str, angle: Quantity) -> Placement:
    """A rotation about a coordinate axis; no steps at all where it is zero."""
    return Placement((AxisRotation(axis, angle),)) if angle != 0.0 else Placement()


def rotate(matrix: Sequence[Sequence[float]] | np.ndarray, owner: str = "rotation") -> Placement:
    """A placement by a rotation matrix; no steps at all where it is the unit matrix; refuses
    matrices that are no rotations."""
    R = rotation_matrix(matrix, owner)
    if np.array_equal(R, np.eye(len(R))):
        return Placement()
    return Placement((Rotate(tuple(tuple(float(x) for x in row) for row in R)),))


def rotation_matrix(matrix: Sequence[Sequence[float]] | np.ndarray, owner: str) -> np.ndarray:
    """The matrix (2, 2) or (3, 3) as an array; refuses what is not a rotation."""
    R = np.asarray(matrix, dtype=float)
    if (
        R.shape not in ((2, 2), (3, 3))
        or not np.allclose(R @ R.T, np.eye(len(R)), atol=1e-9)
        or np.linalg.det(R) < 0
    ):
        raise ModelError(f"{owner}: the matrix is not a rotation (R Rᵀ = 1, det R = 1).")
    return R


def rpy(roll: float, pitch: float, yaw: float, snap: float = EXACT) -> Placement:
    """URDF's fixed-axis roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll); right angles within
    `snap` are exact."""
    R: Matrix = identity(3)
    for axis, angle in (("z", yaw), ("y", pitch), ("x", roll)):
        R = product(R, about(axis, *exact_sin_cos(angle, snap)))
    return Placement() if identity(3) == R else Placement((Rotate(R),))


def composed(outer: ArrayPose, inner: ArrayPose) -> ArrayPose:
    """A pose in a frame that is itself placed."""
    return outer[0] @ inner[0], outer[0] @ inner[1] + outer[1]


def seen_from(outer: ArrayPose, inner: ArrayPose) -> ArrayPose:
    """The inner pose expressed in the outer one, both placed in one frame."""
    back = outer[0].T
    return back @ inner[0], back @ (inner[1] - outer[1])
