"""Kinetic and potential energy and momentum (notes, 5.1-5.5)."""

from __future__ import annotations

from freebody.algorithms.kinematics import joint_poses, outward, world_poses
from freebody.algorithms.struts import strut_energy
from freebody.elementary import Scalar
from freebody.model.tree import Mass, Pose, Tree
from freebody.spatial import Vector, add, dot, identity, scale, sub, times


def kinetic_energy(tree: Tree, q: Vector, qd: Vector) -> Scalar:
    """½ m v_c² + ½ ω·I ω of every body (5.3), and ½ J gear² q̇² of every rotor."""
    space = tree.space
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    twice: Scalar = 0.0
    for i, body in enumerate(tree.bodies):
        w = motion.w[i]
        for mass in body.masses:
            v = add(motion.v[i], space.cross(w, mass.c))
            twice = twice + mass.m * dot(v, v) + dot(w, space.inertia_times(mass.inertia, w))
            if mass.h is not None:
                twice = twice + 2.0 * dot(v, space.cross(w, mass.h))
        if body.drive is not None:
            (rate,) = body.rates(qd)
            twice = twice + body.drive.inertia * (rate * rate)
    return 0.5 * twice


def potential_energy(tree: Tree, q: Vector) -> Scalar:
    """-m g·r_c of every body (5.4), zero at the world's origin, and ½ k (q - rest)² of every spring
    (5.5), struts included."""
    energy = resting_energy(tree)
    world = world_poses(tree, joint_poses(tree, q))
    for body, pose in zip(tree.bodies, world, strict=True):
        energy = energy + _of_weight(tree, body.masses, pose)
        if body.drive is not None:
            energy = energy + body.drive.energy(q)
    return energy + strut_energy(tree, world) if tree.struts else energy


def resting_energy(tree: Tree) -> Scalar:
    """-m g·r_c of what is fixed to the base, which no motion changes."""
    return _of_weight(tree, tree.base, (identity(tree.space.dim), tree.space.zero))


def _of_weight(tree: Tree, masses: tuple[Mass, ...], pose: Pose) -> Scalar:
    """The potential energy -m g·r_c of the masses of one body at its pose in the world."""
    energy: Scalar = 0.0
    R, p = pose
    for mass in masses:
        energy = energy - mass.m * dot(tree.gravity, add(p, times(R, mass.c)))
        if mass.h is not None:
            energy = energy - dot(tree.gravity, times(R, mass.h))
    return energy


def momentum(tree: Tree, q: Vector, qd: Vector, about: Vector | None = None) -> Vector:
    """Linear, then angular momentum about a point of the world (default its origin), in world axes;
    rotors not counted."""
    space = tree.space
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    linear, angular = space.zero, space.zero_angular
    for i, (R, p) in enumerate(world_poses(tree, motion.joints)):
        w = motion.w[i]
        for mass in tree.bodies[i].masses:
            v = add(motion.v[i], space.cross(w, mass.c))
            momentum = scale(mass.m, v)
            spin = space.inertia_times(mass.inertia, w)
            if mass.h is not None:
                momentum = add(momentum, space.cross(w, mass.h))
                spin = add(spin, space.moment(mass.h, v))
            m_v = times(R, momentum)
            arm = add(p, times(R, mass.c))
            if about is not None:
                arm = sub(arm, about)
            linear = add(linear, m_v)
            angular = add(angular, space.turn(R, spin), space.moment(arm, m_v))
    return linear + angular
