"""Free-body balance: do the joint reactions, with weight, give each body the motion that it has?

ΣF = m a and ΣM = Ḣ about each body's joint origin (notes 3.1, 3.2, 6.1, 6.2). Accelerations come from the poses as
second-order jets in time, and the rate of angular momentum from R̈ P Rᵀ, with P = ½ tr(I) 1 - I the second moments: its
antisymmetric part is Σ r × r̈ dm. Nothing of the Newton-Euler recursion enters.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.tree import TreeBody
from freebody.motion.coordinates import layout, position_acceleration, position_rate
from freebody.motion.motion import Motion
from freebody.report.jets import Jet, stacked

if TYPE_CHECKING:
    import xarray as xr


def balance(model: Model, motion: Motion, data: xr.Dataset) -> tuple[Array, Array, float, float]:
    """(ΣF - m a (T, nj, dim), ΣM - Ḣ (T, nj, 3 or 1), largest force, largest moment that entered)."""
    force, moment = data["reaction_force"].values, data["reaction_moment"].values
    origin = data["body_origin"].values
    needed_force, needed_moment = inertia_forces(model, motion)
    left_force, left_moment = force - needed_force, moment - needed_moment
    lever = np.zeros(moment.shape)
    for child, body in enumerate(model.bodies):
        if body.parent >= 0:
            arm = origin[:, child] - origin[:, body.parent]
            turned = cross(arm, force[:, child])
            left_force[:, body.parent] -= force[:, child]
            left_moment[:, body.parent] -= moment[:, child] + turned
            lever[:, child] = np.abs(turned)
    largest_force = max(np.abs(force).max(), np.abs(needed_force).max())
    largest_moment = max(np.abs(moment).max(), np.abs(needed_moment).max(), lever.max())
    return left_force, left_moment, float(largest_force), float(largest_moment)


def inertia_forces(model: Model, motion: Motion) -> tuple[Array, Array]:
    """What the joints must exert on each body: m (a - g), and Ḣ - c × m g about its joint's origin, world axes."""
    tree, T = model.tree, len(motion.t)
    where = layout(model)
    x, xd, xdd = (
        motion.q,
        position_rate(where, motion.q, motion.qd),
        position_acceleration(where, motion.q, motion.qd, motion.qdd),
    )
    q = tuple(Jet(x[:, k], xd[:, k], xdd[:, k]) for k in range(model.nq))
    world = world_poses(tree, joint_poses(tree, q))
    forces, moments = [], []
    for i in tree.body_of:
        R, p = world[i]
        f, n = _needed(tree.bodies[i], stacked(R, T), stacked(p, T), np.array(tree.gravity))
        forces.append(f)
        moments.append(n)
    return np.stack(forces, axis=1), np.stack(moments, axis=1)


def _needed(
    body: TreeBody, R: tuple[Array, ...], p: tuple[Array, ...], gravity: Array
) -> tuple[Array, Array]:
    dim = len(gravity)
    force = np.zeros((len(p[0]), dim))
    moment = np.zeros((len(p[0]), 3 if dim == 3 else 1))
    for mass in body.masses:
        c = np.array(mass.c)
        f = mass.m * (p[2] + R[2] @ c - gravity)
        inertia = np.array(mass.inertia)
        second = 0.5 * np.trace(inertia) * np.eye(3) - inertia if dim == 3 else 0.5 * inertia * np.eye(2)
        force += f
        moment += cross(R[0] @ c, f) + axial(R[2] @ second @ np.swapaxes(R[0], -1, -2))
    return force, moment


def axial(A: Array) -> Array:
    """Σ r × a of A = Σ a rᵀ (..., n, n): (..., 3), or (..., 1) in the plane."""
    turns = [(2, 1), (0, 2), (1, 0)] if A.shape[-1] == 3 else [(1, 0)]
    return np.stack([A[..., i, j] - A[..., j, i] for i, j in turns], axis=-1)


def cross(r: Array, f: Array) -> Array:
    """r × f, (..., 3) or (..., 1)."""
    if r.shape[-1] == 3:
        return np.cross(r, f)
    return (r[..., 0] * f[..., 1] - r[..., 1] * f[..., 0])[..., None]
