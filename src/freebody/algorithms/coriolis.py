"""The Coriolis matrix C with C q̇ = c and Ṁ - 2C skew-symmetric (Echeandia and Wensing 2021, algorithm 1)."""

from __future__ import annotations

from freebody.algorithms.crba import own_inertia
from freebody.algorithms.kinematics import joint_poses
from freebody.algorithms.plucker import (
    columns,
    cross_force,
    cross_force_swapped,
    cross_motion,
    inertia_matrix,
    minus,
    transform,
)
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, combine, dot, plus, product, scale, times, transposed


def coriolis_matrix(tree: Tree, q: Vector, qd: Vector) -> Matrix:
    """C, nv × nv: of one-axis joints the one of Christoffel's symbols, of quasi-velocities its counterpart."""
    space = tree.space
    X = [transform(space, pose) for pose in joint_poses(tree, q)]
    S = [columns(body) for body in tree.bodies]
    v: list[Vector] = []
    B: list[Matrix] = []
    IC: list[Matrix] = []
    for i, body in enumerate(tree.bodies):
        joint = combine(S[i], body.rates(qd))
        v.append(joint if body.parent < 0 else add(times(X[i], v[body.parent]), joint))
        inertia = inertia_matrix(space, own_inertia(space, body))
        IC.append(inertia)
        B.append(_body_matrix(tree, inertia, v[i]))
    Sd = [tuple(times(cross_motion(space, v[i]), s) for s in S[i]) for i in range(len(S))]
    C: list[list[Scalar]] = [[0.0] * tree.nv for _ in range(tree.nv)]
    for j in reversed(range(len(tree.bodies))):
        body = tree.bodies[j]
        F1 = [add(times(IC[j], sd), times(B[j], s)) for s, sd in zip(S[j], Sd[j], strict=True)]
        F2 = [times(IC[j], s) for s in S[j]]
        F3 = [times(transposed(B[j]), s) for s in S[j]]
        i = j
        while i >= 0:
            outer = tree.bodies[i].coordinates
            for a, k in enumerate(outer.v):
                for b, l in enumerate(body.coordinates.v):
                    ratio = outer.ratio * body.coordinates.ratio
                    C[k][l] = C[k][l] + ratio * dot(S[i][a], F1[b])
                    if i != j:
                        C[l][k] = C[l][k] + ratio * (dot(Sd[i][a], F2[b]) + dot(S[i][a], F3[b]))
            up = transposed(X[i])
            F1, F2, F3 = ([times(up, f) for f in F] for F in (F1, F2, F3))
            i = tree.bodies[i].parent
        if body.parent >= 0:
            down, up = X[j], transposed(X[j])
            IC[body.parent] = plus(IC[body.parent], product(up, product(IC[j], down)))
            B[body.parent] = plus(B[body.parent], product(up, product(B[j], down)))
    return tuple(tuple(row) for row in C)


def _body_matrix(tree: Tree, inertia: Matrix, v: Vector) -> Matrix:
    """½ ((v×*) I - I (v×) + (I v)×̄*): the Coriolis matrix of one body."""
    space = tree.space
    first = product(cross_force(space, v), inertia)
    second = product(inertia, cross_motion(space, v))
    third = cross_force_swapped(space, times(inertia, v))
    return tuple(scale(0.5, row) for row in plus(minus(first, second), third))
