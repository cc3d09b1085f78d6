"""Struts: springs, dampers and preloads between two points of different bodies.

Of a strut from x_A to x_B, with d = x_B - x_A and L = |d|:

    L̇ = d · ḋ / L
    f = preload + stiffness (L - rest) + damping L̇

It pulls at A with f d / L and at B with the opposite: generalized forces -f ∂L/∂q. Where both ends
are at one place it has no direction, and all that it enters is NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from freebody.algorithms.kinematics import Column, Pose, outward, world_poses
from freebody.elementary import Scalar, sqrt
from freebody.model.tree import Tree, TreeStrut
from freebody.spatial import Vector, add, dot, neg, scale, sub, times, transposed


class StrutState(NamedTuple):
    """The state of a strut: its length, its rate of length, the force that pulls its ends together,
    and that force as it acts on the first end, in world axes."""

    length: Scalar
    rate: Scalar
    tension: Scalar
    pull: Vector


def strut_state(strut: TreeStrut, d: Vector, d_rate: Vector) -> StrutState:
    """The state of a strut whose second end is at d from its first, changing at the rate d_rate."""
    length = sqrt(dot(d, d))
    rate = dot(d, d_rate) / length
    tension = strut.preload + strut.stiffness * (length - strut.rest) + strut.damping * rate
    return StrutState(length, rate, tension, scale(tension / length, d))


def strut_states(tree: Tree, q: Vector, qd: Vector) -> list[StrutState]:
    """The state of each strut."""
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    return _states(tree, motion.joints, list(zip(motion.w, motion.v, strict=True)))


def _states(tree: Tree, joints: list[Pose], velocities: Sequence[Column]) -> list[StrutState]:
    """The state of each strut, from the joints' poses and the velocities (angular, linear) of the
    bodies at their origins, in their axes."""
    space, world = tree.space, world_poses(tree, joints)

    def end(frame: str) -> tuple[Vector, Vector]:
        body, _, p = tree.frames[frame]
        if body < 0:
            return p, space.zero
        (R, o), (w, v) = world[body], velocities[body]
        return add(o, times(R, p)), times(R, add(v, space.cross(w, p)))

    return [strut_state(strut, *_apart(strut, end)) for strut in tree.struts]


def _apart(strut: TreeStrut, end: Callable[[str], tuple[Vector, Vector]]) -> tuple[Vector, Vector]:
    """The vector from a strut's first to its second end, and its rate; end: gives place and
    velocity of the end on a frame."""
    (a, a_rate), (b, b_rate) = map(end, strut.frames)
    return sub(b, a), sub(b_rate, a_rate)


def strut_loads(
    tree: Tree, joints: list[Pose], velocities: Sequence[Column]
) -> list[tuple[int, Vector, Vector]]:
    """Wrenches (body, force, moment) by which struts act on bodies, in their axes, at their
    origins."""
    if not tree.struts:
        return []
    space, world, found = tree.space, world_poses(tree, joints), []
    for strut, state in zip(tree.struts, _states(tree, joints, velocities), strict=True):
        for frame, pull in zip(strut.frames, (state.pull, neg(state.pull)), strict=True):
            body, _, p = tree.frames[frame]
            if body >= 0:
                force = times(transposed(world[body][0]), pull)
                found.append((body, force, space.moment(p, force)))
    return found


def strut_energy(tree: Tree, world: list[Pose]) -> Scalar:
    """½ stiffness (L - rest)² + preload (L - rest) of every strut, of the bodies' world poses."""

    def end(frame: str) -> tuple[Vector, Vector]:
        body, _, p = tree.frames[frame]
        place = p if body < 0 else add(world[body][1], times(world[body][0], p))
        return place, tree.space.zero

    energy: Scalar = 0.0
    for strut in tree.struts:
        d, _ = _apart(strut, end)
        stretch = sqrt(dot(d, d)) - strut.rest
        energy = energy + (0.5 * strut.stiffness * stretch + strut.preload) * stretch
    return energy


def struts_alone(tree: Tree) -> Tree:
    """The tree without weights, masses and drives: its inverse dynamics is what struts need."""
    bodies = tuple(replace(body, masses=(), drive=None) for body in tree.bodies)
    return replace(tree, bodies=bodies, gravity=tree.space.zero, base=())
