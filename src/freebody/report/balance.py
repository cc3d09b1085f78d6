"""Free-body balance of a study: do the joint reactions, with weight, give each body the motion that it has?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.numerics.balance import cross, inertia_forces
from freebody.numerics.kinematics import forward_kinematics

if TYPE_CHECKING:
    import xarray as xr


def balance(model: Model, motion: Motion, data: xr.Dataset) -> tuple[Array, Array, float, float]:
    """(ΣF - m a (T, nj, dim), ΣM - Ḣ (T, nj, 3 or 1), largest force, largest moment that entered)."""
    force, moment = data["reaction_force"].values, data["reaction_moment"].values
    needed_force, needed_moment, origin = inertia_forces(model, motion.q, motion.qd, motion.qdd)
    joints = len(model.bodies)
    left_force, left_moment = force[:, :joints] - needed_force, moment[:, :joints] - needed_moment
    lever = np.zeros(moment.shape)
    for child, body in enumerate(model.bodies):
        if body.parent >= 0:
            arm = origin[:, child] - origin[:, body.parent]
            turned = cross(arm, force[:, child])
            left_force[:, body.parent] -= force[:, child]
            left_moment[:, body.parent] -= moment[:, child] + turned
            lever[:, child] = np.abs(turned)
    for k, loop in enumerate(model.loops, start=len(model.bodies)):
        first, second = (model.frame(name).body for name in loop.frames)
        point = forward_kinematics(model, motion.q, loop.frames[1])[:, : model.dim, model.dim]
        for body, sign in ((second, 1.0), (first, -1.0)):
            if body >= 0:
                left_force[:, body] += sign * force[:, k]
                left_moment[:, body] += sign * (moment[:, k] + cross(point - origin[:, body], force[:, k]))
    largest_force = max(np.abs(force).max(), np.abs(needed_force).max())
    largest_moment = max(np.abs(moment).max(), np.abs(needed_moment).max(), lever.max())
    return left_force, left_moment, float(largest_force), float(largest_moment)
