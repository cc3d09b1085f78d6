"""The joints on the way to a frame as screws in the world, with the arm at zero: T(x) = e^(S1 x1) …
e^(Sn xn) T(0).

Whatever frames a file or a convention chose, the screws are the same; closed forms are found by
looking at them (Brockett 1984; Murray, Li, Sastry, A Mathematical Introduction to Robotic
Manipulation, 1994, ch. 3). A planar arm lies in the plane z = 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import compose, identity

SAME = 1e-9
"""Axes this close (rad), and points this close (in arm lengths), count as one."""


@dataclass(frozen=True, eq=False)
class Screw:
    """A joint at zero: unit axis w (3,) through the point p (3,), turning or sliding; world axes,
    m."""

    turning: bool
    w: Array
    p: Array
    rest: Scalar = 0.0
    """Where it stands (rad) if a target leaves that open."""

    def undone(self) -> Screw:
        """The joint of the arm seen from its tip, which turns and slides the other way."""
        return replace(self, rest=-self.rest)

    def moved(self, x: Array, points: Array) -> Array:
        """e^(S x) applied to points (..., 3); x (...) in rad or m."""
        x = np.asarray(x)[..., None]
        if not self.turning:
            return points + x * self.w
        arm = points - self.p
        along = (arm @ self.w)[..., None] * self.w
        return self.p + along + np.cos(x) * (arm - along) + np.sin(x) * (arm @ _cross(self.w))

    def turned(self, x: Array, vectors: Array) -> Array:
        """The rotation of e^(S x) applied to vectors (..., 3)."""
        return (
            Screw(self.turning, self.w, np.zeros(3)).moved(x, vectors) if self.turning else vectors
        )

    def rotation(self, x: Array) -> Array:
        """Rotation matrix (..., 3, 3) of e^(S x), x (...)."""
        columns = [
            self.turned(np.asarray(x), np.broadcast_to(e, (*np.shape(x), 3))) for e in np.eye(3)
        ]
        return np.stack(columns, axis=-1)


def _cross(w: Array) -> Array:
    """The matrix that turns a row v into w × v."""
    return np.array([[0.0, w[2], -w[1]], [-w[2], 0.0, w[0]], [w[1], -w[0], 0.0]])


@dataclass(frozen=True, eq=False)
class ScrewChain:
    """Screws from the base to a frame, its pose R (3, 3), p (3,) at zero, and which coordinate
    moves which screw."""

    screws: tuple[Screw, ...]
    R: Array
    p: Array
    index: np.ndarray
    """For each screw its place in q; x = ratio q[index] + offset."""
    ratio: Array
    offset: Array
    length: float
    """Distances from joint to joint and to the frame, added up (m); 1 where they are all zero."""

    def resting(self, x: Sequence[Scalar]) -> ScrewChain:
        """The chain whose joints stand at x (n,) where a target does not determine them."""
        at = zip(self.screws, x, strict=True)
        return replace(self, screws=tuple(replace(s, rest=value) for s, value in at))

    def coordinates(self, x: Array, rest: Array) -> Array:
        """Positions q (..., nq) of the robot from those x (..., n) of the chain's joints; joints
        that do not move the frame stand as in `rest` (nq,)."""
        q = np.broadcast_to(rest, (*x.shape[:-1], len(rest))).copy()
        q[..., self.index] = (x - self.offset) / self.ratio
        return q

    def positions(self, q: Array) -> Array:
        """Positions x (..., n) of the chain's joints at q (..., nq)."""
        return q[..., self.index] * self.ratio + self.offset


def chain_to(tree: Tree, frame: str) -> ScrewChain | None:
    """The screws to a frame of a tree of numbers; None where a joint has several coordinates of its
    own, or two share one, or turns and slides at once, or follows by a polynomial."""
    body, R, p = tree.frames[frame]
    path = ancestors(tree, body)[::-1]
    at = [tree.bodies[i].coordinates for i in path]
    places = [c.q for c in at]
    if any(tree.bodies[i].primitive.turns == tree.bodies[i].primitive.slides for i in path):
        return None
    index = [k for place in places for k in place]
    if len(set(index)) < len(index) or not index or any(c.powers for c in at):
        return None
    pose = (identity(tree.space.dim), tree.space.zero)
    screws, points = [], []
    for i in path:
        pose = compose(pose, (tree.bodies[i].R, tree.bodies[i].p))
        screws.append(_screw(tree, i, *pose))
        points.append(screws[-1].p)
    home_R, home_p = _in_space(*compose(pose, (R, p)))
    steps = np.diff(np.array([*points, home_p]), axis=0)
    return ScrewChain(
        tuple(screws),
        home_R,
        home_p,
        np.array(index),
        np.array([c.ratio for c in at]),
        np.array([c.offset for c in at]),
        float(np.linalg.norm(steps, axis=-1).sum()) or 1.0,
    )


def arm_length(tree: Tree, frame: str) -> float:
    """Distances from joint to joint on the way to a frame, added up (m); 1 where they are all
    zero."""
    body, _, p = tree.frames[frame]
    offsets = [p, *(tree.bodies[i].p for i in ancestors(tree, body)[:-1])]
    return sum(math.hypot(*x) for x in offsets) or 1.0


def _screw(tree: Tree, i: int, R: tuple, p: tuple) -> Screw:
    body = tree.bodies[i]
    R3, p3 = _in_space(R, p)
    axis = np.array(body.axis, dtype=float)
    turning = body.primitive.turns
    if tree.space.dim == 2:
        axis = np.array([0.0, 0.0, axis[0]]) if turning else np.array([*axis, 0.0])
    return Screw(turning, R3 @ axis, p3)


def _in_space(R: tuple, p: tuple) -> tuple[Array, Array]:
    """A pose as arrays (3, 3), (3,); one in the plane put into z = 0."""
    n = len(p)
    R3, p3 = np.eye(3), np.zeros(3)
    R3[:n, :n], p3[:n] = np.array(R, dtype=float), np.array(p, dtype=float)
    return R3, p3
