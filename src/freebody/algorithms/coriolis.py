"""The Coriolis matrix C with C q̇ = c and Ṁ - 2C skew-symmetric (Echeandia and Wensing 2021)."""

from __future__ import annotations

from freebody.algorithms.crba import momentum_of
from freebody.algorithms.kinematics import ancestors
from freebody.algorithms.world import (
    coriolis_times,
    coriolis_transposed_times,
    dot_motion,
    plus_motion,
    world_tree,
)
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot


def coriolis_matrix(tree: Tree, q: Vector, qd: Vector) -> Matrix:
    """C, nv × nv: of one-axis joints the one of Christoffel's symbols, of quasi-velocities its counterpart.

    With I and B summed over what hangs on body j, and i on the way from j to the base:
    C_ij = S_i · (I Ṡ_j + B S_j),  C_ji = Ṡ_i · I S_j + S_i · Bᵀ S_j.
    """
    space = tree.space
    world = world_tree(tree, q, qd)
    C: list[list[Scalar]] = [[0.0] * tree.nv for _ in range(tree.nv)]
    for j, body in enumerate(tree.bodies):
        inner = body.coordinates
        for s, s_rate, l in zip(world.S[j], world.S_rate[j], inner.v, strict=True):
            force = plus_motion(
                momentum_of(space, world.inertia[j], s_rate), coriolis_times(space, world.coriolis[j], s)
            )
            carried = momentum_of(space, world.inertia[j], s)
            back = coriolis_transposed_times(space, world.coriolis[j], s)
            for i in ancestors(tree, j):
                outer = tree.bodies[i].coordinates
                for r, r_rate, k in zip(world.S[i], world.S_rate[i], outer.v, strict=True):
                    ratio = outer.ratio * inner.ratio
                    C[k][l] = C[k][l] + ratio * dot_motion(r, force)
                    if i != j:
                        C[l][k] = C[l][k] + ratio * (dot_motion(r_rate, carried) + dot(r[0], back))
    return tuple(tuple(row) for row in C)
