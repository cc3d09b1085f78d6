"""Articulated bodies: forward dynamics in a time linear in the number of bodies (Featherstone 2008,
table 7.1), in motion and force vectors of one column, angular part first."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.algorithms.crba import Composite, momentum_of, own_inertia
from freebody.algorithms.kinematics import Column, Pose, joint_poses
from freebody.algorithms.rnea import External
from freebody.algorithms.struts import strut_loads
from freebody.algorithms.world_axes import cross_force, cross_motion
from freebody.elementary import Scalar
from freebody.model.tree import Tree, TreeBody
from freebody.spatial import (
    AnySpace,
    Matrix,
    Vector,
    add,
    combine,
    congruence,
    dot,
    identity,
    neg,
    plus,
    product,
    scale,
    sub,
    symmetric,
    times,
    transposed,
)


def aba(
    tree: Tree, q: Vector, qd: Vector, tau: Vector, external: Sequence[External] = ()
) -> Vector:
    """q̈, for trees whose coordinates move one joint each, and whose joints lose nothing of what
    they transmit. Gravity is a base acceleration."""
    assert not tree.lossy, "what is lost depends on all accelerations"
    assert not tree.follows, (
        "a coordinate that moves several joints makes the tree's inertia global"
    )
    space = tree.space
    joints = joint_poses(tree, q)
    X = [_transform(space, pose) for pose in joints]
    S = [_columns(body) for body in tree.bodies]
    v: list[Vector] = []
    c: list[Vector] = []
    IA: list[Matrix] = []
    pA: list[Vector] = []
    for i, body in enumerate(tree.bodies):
        joint = combine(S[i], body.rates(q, qd))
        v.append(joint if body.parent < 0 else add(times(X[i], v[body.parent]), joint))
        own, velocity = own_inertia(space, body), _parts(space, v[i])
        c_w, c_v = cross_motion(space, velocity, _parts(space, joint))
        n, f = cross_force(space, velocity, momentum_of(space, own, velocity))
        c.append(c_w + c_v)
        pA.append(n + f)
        IA.append(_inertia_matrix(space, own))
    loads = strut_loads(tree, joints, [_parts(space, x) for x in v])
    for i, force, moment in (*external, *loads):
        pA[i] = sub(pA[i], moment + force)
    eliminated: list[list[tuple[int, Vector, Vector, Scalar, Scalar]]] = [[] for _ in tree.bodies]
    for i in reversed(range(len(tree.bodies))):
        body = tree.bodies[i]
        inertia, force = IA[i], pA[i]
        # a joint of several columns is taken column by column, the last first: each leaves a
        # smaller articulated body
        for k in reversed(range(len(S[i]))):
            s, at = S[i][k], body.coordinates.v[k]
            Us = times(inertia, s)
            d = dot(s, Us)
            motor = tau[at]
            if body.drive is not None:
                d, motor = d + body.drive.inertia, motor - body.drive.torque(q, qd)
            inverse: Scalar = 1.0 / d
            rest = motor - dot(s, force)
            eliminated[i].append((k, s, Us, inverse, rest))
            inertia = _less(inertia, Us, inverse)
            force = add(force, scale(inverse * rest, Us))
        if body.parent >= 0:
            IA[body.parent] = plus(IA[body.parent], congruence(inertia, X[i]))
            force = add(force, times(inertia, c[i]))
            pA[body.parent] = add(pA[body.parent], times(transposed(X[i]), force))
    qdd: list[Scalar] = [0.0] * tree.nv
    a: list[Vector] = []
    base = space.zero_angular + neg(tree.gravity)
    for i, body in enumerate(tree.bodies):
        acceleration = add(times(X[i], base if body.parent < 0 else a[body.parent]), c[i])
        for k, s, Us, inverse, rest in reversed(eliminated[i]):
            rate = inverse * (rest - dot(Us, acceleration))
            qdd[body.coordinates.v[k]] = rate
            acceleration = add(acceleration, scale(rate, s))
        a.append(acceleration)
    return tuple(qdd)


def _less(inertia: Matrix, U: Vector, inverse: Scalar) -> Matrix:
    """The inertia that is left when a joint moves freely: inertia - U Uᵀ / d."""
    scaled = scale(inverse, U)
    return symmetric(len(U), lambda i, j: inertia[i][j] - U[i] * scaled[j])


def _size_angular(space: AnySpace) -> int:
    """The number of angular entries of a motion."""
    return len(space.zero_angular)


def _parts(space: AnySpace, column: Vector) -> Column:
    """(angular, linear) part of a column."""
    a = _size_angular(space)
    return column[:a], column[a:]


def _columns(body: TreeBody) -> tuple[Vector, ...]:
    """Motion columns of a joint."""
    return tuple(w + v for w, v in body.columns)


def _transform(space: AnySpace, pose: Pose) -> Matrix:
    """X that takes motions of the parent to motions of the child at (R, p): ω' = Rᵀ ω, v' = Rᵀ (v +
    ω × p)."""
    R, p = pose
    E = transposed(R)
    a = _size_angular(space)
    turn = transposed(tuple(space.turn(E, unit) for unit in identity(a)))
    moved = product(E, transposed(tuple(space.cross(unit, p) for unit in identity(a))))
    top = tuple(row + (0.0,) * space.dim for row in turn)
    return top + tuple(m + e for m, e in zip(moved, E, strict=True))


def _inertia_matrix(space: AnySpace, composite: Composite) -> Matrix:
    """The 6×6 (plane: 3×3) inertia about the origin."""
    m, h, inertia = composite
    hx = space.skew(h)
    top = tuple(i + row for i, row in zip(space.inertia_matrix(inertia), hx, strict=True))
    bottom = tuple(
        row + scale(m, unit) for row, unit in zip(transposed(hx), identity(space.dim), strict=True)
    )
    return top + bottom
