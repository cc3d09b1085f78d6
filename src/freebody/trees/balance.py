"""What must act on a free body so that it moves as it does: ΣF = m a and ΣM = Ḣ about its joint's origin.

Notes 3.1, 3.2, 6.1, 6.2. Accelerations come from the poses as second-order jets in time, and the rate of angular
momentum from R̈ P Rᵀ, with P = ½ tr(I) 1 - I the second moments: its antisymmetric part is Σ r × r̈ dm. Nothing of the
Newton-Euler recursion enters, so this checks reactions by other means than those they were found by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.model.model import Model
from freebody.model.tree import TreeBody
from freebody.trees.coordinates import layout, position_acceleration, position_rate
from freebody.trees.jets import Jet, stacked
from freebody.trees.kinematics import forward_kinematics


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


@dataclass(frozen=True)
class Balance:
    """ΣF - m a (T, nj, dim) and ΣM - Ḣ (T, nj, 3 or 1) of every body, and the largest force and moment that entered."""

    force: Array
    moment: Array
    largest_force: float
    largest_moment: float


def balance(
    model: Model, q: Array, qd: Array, qdd: Array, wrenches: Array, external: Mapping[str, Array]
) -> Balance:
    """How well reactions and external wrenches, world axes, explain a motion q (T, nq), qd, qdd (T, nv).

    wrenches: (T, joints and loops, six), as `reactions` gives them; external: {frame: (T, six)}.
    """
    dim = model.dim
    force, moment, origin = inertia_forces(model, q, qd, qdd)
    left_force, left_moment = -force, -moment
    forces, moments = [force], [moment]

    def act(body: int, f: Array, n: Array, place: Array) -> None:
        if body >= 0:
            turned = cross(place - origin[:, body], f)
            left_force[:, body] += f
            left_moment[:, body] += n + turned
            forces.append(f)
            moments.extend((n, turned))

    def place_of(frame: str) -> Array:
        return forward_kinematics(model, q, frame)[:, :dim, dim]

    links = [(k, body.parent, origin[:, k]) for k, body in enumerate(model.bodies)]
    for loop in model.loops:
        first, second = (model.frame(name).body for name in loop.frames)
        links.append((second, first, place_of(loop.frames[1])))
    for k, (on, by, place) in enumerate(links):
        f, n = wrenches[:, k, :dim], wrenches[:, k, dim:]
        act(on, f, n, place)
        act(by, -f, -n, place)
    for name, load in external.items():
        act(model.frame(name).body, load[:, :dim], load[:, dim:], place_of(name))
    sizes = (max(float(np.abs(x).max(initial=0.0)) for x in kind) for kind in (forces, moments))
    return Balance(left_force, left_moment, *sizes)


def axial(A: Array) -> Array:
    """Σ r × a of A = Σ a rᵀ (..., n, n): (..., 3), or (..., 1) in the plane."""
    turns = [(2, 1), (0, 2), (1, 0)] if A.shape[-1] == 3 else [(1, 0)]
    return np.stack([A[..., i, j] - A[..., j, i] for i, j in turns], axis=-1)


def cross(r: Array, f: Array) -> Array:
    """r × f, (..., 3) or (..., 1)."""
    if r.shape[-1] == 3:
        return np.cross(r, f)
    return (r[..., 0] * f[..., 1] - r[..., 1] * f[..., 0])[..., None]
