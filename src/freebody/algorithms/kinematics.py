"""Poses, velocities, accelerations and Jacobians of a tree (notes, 2.10-2.26, 4.6-4.11,
6.16-6.27)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from freebody.dual import Dual
from freebody.elementary import Scalar
from freebody.errors import SingularError
from freebody.model.coordinates import Coordinates
from freebody.model.joints.kind import Column, Primitive
from freebody.model.tree import Pose, Tree, TreeBody
from freebody.spatial import (
    Matrix,
    Vector,
    add,
    combine,
    compose,
    identity,
    neg,
    plus,
    scale,
    sub,
    times,
    transposed,
)


def joint_poses(tree: Tree, q: Vector) -> list[Pose]:
    """Pose of each body in its parent."""
    return [_joint_pose(tree, body, q) for body in tree.bodies]


def _joint_pose(tree: Tree, body: TreeBody, q: Vector) -> Pose:
    """Pose of a body in its parent."""
    return compose((body.R, body.p), body.primitive.pose(tree.space, body.axis, body.position(q)))


def position_rates(tree: Tree, q: Vector, qd: Vector) -> Vector:
    """The time derivative of q: q̇ itself, but for quaternions and positions of free joints."""
    return _by_body(
        tree, "q", lambda x, at: x.position_rates(tree.space, _some(q, at.q), _some(qd, at.v))
    )


def _by_body(
    tree: Tree,
    order: Literal["q", "v"],
    own: Callable[[Primitive, Coordinates], Vector],
) -> Vector:
    """A vector in the order of q, or of q̇, put together from those of the bodies' joints."""
    whole: list[Scalar] = [0.0] * (tree.nq if order == "q" else tree.nv)
    for body in tree.bodies:
        at = body.coordinates
        for k, x in zip(getattr(at, order), own(body.primitive, at), strict=True):
            whole[k] = x
    return tuple(whole)


def _some(x: Vector, places: Sequence[int]) -> Vector:
    """The entries of a vector at some places."""
    return tuple([x[k] for k in places])


def along_every_direction(tree: Tree, q: Vector) -> Vector:
    """q with slopes along each of the nv directions of the tangent space."""
    along = [position_rates(tree, q, unit) for unit in identity(tree.nv)]
    return tuple(Dual(x, {k: rates[i] for k, rates in enumerate(along)}) for i, x in enumerate(q))


def moved(tree: Tree, q: Vector, v: Vector) -> Vector:
    """The position reached from q by the constant rates v in unit time."""
    return _by_body(tree, "q", lambda x, at: x.moved(tree.space, _some(q, at.q), _some(v, at.v)))


def between(tree: Tree, q0: Vector, q1: Vector) -> Vector:
    """The constant rates that lead from q0 to q1 in unit time."""
    return _by_body(
        tree, "v", lambda x, at: x.between(tree.space, _some(q0, at.q), _some(q1, at.q))
    )


def coordinate_rates(tree: Tree, x: Vector, v: Vector) -> Vector:
    """The rates of x where the position is `moved(q, x)` and changes with the rates v: dexp⁻¹(x) v,
    to second order."""
    return _by_body(
        tree, "v", lambda y, at: y.dexp_inverse(tree.space, _some(x, at.v), _some(v, at.v))
    )


def world_poses(tree: Tree, joints: list[Pose]) -> list[Pose]:
    """Pose of each body in the world."""
    world: list[Pose] = []
    for body, joint in zip(tree.bodies, joints, strict=True):
        world.append(joint if body.parent < 0 else compose(world[body.parent], joint))
    return world


def observed(tree: Tree, joints: list[Pose]) -> tuple[list[Pose], Matrix]:
    """Poses of the bodies in the observer's frame, and the rotation of world components into it."""
    n = tree.space.dim
    here = (identity(n), tree.space.zero)
    if not joints:
        return [], here[0]
    body = observer(tree)
    poses = {body: here}
    while body >= 0:
        R, p = joints[body]
        E = transposed(R)
        poses[tree.bodies[body].parent] = compose(poses[body], (E, neg(times(E, p))))
        body = tree.bodies[body].parent
    for i, joint in enumerate(joints):
        if i not in poses:
            poses[i] = compose(poses[tree.bodies[i].parent], joint)
    return [poses[i] for i in range(len(joints))], poses[-1][0]


def observer(tree: Tree) -> int:
    """The body whose frame is used where all are in one: the second of a chain, else the first.

    Measured on arms and humanoids: from there the programs are shortest, a sixth shorter than about
    the world's origin.
    """
    following = tree.children(0)
    return following[0] if len(following) == 1 else 0


def columns_at_origin(tree: Tree, poses: list[Pose]) -> list[tuple[Column, ...]]:
    """Motion columns of each joint at the origin and in the axes of the frame in which the bodies'
    poses are given."""
    space = tree.space

    def at_origin(pose: Pose, column: Column) -> Column:
        (R, p), (w, v) = pose, column
        turned = space.turn(R, w)
        return turned, sub(times(R, v), space.cross(turned, p))

    return [
        tuple(at_origin(pose, column) for column in body.columns)
        for body, pose in zip(tree.bodies, poses, strict=True)
    ]


def frame_pose(tree: Tree, world: list[Pose], frame: str) -> Pose:
    """Pose of a named frame in the world."""
    body, R, p = tree.frames[frame]
    return (R, p) if body < 0 else compose(world[body], (R, p))


def frame_pose_at(tree: Tree, q: Vector, frame: str) -> Pose:
    """Pose of a named frame in the world, by the joints on the way to it alone."""
    body, R, p = tree.frames[frame]
    pose = None
    for i in reversed(ancestors(tree, body)):
        joint = _joint_pose(tree, tree.bodies[i], q)
        pose = joint if pose is None else compose(pose, joint)
    return (R, p) if pose is None else compose(pose, (R, p))


def weighted(columns: tuple[Column, ...], rates: Vector) -> Column:
    """Σ rates[k] columns[k]: what a joint adds to its body's velocity, or of accelerations to its
    acceleration."""
    return combine(tuple(w for w, _ in columns), rates), combine(
        tuple(v for _, v in columns), rates
    )


@dataclass
class BodyMotions:
    """Velocities and accelerations of every body, in its own axes, of its own origin."""

    joints: list[Pose]
    w: list[Vector]
    wd: list[Vector]
    v: list[Vector]
    vd: list[Vector]
    rates: list[Matrix]
    """[ω̇×] + [ω×][ω×] of each body."""


VectorNaming = Callable[[str, int, Vector], Vector]
"""(name in the record, body, value) -> the vector that later steps of a recursion are given: the
value itself, or in a derivation a name for it."""


def unnamed(name: str, body: int, value: Vector) -> Vector:
    """The vector as it is: what numbers and kernels take where a derivation gives it a name."""
    return value


def outward(
    tree: Tree,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    base_acceleration: Vector | None = None,
    named: VectorNaming = unnamed,
) -> BodyMotions:
    """Outward recursion (4.6-4.11; 6.16-6.22 revolute, 6.23-6.27 prismatic, in one form).

    v̇ is the acceleration of the body's origin (time derivative of its velocity), in body axes. A
    base acceleration of -g makes gravity part of it.
    """
    space = tree.space
    motion = BodyMotions(joint_poses(tree, q), [], [], [], [], [])
    still = (space.zero_angular, space.zero_angular, space.zero, base_acceleration or space.zero)
    for i, body in enumerate(tree.bodies):
        R, p = motion.joints[i]
        E = transposed(R)
        first = body.rates(q, qd)
        second = body.coordinates.second_rates(q, qd, qdd)
        w_joint, v_joint = weighted(body.columns, first)
        wd_joint, vd_joint = weighted(body.columns, second)
        wd_bias, vd_bias = body.primitive.bias(space, first)
        k = body.parent
        if k < 0:
            w_parent, wd_parent, v_parent, vd_parent = still
            rates_parent = None
        else:
            w_parent = motion.w[k]
            wd_parent = motion.wd[k]
            v_parent = motion.v[k]
            vd_parent = motion.vd[k]
            rates_parent = motion.rates[k]
        w_before = space.turn(E, w_parent)
        vd_at_joint = vd_parent if rates_parent is None else add(vd_parent, times(rates_parent, p))
        w = add(w_before, w_joint)
        wd = add(
            space.turn(E, wd_parent), wd_joint, wd_bias, space.cross_angular(w_before, w_joint)
        )
        v = add(times(E, add(v_parent, space.cross(w_parent, p))), v_joint)
        vd = add(
            times(E, vd_at_joint), vd_joint, vd_bias, scale(2.0, space.cross(w_before, v_joint))
        )
        w, wd = named("w", i, w), named("wd", i, wd)
        v, vd = named("v", i, v), named("vd", i, vd)
        motion.w.append(w)
        motion.wd.append(wd)
        motion.v.append(v)
        motion.vd.append(vd)
        motion.rates.append(space.rates(w, wd))
    return motion


def frame_motion(
    tree: Tree, motion: BodyMotions, frame: str, point: Vector | None = None
) -> tuple[Column, Column]:
    """((ω, v), (ω̇, v̇)) of a point fixed to a frame (default its origin), in world axes."""
    space = tree.space
    body, R, p = tree.frames[frame]
    if body < 0:
        return (space.zero_angular, space.zero), (space.zero_angular, space.zero)
    at = p if point is None else add(p, times(R, point))
    W, _ = world_poses(tree, motion.joints)[body]
    v = add(motion.v[body], space.cross(motion.w[body], at))
    vd = add(motion.vd[body], times(motion.rates[body], at))
    return (
        (space.turn(W, motion.w[body]), times(W, v)),
        (space.turn(W, motion.wd[body]), times(W, vd)),
    )


def ancestors(tree: Tree, body: int) -> list[int]:
    """The body and all that carry it, from the body to the ground."""
    chain = []
    while body >= 0:
        chain.append(body)
        body = tree.bodies[body].parent
    return chain


def jacobian(tree: Tree, q: Vector, frame: str, reference: str = "world") -> Matrix:
    """Rows: linear, then angular velocity of a frame per unit rate, in world axes or those of the
    frame ("body")."""
    world = world_poses(tree, joint_poses(tree, q))
    R, p = frame_pose(tree, world, frame)
    columns = frame_columns(tree, world, p, frame)
    slopes = [body.coordinates.slope(q) for body in tree.bodies]
    return _assembled(tree, columns, slopes, None if reference == "world" else transposed(R))


def jacobian_dot(tree: Tree, q: Vector, qd: Vector, frame: str, reference: str = "world") -> Matrix:
    """Time derivative of `jacobian`: J q̈ + J̇ q̇ is the frame's acceleration (2.24)."""
    space = tree.space
    motion = outward(tree, q, qd, tuple(0.0 for _ in range(tree.nv)))
    world = world_poses(tree, motion.joints)
    R, p = frame_pose(tree, world, frame)
    (w_frame, v_frame), _ = frame_motion(tree, motion, frame)
    columns: dict[int, list[Column]] = {}
    here = frame_columns(tree, world, p, frame)
    for i, of_body in here.items():
        W, o = world[i]
        w, v = space.turn(W, motion.w[i]), times(W, motion.v[i])
        arm, arm_rate = sub(p, o), sub(v_frame, v)
        columns[i] = []
        for angular, linear in of_body:
            slide = sub(linear, space.cross(angular, arm))  # R v_k: constant in the body
            angular_rate = space.cross_angular(w, angular)
            linear_rate = add(
                space.cross(w, slide),
                space.cross(angular_rate, arm),
                space.cross(angular, arm_rate),
            )
            if reference != "world":
                # d/dt (Rᵀ J) = Rᵀ (J̇ - ω × J)
                angular_rate = sub(angular_rate, space.cross_angular(w_frame, angular))
                linear_rate = sub(linear_rate, space.cross(w_frame, linear))
            columns[i].append((angular_rate, linear_rate))
    E = None if reference == "world" else transposed(R)
    found = _assembled(tree, columns, [body.coordinates.slope(q) for body in tree.bodies], E)
    if not tree.bends:
        return found
    # of (p' S)˙ = p' Ṡ + p˙' S the second part
    slope_rates = [body.coordinates.slope_rate(q, qd) for body in tree.bodies]
    return plus(found, _assembled(tree, here, slope_rates, E))


def frame_columns(tree: Tree, world: list[Pose], p: Vector, frame: str) -> dict[int, list[Column]]:
    """Motion columns of each joint on the way to a frame, at the point p, in world axes."""
    space = tree.space
    columns = {}
    for i in ancestors(tree, tree.frames[frame][0]):
        W, o = world[i]
        arm = sub(p, o)
        columns[i] = []
        for w, v in tree.bodies[i].columns:
            angular = space.turn(W, w)
            columns[i].append((angular, add(times(W, v), space.cross(angular, arm))))
    return columns


def _assembled(
    tree: Tree, columns: dict[int, list[Column]], factors: Sequence[Scalar], E: Matrix | None
) -> Matrix:
    """Columns as a matrix with rows linear, angular, turned by E, those of each body times a
    factor; coordinates that move several joints add up."""
    space = tree.space
    full: list[Vector] = [(0.0,) * space.six for _ in range(tree.nv)]
    for i, of_body in columns.items():
        for k, (angular, linear) in zip(tree.bodies[i].coordinates.v, of_body, strict=True):
            column = linear + angular if E is None else times(E, linear) + space.turn(E, angular)
            full[k] = add(full[k], scale(factors[i], column))
    return transposed(tuple(full), space.six)


NO_CENTRE = "{} has a mass, so there is no centre of mass; give them an inertia."


def centre_of_mass(tree: Tree, q: Vector, base: bool = True) -> Vector:
    """Centre of mass Σ m r / Σ m in the world (1.15), with or without the base's mass."""
    total: Scalar = 0.0
    moment = tree.space.zero
    resting = (identity(tree.space.dim), tree.space.zero)
    world = world_poses(tree, joint_poses(tree, q))
    fixed = [(tree.base, resting)] if base else []
    for masses, (R, p) in fixed + [(b.masses, w) for b, w in zip(tree.bodies, world, strict=True)]:
        for mass in masses:
            total = total + mass.m
            moment = add(moment, scale(mass.m, add(p, times(R, mass.c))))
            if mass.h is not None:
                moment = add(moment, times(R, mass.h))
    if isinstance(total, float) and total == 0.0:
        raise SingularError(NO_CENTRE.format("no link" if base else "no link that moves"))
    return scale(1.0 / total, moment)
