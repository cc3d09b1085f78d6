"""A model as rigid bodies in space with lines as their joints: the form in which two robots are
compared, whatever their frames are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.facts import norm
from freebody.lazy import Keeps, cached_property
from freebody.model.bodies import Body
from freebody.model.inertia import combined
from freebody.model.model import Model
from freebody.model.placement import ArrayPose, Placement, composed
from freebody.model.quantity_reader import VALUES
from freebody.model.shafts import with_rigid_joints
from freebody.model.tree import Attached
from freebody.spatial import space

_Z = np.array([0.0, 0.0, 1.0])
_PARALLEL = 1e-9
"""Sine below which two lines are parallel."""


class Weight(NamedTuple):
    """Mass (kg), centre of mass and tensor about it, in the body's axes."""

    mass: float
    com: Array
    tensor: Array


class SeenAxis(NamedTuple):
    """A joint's axis: its direction, and a point on it."""

    direction: Array
    point: Array


@dataclass(frozen=True)
class Part(Keeps):
    """A body with the joint that carries it: the joint's frame in the parent's, its axis there; of
    a planar model in the xy-plane."""

    body: Body
    index: int
    pose: ArrayPose
    axis: Array | None
    """Unit vector along a joint of one coordinate; None of other kinds."""
    dim: int
    shaft: Body | None = None
    """The body with the shaft of a flexible joint, of which this is the whole."""

    @property
    def joint(self) -> str:
        """The joint's name."""
        return self.body.joint.name

    @property
    def turns(self) -> bool:
        """Whether the joint turns about its axis, whether or not it also slides along it."""
        return self.axis is not None and not self.body.kind.slides

    @property
    def sort(self) -> str:
        """The kind of joint for comparisons; a turning joint counts as revolute with and without a
        range."""
        return "revolute" if self.body.kind.turns else self.body.joint.kind

    def line(self, at: ArrayPose) -> SeenAxis:
        """The joint's axis (z where it has none) in the axes in which the parent's frame has the
        pose `at`."""
        R, p = composed(at, self.pose)
        return SeenAxis(R @ (_Z if self.axis is None else self.axis), p)

    @cached_property
    def weight(self) -> Weight | None:
        """The masses of all that is fixed to the body, taken together; None where there are
        none."""
        return weight(self.body.inertias, self.dim)


def weight(parts: Sequence[Attached], dim: int) -> Weight | None:
    """The mass, centre and tensor of parts that are fixed together; None where they have no
    mass."""
    placed = [
        part.inertia.placed(*part.placement.arrays(dim))
        for part in parts
        if any(part.inertia.numbers()[0:1]) or any(map(VALUES.quantity, part.inertia.tensor))
    ]
    if not placed:
        return None
    mass, com, tensor = combined(placed).numbers()
    if dim == 2:
        com = np.array([*com, 0.0])
        tensor = np.diag([0.0, 0.0, float(tensor[0, 0])])
    return Weight(mass, com, tensor)


class BodyTree:
    """A model's parts as a tree; those on the base are the children of -1. A flexible joint is one
    joint with a shaft."""

    def __init__(self, model: Model):
        self.model, shafts = with_rigid_joints(model)
        self.parts = [
            _part(body, k, model.dim, shafts.get(k)) for k, body in enumerate(self.model.bodies)
        ]
        self.children: dict[int, list[Part]] = {k: [] for k in range(-1, len(self.parts))}
        for part in self.parts:
            self.children[part.body.parent].append(part)
        self.count: dict[int, int] = {}
        """The number of joints beyond each body."""
        for k in reversed(self._ordered()):
            self.count[k] = sum(1 + self.count[x.index] for x in self.children[k])

    def _ordered(self) -> list[int]:
        order = [-1]
        for k in order:
            order += [part.index for part in self.children[k]]
        return order

    @cached_property
    def reach(self) -> float:
        """The sum of the steps along the longest chain, up to a centre of mass (m), at least
        1 mm."""
        far: dict[int, float] = {}
        for k in reversed(self._ordered()):
            own = self.parts[k].weight if k >= 0 else None
            centre = 0.0 if own is None else norm(own.com)
            steps = [norm(x.pose[1]) + far[x.index] for x in self.children[k]]
            far[k] = max(centre, *steps, 0.0)
        return max(far[-1], 1e-3)

    def main_chain(self) -> list[SeenAxis]:
        """The axes from the base along the longest chain, in the base's axes where all joints are
        at 0."""
        at: ArrayPose = np.eye(3), np.zeros(3)
        lines, k = [], -1
        while self.children[k]:
            part = max(self.children[k], key=lambda x: self.count[x.index])
            lines.append(part.line(at))
            at, k = composed(at, part.pose), part.index
        return lines

    def foot(self) -> Array:
        """A point of the first turning axis that no offset of a joint's zero shifts along it, in
        the base's axes: where it is nearest to the next axis that is not parallel; else at the
        height of the first body's centre of mass or frame."""
        at: ArrayPose = np.eye(3), np.zeros(3)
        first, k = None, -1
        while self.children[k]:
            part = max(self.children[k], key=lambda x: self.count[x.index])
            line = part.line(at)
            at, k = composed(at, part.pose), part.index
            if first is None:
                if part.turns:
                    first, body, pose = line, part, at
                continue
            if norm(cross(first.direction, line.direction)) > _PARALLEL:
                if part.turns:
                    return nearest(first, line)
            elif not part.turns:
                break
        if first is None:
            return np.zeros(3)
        if body.weight is None:
            return first.point
        centre = pose[0] @ body.weight.com + pose[1]
        return first.point + first.direction * (first.direction @ (centre - first.point))


def _part(body: Body, index: int, dim: int, shaft: Body | None) -> Part:
    joint = body.joint
    axis = None
    if body.kind.nv == 1:
        axis = _Z if dim == 2 and body.kind.turns else np.array([*joint.axis, 0.0][:3])
    return Part(body, index, pose_in_space(joint.placement, dim), axis, dim, shaft)


def floating(model: Model) -> Body | None:
    """The body that carries a whole robot and floats itself; None where something else stands, or
    is held, on the ground."""
    roots = [body for body in model.bodies if body.parent < 0]
    if len(roots) != 1 or not roots[0].kind.frees(model.dim):
        return None
    ends = {name for part in (*model.loops, *model.struts) for name in part.frames}
    grounded = any(frame.body < 0 and frame.name in ends for frame in model.frames)
    return None if grounded else roots[0]


def held(model: Model) -> Model:
    """The model with the body that floats as its fixed base; itself where none does."""
    base = floating(model)
    if base is None:
        return model
    gone = model.bodies.index(base)
    index = {k: k - (k > gone) for k in range(-1, len(model.bodies))} | {gone: -1}
    own = {x for x in model.position_names if x.rpartition(".")[0] == base.joint.name}
    return replace(
        model,
        bodies=tuple(
            replace(body, parent=index[body.parent])
            for k, body in enumerate(model.bodies)
            if k != gone
        ),
        frames=tuple(replace(frame, body=index[frame.body]) for frame in model.frames),
        base_inertias=base.inertias,
        home=tuple((name, x) for name, x in model.home if name not in own),
    )


def pose_in_space(placement: Placement, dim: int) -> ArrayPose:
    """A placement's pose; of the plane, that in the xy-plane of space."""
    R, p = placement.arrays(dim)
    if dim == 3:
        return R, p
    turned = np.eye(3)
    turned[:2, :2] = R
    return turned, np.array([*p, 0.0])


def nearest(line: SeenAxis, other: SeenAxis) -> Array:
    """The point of a line that is nearest to another one, which is not parallel."""
    (u, p), (v, q) = line, other
    n = cross(u, v)
    return p + u * float(cross(q - p, v) @ n / (n @ n))


def cross(u: Array, v: Array) -> Array:
    """The cross product of two vectors; NumPy's takes ten times as long for so few."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def inverse(pose: ArrayPose) -> ArrayPose:
    """The inverse of a pose, which leads back."""
    R, p = pose
    return R.T, -R.T @ p


def turned(axis: Array, angle: float) -> Array:
    """The rotation about a unit vector by an angle (rad)."""
    return np.array(space.rotation(tuple(axis.tolist()), angle))


def rotation_between(u: Array, v: Array) -> Array:
    """The least rotation that takes one unit vector to another."""
    normal, cosine = cross(u, v), float(u @ v)
    sine = norm(normal)
    if sine > 1e-15:
        return turned(normal / sine, float(np.arctan2(sine, cosine)))
    if cosine > 0.0:
        return np.eye(3)
    aside = cross(u, np.eye(3)[np.argmin(np.abs(u))])
    return turned(aside / norm(aside), np.pi)
