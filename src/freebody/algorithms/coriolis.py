"""The Coriolis matrix C with C q̇ = c and Ṁ - 2C skew-symmetric (Echeandia and Wensing 2021)."""

from __future__ import annotations

from freebody.algorithms.crba import momentum_of
from freebody.algorithms.kinematics import Column, ancestors, weighted
from freebody.algorithms.world_axes import (
    Force,
    coriolis_times,
    coriolis_transposed_times,
    dot_motion,
    plus_motion,
    world_tree,
)
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot


def coriolis_product(tree: Tree, q: Vector, qd: Vector, x: Vector) -> Vector:
    """C x without C: with C = Σ Jᵀ (I J̇ + B J) over the bodies, one sweep outward and one
    inward."""
    space = tree.space
    world = world_tree(tree, q, qd)
    moved: list[Column] = []
    drift: list[Column] = []
    forces: list[Force] = []
    for i, body in enumerate(tree.bodies):
        at, rates = body.coordinates, body.rates(q, x)
        u, y = weighted(world.S[i], rates), weighted(world.S_rate[i], rates)
        if at.powers:
            y = plus_motion(y, weighted(world.S[i], (at.slope_rate(q, qd) * x[at.v[0]],)))
        if body.parent >= 0:
            u, y = plus_motion(moved[body.parent], u), plus_motion(drift[body.parent], y)
        moved.append(u)
        drift.append(y)
        own = world.own_coriolis[i]
        forces.append(
            plus_motion(momentum_of(space, world.own[i], y), coriolis_times(space, own, u))
        )
    result: list[Scalar] = [0.0] * tree.nv
    for i in reversed(range(len(tree.bodies))):
        body = tree.bodies[i]
        at = body.coordinates
        for s, k in zip(world.S[i], at.v, strict=True):
            result[k] = result[k] + at.slope(q) * dot_motion(s, forces[i])
        if at.powers and body.drive is not None:
            (k,) = at.v
            turned = body.drive.inertia * (at.slope_rate(q, qd) * x[k])
            result[k] = result[k] + at.felt(q, turned)
        if body.parent >= 0:
            forces[body.parent] = plus_motion(forces[body.parent], forces[i])
    return tuple(result)


def coriolis_matrix(tree: Tree, q: Vector, qd: Vector) -> Matrix:
    """C, nv × nv: of joints of one coordinate the one of Christoffel symbols, of quasi-velocities
    its counterpart.

    With I and B summed over what hangs on body j, and i on the way from j to the base:
    C_ij = S_i · (I Ṡ_j + B S_j),  C_ji = Ṡ_i · I S_j + S_i · Bᵀ S_j.

    Where a joint follows another by a ratio p' that changes, S is p' S, and its rate
    p' Ṡ + p˙' S.
    """
    space = tree.space
    world = world_tree(tree, q, qd)
    C: list[list[Scalar]] = [[0.0] * tree.nv for _ in range(tree.nv)]
    slopes = [body.coordinates.slope(q) for body in tree.bodies]
    slope_rates = [body.coordinates.slope_rate(q, qd) for body in tree.bodies]
    for j, body in enumerate(tree.bodies):
        inner = body.coordinates
        for s, s_rate, l in zip(world.S[j], world.S_rate[j], inner.v, strict=True):
            force = plus_motion(
                momentum_of(space, world.inertia[j], s_rate),
                coriolis_times(space, world.coriolis[j], s),
            )
            carried = momentum_of(space, world.inertia[j], s)
            back = coriolis_transposed_times(space, world.coriolis[j], s)
            for i in ancestors(tree, j):
                outer = tree.bodies[i].coordinates
                for r, r_rate, k in zip(world.S[i], world.S_rate[i], outer.v, strict=True):
                    ratio = slopes[i] * slopes[j]
                    C[k][l] = C[k][l] + ratio * dot_motion(r, force)
                    if i != j:
                        C[l][k] = C[l][k] + ratio * (dot_motion(r_rate, carried) + dot(r[0], back))
                    if inner.powers:
                        swing = slopes[i] * slope_rates[j]
                        C[k][l] = C[k][l] + swing * dot_motion(r, carried)
                    if outer.powers and i != j:
                        swing = slopes[j] * slope_rates[i]
                        C[l][k] = C[l][k] + swing * dot_motion(r, carried)
        if inner.powers and body.drive is not None:
            (l,) = inner.v
            C[l][l] = C[l][l] + slopes[j] * slope_rates[j] * body.drive.inertia
    return tuple(tuple(row) for row in C)
