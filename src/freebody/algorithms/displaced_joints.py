"""Inverse dynamics by the places of joints: by how much torques change where a joint stands a
little off, or is turned a little.

Such a displacement is a further joint in front of the joint, at rest, and torques change with its
position as with any other's (Singh, Russell, Wensing 2022): see `derivatives`, for whose S_j stands
here a shift or turn s of body j's joint, with Ψ̇ = v_parent × s and Ψ̈ = a_parent × s + v_parent × Ψ̇:

    ∂tau_i = S_i · (2 B_j Ψ̇ + I_j Ψ̈ + s ×* f_j)          of bodies i on the way from j to the base
    ∂tau_k = 2 Ψ̇ · B_kᵀ S_k + Ψ̈ · I_k S_k                 of j and the bodies k that hang on it
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from freebody.algorithms.crba import momentum_of
from freebody.algorithms.derivatives import accelerations
from freebody.algorithms.kinematics import Column, Pose, ancestors
from freebody.algorithms.world_axes import (
    WorldTree,
    coriolis_times,
    coriolis_transposed_times,
    cross_force,
    cross_motion,
    dot_motion,
    plus_motion,
    world_tree,
)
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import (
    AnySpace,
    Vector,
    compose,
    dot,
    neg,
    scale,
    times,
    transposed,
)


def by_displacements(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> list[list[Vector]]:
    """Derivatives of tau, without drives, for each body by the shifts of its joint along the axes
    of the joint's own frame as it is placed, and then by its turns about them: rows of nv."""
    space, world = tree.space, world_tree(tree, q, qd)
    a, _, forces = accelerations(tree, world, q, qd, qdd)
    of_torques = [_of_torques(tree, world, k) for k in range(len(tree.bodies))]
    found = []
    for j, body in enumerate(tree.bodies):
        v_parent, a_parent = (
            (space.zero_angular, space.zero),
            (
                space.zero_angular,
                neg(world.gravity),
            ),
        )
        if body.parent >= 0:
            v_parent, a_parent = world.v[body.parent], a[body.parent]
        behind = [k for k in range(len(tree.bodies)) if j in ancestors(tree, k)]
        rows = []
        for s in _displacements(space, _placed(tree, world, q, j)):
            psi = cross_motion(space, v_parent, s)
            rate = plus_motion(cross_motion(space, a_parent, s), cross_motion(space, v_parent, psi))
            moment, push = coriolis_times(space, world.coriolis[j], psi)
            force = plus_motion(
                (scale(2.0, moment), scale(2.0, push)),
                momentum_of(space, world.inertia[j], rate),
            )
            force = plus_motion(force, cross_force(space, s, forces[j]))
            torques = {
                i: [dot_motion(column, force) for column in world.S[i]]
                for i in ancestors(tree, body.parent)
            } | {
                k: [
                    dot(psi[0], back) + dot_motion(rate, carried) for back, carried in of_torques[k]
                ]
                for k in behind
            }
            rows.append(_felt(tree, q, torques))
        found.append(rows)
    return found


def _felt(tree: Tree, q: Vector, torques: Mapping[int, Sequence[Scalar]]) -> Vector:
    """The torques (nv) that coordinates feel, from those along the columns of bodies' joints."""
    tau: list[Scalar] = [0.0] * tree.nv
    for i, own in torques.items():
        at = tree.bodies[i].coordinates
        for k, torque in zip(at.v, own, strict=True):
            tau[k] = tau[k] + at.felt(q, torque)
    return tuple(tau)


def _of_torques(tree: Tree, world: WorldTree, k: int) -> list[tuple[Vector, Column]]:
    """(2 Bᵀ S, I S) of each column of body k's joint."""
    I, B = world.inertia[k], world.coriolis[k]
    return [
        (scale(2.0, coriolis_transposed_times(tree.space, B, s)), momentum_of(tree.space, I, s))
        for s in world.S[k]
    ]


def _placed(tree: Tree, world: WorldTree, q: Vector, j: int) -> Pose:
    """The pose of the frame in which body j's joint is placed, before the joint moves."""
    body = tree.bodies[j]
    R, p = body.primitive.pose(tree.space, body.axis, body.position(q))
    E = transposed(R)
    return compose(world.poses[j], (E, neg(times(E, p))))


def _displacements(space: AnySpace, pose: Pose) -> list[Column]:
    """The shifts along the axes of a frame and the turns about them, as motions at the origin."""
    R, p = pose
    if space.dim == 2:
        turns: list[Vector] = [(1.0,)]
    else:
        turns = list(transposed(R))
    shifts = [(space.zero_angular, axis) for axis in transposed(R)]
    return [*shifts, *((w, neg(space.cross(w, p))) for w in turns)]
