"""Where everything is, in many samples and solutions at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import frame_pose, joint_poses, world_poses
from freebody.arrays import Array
from freebody.lazy import cached_property
from freebody.loops.dyads.chain import Crossing, coordinate
from freebody.model.tree import Tree
from freebody.spatial import times

Complex = NDArray[np.complexfloating]


@dataclass(frozen=True, eq=False)
class Posture:
    """Positions q (N, K, nq) and where everything is; target: points (N, 1), angle: directions (N,
    1)."""

    tree: Tree
    q: Array
    target: Complex | None = None
    angle: Array | None = None

    @cached_property
    def world(self) -> list:
        """Poses of all bodies."""
        return world_poses(self.tree, joint_poses(self.tree, tuple(np.moveaxis(self.q, -1, 0))))

    def point(self, frame: str | None) -> Complex:
        """Origin of a frame, or the target."""
        if frame is None:
            assert self.target is not None
            return np.broadcast_to(self.target, self.q.shape[:-1])
        return self._complex(frame_pose(self.tree, self.world, frame)[1])

    def heading(self, frame: str) -> Array:
        """Angle of a frame's x axis."""
        R, _ = frame_pose(self.tree, self.world, frame)
        return np.asarray(np.angle(self._complex((R[0][0], R[1][0]))), dtype=float)

    def pivot(self, body: int) -> Complex:
        """Where a joint is."""
        return self._complex(self.world[body][1])

    def slide(self, crossing: Crossing) -> Complex:
        """Unit vector along which a sliding joint moves what comes behind."""
        body, sign = crossing
        return sign * self._complex(times(self.world[body][0], self.tree.bodies[body].axis))

    def turned(self, *turns: tuple[Crossing, Array]) -> Array:
        """q with joints turned by angles of what comes behind them."""
        q = np.array(self.q)
        for (body, sign), angle in turns:
            (w,), _ = self.tree.bodies[body].columns[0]
            q[..., coordinate(self.tree, (body, sign))] += sign * w * angle
        return q

    def slid(self, crossing: Crossing, way: Array) -> Array:
        """q with a joint slid by a way of what comes behind it, along its own axis."""
        q = np.array(self.q)
        q[..., coordinate(self.tree, crossing)] += way
        return q

    def moved(self, q: Array) -> Posture:
        """The same target with other positions."""
        return Posture(self.tree, q, self.target, self.angle)

    def _complex(self, p: tuple) -> Complex:
        return np.broadcast_to(np.asarray(p[0] + 1j * np.asarray(p[1])), self.q.shape[:-1])
