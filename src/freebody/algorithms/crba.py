"""Composite rigid bodies: the mass matrix (Featherstone 2008, table 6.2), and systems with it
solved along the tree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody.algorithms.kinematics import (
    Column,
    Pose,
    ancestors,
    columns_at_origin,
    joint_poses,
    observed,
)
from freebody.algorithms.rnea import External, rnea
from freebody.elementary import Scalar
from freebody.model.drives.acting import DriveScalars
from freebody.model.tree import Composite, Tree, TreeBody, about_origin
from freebody.spatial import AnySpace, Matrix, Vector, add, dot, identity, scale, sub, times


def own_inertia(space: AnySpace, body: TreeBody) -> Composite:
    """Mass, first moment and inertia of a body about its origin."""
    return about_origin(space, body.masses)


def composites(
    tree: Tree, joints: list[Pose], own: Sequence[Composite] | None = None
) -> list[Composite]:
    """The inertia of each body with all that hangs on it, gathered inward. own: of each body alone,
    where its axes are not its frame's."""
    space = tree.space
    gathered = list(own or [own_inertia(space, body) for body in tree.bodies])
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
    """The mass matrix, nv × nv; rotors stand on its diagonal.

    Entry (k, l) is column l on the momentum that a unit rate k gives to all that hangs on its
    joint.
    """
    seen = _in_one_frame if _prefers_one_frame(tree) else _from_frame_to_frame
    columns, momenta, carried = seen(tree, joint_poses(tree, q))
    M: list[list[Scalar]] = [[0.0] * tree.nv for _ in range(tree.nv)]

    def enter(a: int, b: int, value: Scalar) -> None:
        M[a][b] = M[a][b] + value

    for i, body in enumerate(tree.bodies):
        at = body.coordinates
        for momentum, k in zip(momenta(i), at.v, strict=True):
            n, f = momentum
            for other, l in zip(columns[i], at.v, strict=True):
                if l <= k:
                    value = at.ratio * at.ratio * (dot(other[0], n) + dot(other[1], f))
                    enter(k, l, value)
                    if l != k:
                        enter(l, k, value)
            j = i
            while tree.bodies[j].parent >= 0:
                n, f = carried(j, (n, f))
                j = tree.bodies[j].parent
                outer = tree.bodies[j].coordinates
                for other, l in zip(columns[j], outer.v, strict=True):
                    value = at.ratio * outer.ratio * (dot(other[0], n) + dot(other[1], f))
                    enter(k, l, value)
                    enter(l, k, value)
        if body.drive is not None:
            enter(at.v[0], at.v[0], at.ratio * at.ratio * body.drive.inertia)
    return tuple(tuple(row) for row in M)


_Seen = tuple[
    Sequence[tuple[Column, ...]],
    Callable[[int], list[Column]],
    Callable[[int, Column], Column],
]
"""For each body the columns of its joint; their momenta, (moment, force) at an origin, made when
they are needed; and a force of the body as it acts on the next one inward."""


def _from_frame_to_frame(tree: Tree, joints: list[Pose]) -> _Seen:
    """Inertias and motion columns with each body in its own frame; what is passed inward is turned
    and moved at each joint."""
    space, gathered = tree.space, composites(tree, joints)
    columns = [body.columns for body in tree.bodies]

    def momenta(i: int) -> list[Column]:
        return [momentum_of(space, gathered[i], s) for s in columns[i]]

    def carried(i: int, force: Column) -> Column:
        (R, p), (n, f) = joints[i], force
        f = times(R, f)
        return add(space.turn(R, n), space.moment(p, f)), f

    return columns, momenta, carried


def _in_one_frame(tree: Tree, joints: list[Pose]) -> _Seen:
    """Inertias and motion columns of all bodies in the axes of one, so that nothing is turned on
    the way inward.

    Inertias are still about the origin of their own body: about a far one they would lose digits.
    What goes inward is moved once, to the common origin.
    """
    space = tree.space
    poses, _ = observed(tree, joints)
    own, steps = [], []
    for body, (R, p) in zip(tree.bodies, poses, strict=True):
        m, h, inertia = own_inertia(space, body)
        own.append((m, times(R, h), space.turned_inertia(R, inertia)))
        steps.append((identity(space.dim), p if body.parent < 0 else sub(p, poses[body.parent][1])))
    gathered = composites(tree, steps, own)

    def momenta(i: int) -> list[Column]:
        (R, p), found = poses[i], []
        for w, v in tree.bodies[i].columns:
            n, f = momentum_of(space, gathered[i], (space.turn(R, w), times(R, v)))
            found.append((add(n, space.moment(p, f)), f))
        return found

    return columns_at_origin(tree, poses), momenta, lambda i, force: force


def _prefers_one_frame(tree: Tree) -> bool:
    """Whether M takes fewer operations with all bodies in one frame: chains are long, and turned by
    odd angles from joint to joint.

    Estimated by what was counted for generated chains: a force that is carried over a joint takes
    12 operations more than a product of two columns for each row of the joint's rotation that is no
    coordinate axis; the common frame takes 80 for each body, and 40 for each such row. Without such
    rows the entries of M share more from frame to frame.
    """
    gained = 0
    ways: list[int] = []  # of each body: what a force carried to the base takes more than products
    for body in tree.bodies:
        odd = sum(not _exact(row) for row in body.R) if _exact(body.axis) else tree.space.dim
        ways.append(0 if body.parent < 0 else ways[body.parent] + 12 * odd)
        gained += len(body.columns) * ways[-1] - 80 - 40 * odd
    return gained > 0


def _exact(row: Vector) -> bool:
    """Whether all entries are the constants 0, 1 or -1, whatever the robot's other numbers are."""
    return all(isinstance(x, float) and x in (0.0, 1.0, -1.0) for x in row)


def mass_product(tree: Tree, q: Vector, x: Vector) -> Vector:
    """M x without M: the inverse dynamics of a robot at rest, without gravity, springs and
    friction."""
    weightless = replace(only_inertia(tree), gravity=tree.space.zero)
    return rnea(weightless, q, (0.0,) * tree.nv, x).tau


def only_inertia(tree: Tree) -> Tree:
    """The tree without friction, springs and struts; rotors stay."""
    inert = with_drives(tree, lambda drive: drive.only(lambda law: law.inertia is not None))
    return replace(inert, struts=())


def without_losses(tree: Tree) -> Tree:
    """The tree without what is lost of torques that joints transmit."""
    if not tree.lossy:
        return tree
    return with_drives(tree, lambda drive: drive.only(lambda law: law.losses is None))


def with_drives(tree: Tree, changed: Callable[[DriveScalars], DriveScalars]) -> Tree:
    """The tree with other drives."""
    bodies = tuple(
        body if body.drive is None else replace(body, drive=changed(body.drive))
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
    """Factors of M = Lᵀ D L with unit triangular L, without fill-in."""
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
    """Solution x of M x = right."""
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
    """Torques of velocities, gravity, friction and springs: the inverse dynamics at q̈ = 0, without
    transmission losses."""
    return rnea(without_losses(tree), q, qd, (0.0,) * tree.nv, external).tau
