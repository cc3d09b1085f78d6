"""A robot at one position q: places of its joints, centres of mass, ends, in world axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.figures.drawing import SAME
from freebody.model.description import Loop
from freebody.model.joints import KINDS, JointKind
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.model import Model
from freebody.model.struts import Strut
from freebody.model.tree import Mass, Tree
from freebody.trees.public_calls import single_vector


@dataclass(frozen=True)
class End:
    """A place of a body at which something is attached: a child (its index) or a frame (its
    name)."""

    name: str
    child: int | None
    place: Array


@dataclass(frozen=True)
class DrawnJoint:
    """A joint in the world, or the place where a loop closes: places (dim,)."""

    index: int
    """Index of the body that it carries; of a loop, of the one with its second frame; -1: the
    base."""
    name: str
    kind: JointKind
    """Kind of the joint; of a loop, the kind whose symbol it has."""
    parent: int
    """Index of the body that carries it; of a loop, of the one with its first frame."""
    origin: Array
    """Origin of the joint on the child."""
    rotation: Array
    carrier: Array
    """Place of the joint on the parent: the origin before a slide; of a rod, its other end."""
    carrier_rotation: Array
    axis: Array | None
    """World direction of a joint with an axis; None for others and for turns in the plane."""

    @property
    def symbol(self) -> str:
        """The name of the joint's symbol in drawings."""
        return self.name


@dataclass(frozen=True)
class BodyPlace(DrawnJoint):
    """A body in the world, and the joint that carries it."""

    mass: float
    com: Array
    ends: tuple[End, ...]

    @property
    def number(self) -> int:
        """The body's number in print, counted from 1; 0 is the ground."""
        return self.index + 1

    @property
    def symbol(self) -> str:
        return f"joint {self.number}"

    @property
    def stick(self) -> tuple[End | None, ...]:
        """The ends to which the body's stick reaches from its joint: where children or frames are
        attached, else its centre of mass, None."""
        far = [end for end in self.ends if np.linalg.norm(end.place - self.origin) > SAME]
        heavy = self.mass > 0 and np.linalg.norm(self.com - self.origin) > SAME
        return tuple(far) or ((None,) if heavy else ())

    @property
    def outline(self) -> tuple[tuple[Array, Array], ...]:
        """Segments of the body's stick."""
        return tuple((self.origin, self.com if end is None else end.place) for end in self.stick)

    @property
    def wheel(self) -> bool:
        """Whether it is a wheel: a body without extent that turns and carries nothing."""
        apart = bool(self.stick) or np.linalg.norm(self.com - self.origin) > SAME
        carries = any(end.child is not None for end in self.ends)
        return not apart and not carries and bool(self.mass) and self.kind.turns


@dataclass(frozen=True)
class LoopPlace(DrawnJoint):
    """The place at which a loop closes."""

    rod: bool
    """Whether the loop keeps its places a distance apart."""


@dataclass(frozen=True)
class StrutPlace:
    """A strut in the world."""

    name: str
    bodies: tuple[int, int]
    """Indices of the bodies of its ends; -1: the base."""
    ends: tuple[Array, Array]


@dataclass(frozen=True)
class Skeleton:
    """All bodies of a robot in one pose; `tip` is None where the robot has no single tip."""

    dim: int
    bodies: tuple[BodyPlace, ...]
    frames: Mapping[str, Array]
    """Place of each frame of the model."""
    loops: tuple[LoopPlace, ...]
    struts: tuple[StrutPlace, ...]
    tip: Array | None
    tip_rotation: Array | None

    @property
    def places(self) -> Array:
        """The places (k, dim) of every joint, every end and the base."""
        found = [np.zeros(self.dim)]
        for body in self.bodies:
            ends = (end.place for end in body.ends)
            found += [body.carrier, body.origin, *ends, *(b for _, b in body.outline)]
        found += [end for strut in self.struts for end in strut.ends]
        return np.array(found)

    @property
    def roots(self) -> tuple[BodyPlace, ...]:
        """Bodies that hang on the base."""
        return tuple(body for body in self.bodies if body.parent < 0)


def skeleton(model: Model, q: ArrayLike) -> Skeleton:
    """The robot's places at q (nq,)."""
    q_checked = single_vector("skeleton", model, "q", q)
    tree = model.tree
    poses = world_poses(tree, joint_poses(tree, tuple(map(float, q_checked))))
    world = [(np.asarray(R), np.asarray(p)) for R, p in poses]
    world.append((np.eye(model.dim), np.zeros(model.dim)))  # the base, at -1
    frames = {name: _pose(world, *frame) for name, frame in tree.frames.items()}
    places = {name: p for name, (_, p) in frames.items()}
    bodies = tuple(_body(model, tree, world, places, i) for i in range(len(model.bodies)))
    loops = tuple(_loop(model, frames, loop) for loop in model.loops)
    struts = tuple(_strut(model, places, strut) for strut in model.struts)
    tip = (None, None) if model.tip is None else frames[model.tip]
    return Skeleton(model.dim, bodies, places, loops, struts, tip[1], tip[0])


def _pose(world: list[tuple[Array, Array]], body: int, R: Any, p: Any) -> tuple[Array, Array]:
    """A pose given in a body of the tree (-1: the base), expressed in the world."""
    above, origin = world[body]
    return above @ np.asarray(R, dtype=float), origin + above @ np.asarray(p, dtype=float)


def _loop(model: Model, frames: dict[str, tuple[Array, Array]], loop: Loop) -> LoopPlace:
    (carrier_R, carrier), (R, p) = (frames[name] for name in loop.frames)
    first, second = (model.frame(name).body for name in loop.frames)
    axis = carrier_R @ np.asarray(loop.axis, dtype=float) if loop.axis else None
    kind = LOOP_KINDS[loop.kind]
    symbol, rod = KINDS[kind.symbol(model.dim)], kind.needs_distance
    return LoopPlace(second, loop.name, symbol, first, p, R, carrier, carrier_R, axis, rod)


def _strut(model: Model, places: dict[str, Array], strut: Strut) -> StrutPlace:
    first, second = strut.frames
    bodies = model.frame(first).body, model.frame(second).body
    return StrutPlace(strut.name, bodies, (places[first], places[second]))


def extent(poses: Sequence[Skeleton], path: Array | None = None) -> float:
    """Diagonal of the box around all places, metres; 1 where everything is at one place."""
    places = np.concatenate([pose.places for pose in poses] + ([path] if path is not None else []))
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return size if size > 1e-6 else 1.0


def _body(model: Model, tree: Tree, world: list, places: dict, i: int) -> BodyPlace:
    body, at = model.bodies[i], tree.body_of[i]
    node, (R, p) = tree.bodies[at], world[at]
    first = tree.bodies[_first(tree, i)]
    carrier_R, carrier = _pose(world, first.parent, first.R, first.p)
    one_axis = body.kind.needs_axis and len(node.axis) == model.dim
    mass, centre = mass_and_centre(node.masses, model.dim)
    ends = [
        End(child.joint.name, k, _pose(world, at, np.eye(model.dim), hung.p)[1])
        for k, child in enumerate(model.bodies)
        if child.parent == i
        for hung in [tree.bodies[_first(tree, k)]]
    ]
    ends += _leaves(model, tree, places, at)
    return BodyPlace(
        i, body.name, body.kind, body.parent, p, R, carrier, carrier_R,
        R @ np.asarray(node.axis, dtype=float) if one_axis else None,
        mass, p + R @ centre, tuple(ends),
    )  # fmt: skip


def _first(tree: Tree, i: int) -> int:
    """Index of the first primitive of a joint that is a chain of them."""
    return 1 + max((last for last in tree.body_of if last < tree.body_of[i]), default=-1)


def _leaves(model: Model, tree: Tree, places: dict, at: int) -> list[End]:
    """The tip and the leaf frames that a body carries; of several at one place the first."""
    names = [*filter(None, [model.tip]), *(leaf for leaf in model.leaves if leaf != model.tip)]
    ends: list[End] = []
    for name in names:
        free = all(np.linalg.norm(places[name] - end.place) > SAME for end in ends)
        if tree.frames[name][0] == at and free:
            ends.append(End(name, None, places[name]))
    return ends


def mass_and_centre(masses: tuple[Mass, ...], dim: int) -> tuple[float, Array]:
    """Mass and centre of mass of a body, in its axes."""
    total = float(sum(mass.m for mass in masses))
    if not total:
        return total, np.zeros(dim)
    moments = np.array([np.multiply(mass.m, mass.c) for mass in masses], dtype=float)
    return total, moments.sum(axis=0) / total
