"""The joints between two frames of a planar chain, and postures: the chain's places in many
samples."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import ancestors, frame_pose, joint_poses, world_poses
from freebody.arrays import Array
from freebody.lazy import cached_property
from freebody.model.tree import Tree
from freebody.spatial import times

Crossing = tuple[int, float]
"""A joint on the way from the first end to the second, and the sign with which it moves what comes
behind."""


@dataclass(frozen=True)
class Chain:
    """The joints between two frames that meet, or stay `distance` apart; the first may be a target,
    None."""

    name: str
    ends: tuple[str | None, str]
    path: tuple[Crossing, ...]
    distance: float = 0.0

    @property
    def frames(self) -> tuple[str, ...]:
        """Ends of the chain that are frames of the robot."""
        return tuple(end for end in self.ends if end is not None)


def chain(tree: Tree, name: str, ends: tuple[str | None, str], distance: float = 0.0) -> Chain:
    """The chain between two frames of a tree."""
    first, second = (
        ancestors(tree, tree.frames[frame][0]) if frame is not None else [] for frame in ends
    )
    up = [(i, -1.0) for i in first if i not in second]
    down = [(i, 1.0) for i in reversed(second) if i not in first]
    return Chain(name, ends, (*up, *down), distance)


def is_turning(tree: Tree, crossing: Crossing) -> bool:
    """Whether a joint on the way turns; else it slides."""
    return tree.bodies[crossing[0]].primitive.turns


def coordinate(tree: Tree, crossing: Crossing) -> int:
    """The index in q of the coordinate of a joint on the way."""
    return tree.bodies[crossing[0]].coordinates.q[0]


def coordinates(tree: Tree, crossings: Iterable[Crossing]) -> set[int]:
    """The indices in q of the coordinates of several joints on the way."""
    return {coordinate(tree, crossing) for crossing in crossings}


Complex = NDArray[np.complexfloating]


@dataclass(frozen=True, eq=False)
class Posture:
    """Positions q (N, K, nq) with the places of all bodies at them; target: points (N, 1), angle:
    directions (N, 1)."""

    tree: Tree
    q: Array
    target: Complex | None = None
    angle: Array | None = None

    @cached_property
    def world(self) -> list:
        """Poses of all bodies in the world."""
        return world_poses(self.tree, joint_poses(self.tree, tuple(np.moveaxis(self.q, -1, 0))))

    def point(self, frame: str | None) -> Complex:
        """The origin of a frame, as complex numbers (N, K); of None the target."""
        if frame is None:
            assert self.target is not None
            return np.broadcast_to(self.target, self.q.shape[:-1])
        return self._complex(frame_pose(self.tree, self.world, frame)[1])

    def heading(self, frame: str) -> Array:
        """The angle of a frame's x axis (rad)."""
        R, _ = frame_pose(self.tree, self.world, frame)
        return np.asarray(np.angle(self._complex((R[0][0], R[1][0]))), dtype=float)

    def pivot(self, body: int) -> Complex:
        """The place of a joint in the world, as complex numbers."""
        return self._complex(self.world[body][1])

    def slide(self, crossing: Crossing) -> Complex:
        """Unit vector along which a sliding joint moves what comes behind."""
        body, sign = crossing
        return sign * self._complex(times(self.world[body][0], self.tree.bodies[body].axis))

    def turned(self, *turns: tuple[Crossing, Array]) -> Array:
        """The positions q after turning joints so that the bodies behind them turn by the given
        angles."""
        q = np.array(self.q)
        for (body, sign), angle in turns:
            (w,), _ = self.tree.bodies[body].columns[0]
            q[..., coordinate(self.tree, (body, sign))] += sign * w * angle
        return q

    def slid(self, crossing: Crossing, way: Array) -> Array:
        """The positions q after moving a slide along its own axis, so that the bodies behind it
        move by a given length."""
        q = np.array(self.q)
        q[..., coordinate(self.tree, crossing)] += way
        return q

    def moved(self, q: Array) -> Posture:
        """The posture of other positions, with the same target."""
        return Posture(self.tree, q, self.target, self.angle)

    def _complex(self, p: tuple) -> Complex:
        return np.broadcast_to(np.asarray(p[0] + 1j * np.asarray(p[1])), self.q.shape[:-1])
