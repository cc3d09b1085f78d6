"""What must act on a free body so that it moves as it does: ΣF = m a and ΣM = Ḣ about its joint's origin.

Notes 3.1, 3.2, 6.1, 6.2. Accelerations come from the poses as second-order jets in time, and the rate of angular
momentum from R̈ P Rᵀ, with P = ½ tr(I) 1 - I the second moments: its antisymmetric part is Σ r × r̈ dm. Nothing of the
Newton-Euler recursion enters, so this checks reactions by other means than those they were found by.
"""

from __future__ import annotations

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.tree import TreeBody
from freebody.numerics.coordinates import layout, position_acceleration, position_rate
from freebody.numerics.jets import Jet, stacked


def inertia_forces(model: Model, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array, Array]:
    """What must act on each body: m (a - g) (T, nj, dim), and Ḣ - c × m g about its joint's origin (T, nj, 3 or 1).

    World axes; the last is where the joints' origins are (T, nj, dim). q: (T, nq); qd, qdd: (T, nv).
    """
    tree, T = model.tree, len(q)
    where = layout(model)
    x, xd, xdd = q, position_rate(where, q, qd), position_acceleration(where, q, qd, qdd)
    jets = tuple(Jet(x[:, k], xd[:, k], xdd[:, k]) for k in range(model.nq))
    world = world_poses(tree, joint_poses(tree, jets))
    forces, moments, origins = [], [], []
    for i in tree.body_of:
        R, p = (stacked(part, T) for part in world[i])
        f, n = _needed(tree.bodies[i], R, p, np.array(tree.gravity))
        forces.append(f)
        moments.append(n)
        origins.append(p[0])
    return np.stack(forces, axis=1), np.stack(moments, axis=1), np.stack(origins, axis=1)


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
