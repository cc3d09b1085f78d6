"""Tasks of a frame: the rows of its motion that count, the targets, and how far a pose is from a
target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError, UnknownNameError
from freebody.kernels.formula_variants import motion_rows
from freebody.model.model import Model
from freebody.outputs.number_text import weighted_sum

TASKS = ("position", "orientation", "pose")
_ROTATION = 1e-6  # how far a target's rotation may be from orthogonal


@dataclass(frozen=True)
class Task:
    """Rows of a frame's motion, linear ones first, world axes."""

    dim: int
    rows: tuple[int, ...]

    @property
    def linear(self) -> tuple[int, ...]:
        """Rows of the task that are positions."""
        return tuple(r for r in self.rows if r < self.dim)

    @property
    def angular(self) -> tuple[int, ...]:
        """The rows of orientation, counted from 0 in space; 2 in the plane."""
        return tuple(r - 3 if self.dim == 3 else 2 for r in self.rows if r >= self.dim)

    @property
    def places(self) -> bool:
        """Whether the task counts the whole position."""
        return len(self.linear) == self.dim

    @property
    def turns(self) -> bool:
        """Whether the task counts the whole orientation."""
        return len(self.angular) == (3 if self.dim == 3 else 1)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the task's rows."""
        return tuple(row_names(self.dim)[r] for r in self.rows)

    def error(self, T: Array, target: Array) -> Array:
        """The error (..., r) from a pose T to the target in the counted rows: position (m) and
        rotation vector (rad), world axes."""
        d = self.dim
        shift = target[..., :d, d] - T[..., :d, d]
        turn = target[..., :d, :d] @ np.swapaxes(T[..., :d, :d], -1, -2)
        return np.concatenate([shift, rotation_vector(turn)], axis=-1)[..., list(self.rows)]

    def miss(self, T: Array, target: Array) -> Array:
        """The larger (...) of distance (m) and angle (rad) between a pose and a target, in the
        counted rows."""
        return self.size(self.error(T, target))

    def size(self, error: Array) -> Array:
        """The larger (...) of distance (m) and angle (rad) of an error (..., r)."""
        k = len(self.linear)
        parts = [np.linalg.norm(part, axis=-1) for part in (error[..., :k], error[..., k:])]
        return np.maximum(*parts)


def row_names(dim: int) -> tuple[str, ...]:
    """Names of all rows of a frame's motion."""
    return ("vx", "vy", "vz", "wx", "wy", "wz") if dim == 3 else ("vx", "vy", "w")


def combined_rates(factors: Array, names: Sequence[str]) -> str:
    """A combination of rates as text, such as vx + 0.309 vy - 2 w, from factors and names."""
    terms = zip(names, np.asarray(factors).tolist(), strict=True)
    return weighted_sum([(name, x) for name, x in terms if abs(x) > 1e-9], 3)


def rows_of(function: str, model: Model, task: str | Sequence[str]) -> tuple[int, ...]:
    """Indices of the rows that a task names: "position", "orientation", "pose", or rows one by
    one."""
    names = row_names(model.dim)
    if isinstance(task, str):
        if task not in TASKS:
            if task in names:
                return motion_rows(model, (task,))
            raise UnknownNameError("task", task, function, (*TASKS, *names))
        first, last = {
            "position": (0, model.dim),
            "orientation": (model.dim, None),
            "pose": (0, None),
        }[task]
        return motion_rows(model, names[first:last])
    rows = motion_rows(model, tuple(task))
    if not rows or len(set(rows)) < len(rows):
        raise FreebodyError(f"{function}: task must name rows, each once; got {tuple(task)}.")
    return tuple(sorted(rows))


def read_target(
    function: str, model: Model, target: ArrayLike, task: str | Sequence[str] | None
) -> tuple[Task, Array]:
    """The task, and the targets as poses (..., dim + 1, dim + 1); parts that a target does not give
    are those of the identity."""
    d = model.dim
    given = as_floats(function, "target", target)
    matrices = ((d + 1, d + 1), (d, d)) if task == "orientation" else ((d + 1, d + 1),)
    refuse_not_finite(function, "target", given, 2 if given.shape[-2:] in matrices else 1)
    poses, kind = _poses(given, d)
    if poses is None:
        point, pose, turn = f"(..., {d})", f"(..., {d + 1}, {d + 1})", f"(..., {d}, {d})"
        raise ShapeError(
            function,
            "target",
            given.shape,
            f"a point {point} or a pose {pose}",
            f'a rotation {turn} is taken with task="orientation"' if task == "orientation" else "",
        )
    if task == "orientation" and kind == "point" and given.shape[-2:] == (d, d):
        poses, kind = _embedded(given, d), "rotation"
    rows = rows_of(function, model, task or {"point": "position", "pose": "pose"}[kind])
    chosen = Task(d, rows)
    if kind == "point" and chosen.angular:
        raise FreebodyError(
            f"{function}: the target is a point, but the task counts {', '.join(chosen.names)}; "
            f"give a pose (..., {d + 1}, {d + 1})."
        )
    return chosen, _orthogonal(function, poses, d)


def _poses(given: Array, d: int) -> tuple[Array | None, str]:
    shape = given.shape
    if len(shape) >= 2 and shape[-2:] == (d + 1, d + 1):
        return given.copy(), "pose"
    if shape[-1:] == (d,):
        poses = np.broadcast_to(np.eye(d + 1), (*shape[:-1], d + 1, d + 1)).copy()
        poses[..., :d, d] = given
        return poses, "point"
    return None, ""


def _embedded(R: Array, d: int) -> Array:
    poses = np.broadcast_to(np.eye(d + 1), (*R.shape[:-2], d + 1, d + 1)).copy()
    poses[..., :d, :d] = R
    return poses


def _orthogonal(function: str, poses: Array, d: int) -> Array:
    """Poses with their rotations made exactly orthogonal; refuses matrices that are no
    rotations."""
    R = poses[..., :d, :d]
    off = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(d)).max(initial=0.0)
    last = np.abs(poses[..., d, :] - np.eye(d + 1)[d]).max(initial=0.0)
    if off > _ROTATION or last > _ROTATION or np.any(np.linalg.det(R) < 0):
        raise FreebodyError(
            f"{function}: target is not a pose: its rotation must satisfy R Rᵀ = 1 within 1e-6 and "
            f"det R = 1, its last row be {(*[0] * d, 1)}."
        )
    if off > 1e-15:
        U, _, V = np.linalg.svd(R)
        poses[..., :d, :d] = U @ V
    return poses


def rotation_vector(R: Array) -> Array:
    """Axis times angle (..., 3) of rotations (..., 3, 3); the angle (..., 1) of (..., 2, 2)."""
    if R.shape[-1] == 2:
        return np.arctan2(R[..., 1, 0] - R[..., 0, 1], R[..., 0, 0] + R[..., 1, 1])[..., None]
    v = np.stack(
        [R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]],
        axis=-1,
    )
    s = np.sqrt(np.sum(v * v, axis=-1))
    c = np.trace(R, axis1=-2, axis2=-1) - 1.0
    half_turn = (s < 1e-7) & (c < 0)
    factor = np.where(s > 1e-12, np.arctan2(s, c) / np.where(s > 0, s, 1.0), 0.5)
    vector = factor[..., None] * v
    if half_turn.any():
        k = np.argmax(np.diagonal(R, axis1=-2, axis2=-1), axis=-1)
        column = np.take_along_axis(R + np.eye(3), k[..., None, None], axis=-1)[..., 0]
        axis = column / np.linalg.norm(column, axis=-1, keepdims=True)
        vector = np.where(half_turn[..., None], np.pi * axis, vector)
    return vector
