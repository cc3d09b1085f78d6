"""Composite rigid bodies: the mass matrix (Featherstone 2008, table 6.2), and systems with it
solved along the tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from freebody.algorithms.kinematics import Column, Pose, ancestors, joint_poses
from freebody.algorithms.rnea import External, rnea
from freebody.elementary import Scalar
from freebody.model.tree import Composite, Tree, TreeBody, about_origin
from freebody.spatial import AnySpace, Matrix, Vector, add, dot, scale, sub, times


def own_inertia(space: AnySpace, body: TreeBody) -> Composite:
    """Mass, first moment and inertia of a body about its origin."""
    return about_origin(space, body.masses)


def composites(tree: Tree, joints: list[Pose]) -> list[Composite]:
    """The inertia of each body with all that hangs on it, gathered inward."""
    space = tree.space
    gathered = [own_inertia(space, body) for body in tree.bodies]
    for i in reversed(range(len(tree.bodies))):
        k = tree.bodies[i].parent
        if k >= 0:
            (R, p), (m, h, inertia) = joints[i], gathered[i]
            h = times(R, h)
            inertia = space.plus_inertia(space.turned_inertia(R, inertia), space.steiner(m, h, p))
            M, H, J = gathered[k]
            gathered[k] = (M + m, add(H, h, scale(m, p)), space.plus_inertia(J, inertia))
    return gathered


def momentum_of(space: AnySpace, composite: Composite, column: Column) -> Column:
    """(angular, linear) momentum about the origin of a rigid body moving with (ω, v)."""
    m, h, inertia = composite
    w, v = column
    return add(space.inertia_times(inertia, w), space.moment(h, v)), add(
        scale(m, v), space.cross(w, h)
    )


def crba(tree: Tree, q: Vector) -> Matrix:
    """The mass matrix, nv × nv; rotors stand on its diagonal."""
    space = tree.space
    joints = joint_poses(tree, q)
    gathered = composites(tree, joints)
    M: list[list[Scalar]] = [[0.0] * tree.nv for _ in range(tree.nv)]

    def enter(a: int, b: int, value: Scalar) -> None:
        M[a][b] = M[a][b] + value

    for i, body in enumerate(tree.bodies):
        at = body.coordinates
        for column, k in zip(body.columns, at.v, strict=True):
            n, f = momentum_of(space, gathered[i], column)
            for other, l in zip(body.columns, at.v, strict=True):
                if l <= k:
                    value = at.ratio * at.ratio * (dot(other[0], n) + dot(other[1], f))
                    enter(k, l, value)
                    if l != k:
                        enter(l, k, value)
            j = i
            while tree.bodies[j].parent >= 0:
                R, p = joints[j]
                f = times(R, f)
                n = add(space.turn(R, n), space.moment(p, f))
                j = tree.bodies[j].parent
                outer = tree.bodies[j].coordinates
                for other, l in zip(tree.bodies[j].columns, outer.v, strict=True):
                    value = at.ratio * outer.ratio * (dot(other[0], n) + dot(other[1], f))
                    enter(k, l, value)
                    enter(l, k, value)
        if body.drive is not None:
            enter(at.v[0], at.v[0], at.ratio * at.ratio * body.drive.rotor)
    return tuple(tuple(row) for row in M)


def mass_product(tree: Tree, q: Vector, x: Vector) -> Vector:
    """M x without M: the inverse dynamics of a robot at rest, without gravity, springs and
    friction."""
    weightless = replace(only_inertia(tree), gravity=tree.space.zero)
    return rnea(weightless, q, (0.0,) * tree.nv, x).tau


def only_inertia(tree: Tree) -> Tree:
    """The tree without friction and springs; rotors stay."""
    return without(tree, "viscous", "coulomb", "stiffness")


def without(tree: Tree, *terms: str) -> Tree:
    """The tree without some of what its drives do, by the names in `DriveScalars`."""
    nothing = dict.fromkeys(terms, 0.0)
    bodies = tuple(
        body if body.drive is None else replace(body, drive=replace(body.drive, **nothing))
        for body in tree.bodies
    )
    return replace(tree, bodies=bodies)


def supports(tree: Tree) -> dict[int, tuple[int, ...]]:
    """For each velocity coordinate, outermost last, the coordinates before it that M couples it
    with.

    Along a tree these are the ones on the way to the base (Featherstone 2008, 6.5); where
    coordinates move several joints, all earlier ones.
    """
    above: dict[int, tuple[int, ...]] = {}
    if tree.follows:
        order = list(dict.fromkeys(k for body in tree.bodies for k in body.coordinates.v))
        return {k: tuple(order[:i]) for i, k in enumerate(order)}
    for i, body in enumerate(tree.bodies):
        chain = [k for j in reversed(ancestors(tree, i)[1:]) for k in tree.bodies[j].coordinates.v]
        for k in body.coordinates.v:
            above[k] = tuple(chain)
            chain = [*chain, k]
    return above


Factors = tuple[dict[tuple[int, int], Scalar], dict[int, Scalar]]
"""Entries (row, column) of L below its unit diagonal, and 1/D."""


def factor(tree: Tree, M: Matrix) -> Factors:
    """M = Lᵀ D L with unit triangular L, without fill-in."""
    above = supports(tree)
    H = {(k, j): M[k][j] for k in above for j in (*above[k], k)}
    inverse: dict[int, Scalar] = {}
    for k in reversed(above):
        inverse[k] = 1.0 / H[k, k]
        chain = above[k]
        for a in reversed(range(len(chain))):
            ratio = H[k, chain[a]] * inverse[k]
            for b in range(a + 1):
                pair = (chain[a], chain[b])
                H[pair] = H[pair] - ratio * H[k, chain[b]]
            H[k, chain[a]] = ratio
    return {pair: value for pair, value in H.items() if pair[0] != pair[1]}, inverse


def solve(tree: Tree, M: Matrix, right: Vector) -> Vector:
    """M⁻¹ right."""
    return substitute(tree, factor(tree, M), right)


def substitute(tree: Tree, factors: Factors, right: Vector) -> Vector:
    """M⁻¹ right from the factors of M."""
    L, inverse = factors
    above = supports(tree)
    x = list(right)
    for k in reversed(above):
        for j in above[k]:
            x[j] = x[j] - L[k, j] * x[k]
    for k in above:
        x[k] = x[k] * inverse[k]
        for j in above[k]:
            x[k] = x[k] - L[k, j] * x[j]
    return tuple(x)


def bias(tree: Tree, q: Vector, qd: Vector, external: Sequence[External] = ()) -> Vector:
    """Velocity, gravity, friction and spring torques: the inverse dynamics at q̈ = 0."""
    return rnea(tree, q, qd, (0.0,) * tree.nv, external).tau


def forward_dynamics(
    tree: Tree, q: Vector, qd: Vector, tau: Vector, external: Sequence[External] = ()
) -> Vector:
    """q̈ from M q̈ = tau - bias (3.29)."""
    return solve(tree, crba(tree, q), sub(tau, bias(tree, q, qd, external)))
