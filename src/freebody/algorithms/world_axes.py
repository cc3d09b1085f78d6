"""Bodies in one frame, with what hangs on each: the common ground of C and the derivatives.

The frame is that of one body where it is now, at rest: nothing here depends on where the robot
stands, and no inertia is taken about a far point. Motions are pairs (ω, v) and forces pairs (n, f)
at its origin, so nothing needs to be transformed on the way along the tree. A body's Coriolis
matrix B = ½ ((v×*) I - I (v×) + (I v)×̄*) (Echeandia and Wensing 2021) has only two blocks that are
not zero: the angular one and, below it, -(linear momentum)×.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from freebody.algorithms.crba import Composite, momentum_of, own_inertia
from freebody.algorithms.kinematics import (
    Column,
    Pose,
    columns_at_origin,
    joint_poses,
    observed,
    weighted,
)
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.spatial import (
    AnySpace,
    Matrix,
    Vector,
    add,
    dot,
    plus,
    scale,
    sub,
    times,
    transposed,
)

Force = tuple[Vector, Vector]
"""Spatial force (moment, force)."""


@dataclass
class WorldTree:
    """Per body: pose, motion columns and their rates, velocity, inertia, and sums over the body and
    all that hangs on it."""

    gravity: Vector
    poses: list[Pose]
    S: list[tuple[Column, ...]] = field(default_factory=list)
    S_rate: list[tuple[Column, ...]] = field(default_factory=list)
    """Ṡ = v × S with the body's own velocity."""
    psi: list[tuple[Column, ...]] = field(default_factory=list)
    """Ψ̇ = v × S with the parent's velocity."""
    v: list[Column] = field(default_factory=list)
    own: list[Composite] = field(default_factory=list)
    """Inertia of each body alone."""
    inertia: list[Composite] = field(default_factory=list)
    own_coriolis: list[tuple[Matrix, Vector]] = field(default_factory=list)
    """(angular block of B, linear momentum) of each body alone."""
    coriolis: list[tuple[Matrix, Vector]] = field(default_factory=list)


def world_tree(tree: Tree, q: Vector, qd: Vector) -> WorldTree:
    """Columns and velocities outward, inertias and Coriolis matrices inward."""
    space = tree.space
    poses, turn = observed(tree, joint_poses(tree, q))
    world = WorldTree(times(turn, tree.gravity), poses)
    world.S = columns_at_origin(tree, poses)
    for body, columns, pose in zip(tree.bodies, world.S, poses, strict=True):
        joint = weighted(columns, body.rates(q, qd))
        parent = world.v[body.parent] if body.parent >= 0 else None
        velocity = joint if parent is None else plus_motion(parent, joint)
        still = (space.zero_angular, space.zero)
        world.v.append(velocity)
        psi = tuple(still if parent is None else cross_motion(space, parent, s) for s in columns)
        world.psi.append(psi)
        # v - v_parent is along the only column, and s × s = 0
        only = len(columns) == 1
        world.S_rate.append(
            psi if only else tuple(cross_motion(space, velocity, s) for s in columns)
        )
        inertia = _moved(space, pose, own_inertia(space, body))
        world.own.append(inertia)
        _, linear = momentum_of(space, inertia, velocity)
        world.own_coriolis.append((space.coriolis(inertia[2], inertia[1], *velocity), linear))
    world.inertia, world.coriolis = list(world.own), list(world.own_coriolis)
    for i in reversed(range(len(tree.bodies))):
        k = tree.bodies[i].parent
        if k >= 0:
            (m, h, J), (M, H, I) = world.inertia[i], world.inertia[k]
            world.inertia[k] = (M + m, add(H, h), space.plus_inertia(I, J))
            (b, p), (B, P) = world.coriolis[i], world.coriolis[k]
            world.coriolis[k] = (plus(B, b), add(P, p))
    return world


# ---------------------------------------------------------------- motions and forces at one point
def cross_motion(space: AnySpace, a: Column, b: Column) -> Column:
    """Cross product a × b of two motions."""
    return space.cross_angular(a[0], b[0]), sub(space.cross(a[0], b[1]), space.cross(b[0], a[1]))


def cross_force(space: AnySpace, a: Column, b: Force) -> Force:
    """a ×* b of a motion and a force."""
    return add(space.cross_angular(a[0], b[0]), space.moment(a[1], b[1])), space.cross(a[0], b[1])


def plus_motion(a: Column, b: Column) -> Column:
    """Sum a + b of two motions."""
    return add(a[0], b[0]), add(a[1], b[1])


def dot_motion(a: Column, b: Force) -> Scalar:
    """Power of a force on a motion."""
    return dot(a[0], b[0]) + dot(a[1], b[1])


def coriolis_times(space: AnySpace, B: tuple[Matrix, Vector], column: Column) -> Force:
    """Product B s of a body's Coriolis matrix and a motion."""
    block, momentum = B
    return times(block, column[0]), space.cross(column[0], momentum)


def coriolis_transposed_times(space: AnySpace, B: tuple[Matrix, Vector], column: Column) -> Vector:
    """The angular part of Bᵀ s; its linear part is zero."""
    block, momentum = B
    return add(times(transposed(block), column[0]), space.moment(momentum, column[1]))


def _moved(space: AnySpace, pose: Pose, inertia: Composite) -> Composite:
    """A body's inertia in world axes about the world's origin."""
    (R, p), (m, h, own) = pose, inertia
    turned = times(R, h)
    return (
        m,
        add(turned, scale(m, p)),
        space.plus_inertia(space.turned_inertia(R, own), space.steiner(m, turned, p)),
    )
