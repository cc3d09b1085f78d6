"""Recursive Newton-Euler: forces from motion (Luh, Walker, Paul 1980; notes 4.6-4.15 in the plane,
6.16-6.29 in space).

Everything is in body axes. For body i, with c its centre of mass and (R, p) the pose of child k in
i:

    v̇_c = v̇ + ω̇ × c + ω × (ω × c)                     (4.11), (6.22)
    F = m v̇_c,  N = I ω̇ + ω × I ω                      (4.12, 4.13), (6.28, 6.29)
    f_i = F + Σ_k R f_k - f_external                    (4.14)
    n_i = N + c × F + Σ_k (R n_k + p × R f_k) - n_ext   (4.15)
    tau = column · (n_i, f_i) + rotor q̈ + friction + spring, by the laws of the joint's drive,
          and what is lost of column · (n_i, f_i) + spring, which the joint transmits

Struts act on bodies as external wrenches do.

Where a mass is given about another point c than its centre, with first moment h about it, F gains
ω̇ × h + ω × (ω × h) and N gains h × v̇_c.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from freebody.algorithms.kinematics import (
    BodyMotions,
    VectorNaming,
    joint_poses,
    outward,
    unnamed,
    world_poses,
)
from freebody.algorithms.struts import strut_loads
from freebody.elementary import Scalar
from freebody.model.tree import Tree, TreeBody
from freebody.spatial import Vector, add, dot, neg, scale, sub, times, transposed

External = tuple[int, Vector, Vector]
"""(body, force, moment): a wrench on a body, in its axes, at its origin."""


@dataclass
class Recursion:
    """All intermediates of one inverse dynamics, per body, in body axes."""

    motion: BodyMotions
    vd_com: list[list[Vector]] = field(default_factory=list)
    """Acceleration of each mass's centre (6.22)."""
    F: list[list[Vector]] = field(default_factory=list)
    N: list[list[Vector]] = field(default_factory=list)
    f: list[Vector] = field(default_factory=list)
    n: list[Vector] = field(default_factory=list)
    """Force and moment by the parent on the body, at the body's origin."""
    tau: Vector = ()


def rnea(
    tree: Tree,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    external: Sequence[External] = (),
    gravity: str = "base",
    named: VectorNaming = unnamed,
) -> Recursion:
    """Inverse dynamics with all intermediates. gravity: "base" accelerates the base by -g,
    "explicit" adds each body's weight. named: the function whose result stands for each vector in
    the steps that follow."""
    space = tree.space
    motion = outward(tree, q, qd, qdd, neg(tree.gravity) if gravity == "base" else None, named)
    weights = _fields(tree, motion, named) if gravity == "explicit" else None
    result = Recursion(motion)
    f: list[Vector] = []
    n: list[Vector] = []
    for i, body in enumerate(tree.bodies):
        centres, forces, moments = [], [], []
        f_i, n_i = space.zero, space.zero_angular
        for mass in body.masses:
            centre = named("vd_com", i, add(motion.vd[i], times(motion.rates[i], mass.c)))
            F = scale(mass.m, centre)
            N = space.euler(mass.inertia, motion.w[i], motion.wd[i])
            if mass.h is not None:
                F = add(F, times(motion.rates[i], mass.h))
                N = add(
                    N, space.moment(mass.h, centre if weights is None else sub(centre, weights[i]))
                )
            F, N = named("F", i, F), named("N", i, N)
            needed = F if weights is None else sub(F, scale(mass.m, weights[i]))
            f_i, n_i = add(f_i, needed), add(n_i, N, space.moment(mass.c, needed))
            centres.append(centre)
            forces.append(F)
            moments.append(N)
        f.append(f_i)
        n.append(n_i)
        result.vd_com.append(centres)
        result.F.append(forces)
        result.N.append(moments)
    velocities = tuple(zip(motion.w, motion.v, strict=True))
    for i, force, moment in (*external, *strut_loads(tree, motion.joints, velocities)):
        f[i], n[i] = sub(f[i], force), sub(n[i], moment)
    tau: list[Scalar] = [0.0] * tree.nv
    for i in reversed(range(len(tree.bodies))):
        body = tree.bodies[i]
        f[i], n[i] = named("f", i, f[i]), named("n", i, n[i])
        for k, torque in zip(
            body.coordinates.v, joint_torque(body, n[i], f[i], q, qd, qdd), strict=True
        ):
            tau[k] = tau[k] + (
                torque if body.coordinates.ratio == 1.0 else body.coordinates.ratio * torque
            )
        if body.parent >= 0:
            R, p = motion.joints[i]
            f_parent = times(R, f[i])
            f[body.parent] = add(f[body.parent], f_parent)
            n[body.parent] = add(n[body.parent], space.turn(R, n[i]), space.moment(p, f_parent))
    result.f, result.n, result.tau = f, n, tuple(tau)
    return result


def joint_torque(
    body: TreeBody, n: Vector, f: Vector, q: Vector, qd: Vector, qdd: Vector
) -> Vector:
    """The torque that the motor of a joint must give, along each of its columns."""
    torques = [dot(w, n) + dot(v, f) for w, v in body.columns]
    if body.drive is not None:
        drive = body.drive
        lost = drive.lost(torques[0], q, qd) if drive.lossy else None
        torques[0] = torques[0] + drive.torque(q, qd) + drive.inertia * body.rates(qdd)[0]
        if lost is not None:
            torques[0] = torques[0] + lost
    return tuple(torques)


def _fields(tree: Tree, motion: BodyMotions, named: VectorNaming) -> list[Vector]:
    """The gravity field in each body's axes."""
    fields: list[Vector] = []
    for i, (body, (R, _)) in enumerate(zip(tree.bodies, motion.joints, strict=True)):
        field = times(transposed(R), tree.gravity if body.parent < 0 else fields[body.parent])
        fields.append(named("field", i, field))
    return fields


def external_on_frame(tree: Tree, q: Vector, frame: str, wrench: Vector) -> External | None:
    """A wrench (force, moment) on a frame's origin, in world axes, as it acts on its body; None on
    the base."""
    space = tree.space
    body, _, p = tree.frames[frame]
    if body < 0:
        return None
    R, _ = world_poses(tree, joint_poses(tree, q))[body]
    E = transposed(R)
    force = times(E, wrench[: space.dim])
    return body, force, add(space.turn(E, wrench[space.dim :]), space.moment(p, force))


def joint_wrenches(tree: Tree, recursion: Recursion, reference: str = "world") -> list[Vector]:
    """For each joint of the model (force, moment) on the child by the parent at the child's origin,
    world or child axes."""
    world = world_poses(tree, recursion.motion.joints)
    rows = []
    for i in tree.body_of:
        force, moment = recursion.f[i], recursion.n[i]
        if reference == "world":
            R, _ = world[i]
            force, moment = times(R, force), tree.space.turn(R, moment)
        rows.append(force + moment)
    return rows
