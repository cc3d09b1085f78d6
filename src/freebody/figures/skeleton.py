"""Where everything of a robot is at one position q: joints, centres of mass, ends, in world
axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.model.joints import JointKind
from freebody.model.model import Model
from freebody.model.tree import Mass, Tree
from freebody.trees.calls import single_vector

_SAME = 1e-6  # metres: places nearer than this are one


@dataclass(frozen=True)
class End:
    """A place of a body where something hangs: a child (its index) or a frame (its name)."""

    name: str
    child: int | None
    place: Array


@dataclass(frozen=True)
class BodyPlace:
    """One body in the world; arrays of shape (dim,)."""

    index: int
    name: str
    kind: JointKind
    parent: int
    origin: Array
    """The child's joint origin."""
    rotation: Array
    carrier: Array
    """Where its joint sits on the parent: the origin before a slide."""
    carrier_rotation: Array
    axis: Array | None
    """World direction of a one-axis joint; None for others and for turns in the plane."""
    mass: float
    com: Array
    ends: tuple[End, ...]

    @property
    def number(self) -> int:
        """Bodies count from 1 in print; 0 is the ground."""
        return self.index + 1

    @property
    def outline(self) -> tuple[tuple[Array, Array], ...]:
        """Segments of its stick: from its joint to where others hang, else to its centre of
        mass."""
        far = [end.place for end in self.ends if np.linalg.norm(end.place - self.origin) > _SAME]
        if not far and self.mass > 0 and np.linalg.norm(self.com - self.origin) > _SAME:
            far = [self.com]
        return tuple((self.origin, place) for place in far)


@dataclass(frozen=True)
class Skeleton:
    """All bodies; `tip` is None where the robot has no single tip."""

    dim: int
    bodies: tuple[BodyPlace, ...]
    tip: Array | None
    tip_rotation: Array | None

    @property
    def places(self) -> Array:
        """Every joint, end and the base, (k, dim)."""
        found = [np.zeros(self.dim)]
        for body in self.bodies:
            found += [
                body.carrier,
                body.origin,
                *(end.place for end in body.ends),
                *(b for _, b in body.outline),
            ]
        return np.array(found)

    @property
    def roots(self) -> tuple[BodyPlace, ...]:
        """Bodies that hang on the base."""
        return tuple(body for body in self.bodies if body.parent < 0)


def skeleton(model: Model, q: ArrayLike) -> Skeleton:
    """The robot's places at q (nq,)."""
    q_checked = single_vector("skeleton", model, "q", q)
    tree = model.tree
    world = [
        (np.asarray(R), np.asarray(p))
        for R, p in world_poses(tree, joint_poses(tree, tuple(map(float, q_checked))))
    ]
    frames = {
        name: (body, np.asarray(R, dtype=float), np.asarray(p, dtype=float))
        for name, (body, R, p) in tree.frames.items()
    }
    rest = (np.eye(model.dim), np.zeros(model.dim))
    bodies = []
    for i in range(len(model.bodies)):
        bodies.append(_body(model, tree, world, frames, i, rest))
    tip = tip_rotation = None
    if model.tip is not None:
        at, R, p = frames[model.tip]
        W, o = world[at] if at >= 0 else rest
        tip, tip_rotation = o + W @ p, W @ R
    return Skeleton(model.dim, tuple(bodies), tip, tip_rotation)


def extent(poses: Sequence[Skeleton], path: Array | None = None) -> float:
    """Diagonal of the box around all places, metres; 1 where everything is at one place."""
    places = np.concatenate([pose.places for pose in poses] + ([path] if path is not None else []))
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return size if size > 1e-6 else 1.0


def _body(
    model: Model, tree: Tree, world: list, frames: dict, i: int, rest: tuple[Array, Array]
) -> BodyPlace:
    body, at = model.bodies[i], tree.body_of[i]
    node = tree.bodies[at]
    R, p = world[at]
    first = tree.bodies[_first(tree, i)]
    above_R, above_p = world[first.parent] if first.parent >= 0 else rest
    carrier, carrier_R = (
        above_p + above_R @ np.asarray(first.p, dtype=float),
        above_R @ np.asarray(first.R, dtype=float),
    )
    one_axis = body.kind.nv == 1 and len(node.axis) == model.dim and model.dim > 1
    mass, centre = _centre(node.masses, model.dim)
    ends = [
        End(child.joint.name, k, world[tree.body_of[k]][1])
        if not child.kind.slides
        else End(
            child.joint.name, k, p + R @ np.asarray(tree.bodies[tree.body_of[k]].p, dtype=float)
        )
        for k, child in enumerate(model.bodies)
        if child.parent == i
    ]
    ends += _leaves(model, frames, at, R, p)
    return BodyPlace(
        i, body.name, body.kind, body.parent, p, R, carrier, carrier_R,
        R @ np.asarray(node.axis, dtype=float) if one_axis else None,
        mass, p + R @ centre, tuple(ends),
    )  # fmt: skip


def _first(tree: Tree, i: int) -> int:
    """Index of the first primitive of a joint that is a chain of them."""
    return 1 + max((last for last in tree.body_of if last < tree.body_of[i]), default=-1)


def _leaves(model: Model, frames: dict, at: int, R: Array, p: Array) -> list[End]:
    """The tip and the leaves that this body carries, farthest first; of several leaves at one place
    the first."""
    names = [
        *([model.tip] if model.tip else []),
        *(leaf for leaf in model.leaves if leaf != model.tip),
    ]
    ends: list[End] = []
    for name in names:
        carried, _, local = frames[name]
        place = p + R @ local
        if carried == at and all(np.linalg.norm(place - end.place) > _SAME for end in ends):
            ends.append(End(name, None, place))
    return ends


def _centre(masses: tuple[Mass, ...], dim: int) -> tuple[float, Array]:
    """Mass and centre of mass of a body, in its axes."""
    total = float(sum(mass.m for mass in masses))
    if not total:
        return total, np.zeros(dim)
    moments = np.array([np.multiply(mass.m, mass.c) for mass in masses], dtype=float)
    return total, moments.sum(axis=0) / total
