"""Limits of the torques that reach joints which follow others, along paths of open chains.

At a point of a path such a torque is a s̈ + b ṡ² + v ṡ + d + c as those of the coordinates are:
with q̇ = q' ṡ and q̈ = q' s̈ + q" ṡ² its parts follow from its values at few ṡ and s̈. What is even
in ṡ has no friction in it, and what is odd has nothing else: v is viscous friction, d dry.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from freebody.any_chain.effort_limits import Followers, followers
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.optimal.geometric_path import PathSamples
from freebody.motion.ranges import Flags, angular


@dataclass(frozen=True, eq=False)
class FollowerLimits:
    """The followers of a robot that have effort limits, n of them, under constant wrenches on
    frames; `following` is None where there are none."""

    following: Followers | None
    wrenches: Mapping[str, Array]

    @staticmethod
    def of(model: Model, wrenches: Mapping[str, Array]) -> FollowerLimits:
        """The limits of a model's followers; of a closed chain, along whose paths the forces of
        loops are not followed up to them, none."""
        return FollowerLimits(None if model.loops else followers(model), wrenches)

    @property
    def names(self) -> tuple[str, ...]:
        """The names (n) of the joints."""
        return () if self.following is None else self.following.names

    @property
    def size(self) -> Array:
        """Limits (n,) of the torques and forces that reach the following joints."""
        return np.zeros(0) if self.following is None else self.following.limits

    @property
    def turns(self) -> Flags:
        """Whether each joint (n,) turns."""
        if self.following is None:
            return np.zeros(0, dtype=bool)
        return angular(self.following.freed)[self.following.columns]

    def torques(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The torques (..., n) that reach the joints in a motion, friction included."""
        if self.following is None:
            return np.zeros((*q.shape[:-1], 0))
        return self.following.torques(q, qd, qdd, dict(self.wrenches) or None)

    def rows(self, at: PathSamples, kept: float) -> tuple[Array, ...]:
        """Arrays a, b, lo, hi (T, P, n) as of `RobotLimits.rows`, without friction."""
        q, first, second = at.q, at.first, at.second
        still = 0.0 * first
        rest = self.torques(q, still, still)
        a = self.torques(q, still, first) - rest
        b = 0.5 * (self.torques(q, first, second) + self.torques(q, -first, second)) - rest
        return a, b, -kept * self.size - rest, kept * self.size - rest

    def friction(self, q: Array, first: Array) -> tuple[Array, Array]:
        """The viscous friction for each ṡ, and the dry friction (..., n) at positions where ṡ is
        above 0; first: q' there."""
        once, twice = (
            0.5
            * (self.torques(q, k * first, 0.0 * first) - self.torques(q, -k * first, 0.0 * first))
            for k in (1.0, 2.0)
        )
        return twice - once, 2.0 * once - twice
