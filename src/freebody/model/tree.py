"""A model in scalars: the tree on which algorithms run.

`lower` turns names and placements into numbers, or into whatever a reader makes of them. Joints
become chains of primitives, in an order where parents come first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.lazy import Keeps
from freebody.model.drives.acting import ActingLaw, DriveScalars, counted, every_law
from freebody.model.families import arrays_in
from freebody.model.inertia import Inertia, combined
from freebody.model.joints.kind import Column, Primitive
from freebody.model.loop_kinds import LOOP_KINDS, Closure
from freebody.model.losses import loss_fault
from freebody.model.parameters import Quantity, each_parameter
from freebody.model.placement import Placement
from freebody.model.quantity_reader import QuantityReader
from freebody.spatial import AnySpace, Matrix, Vector, add, identity, of_dimension, scale, times

if TYPE_CHECKING:
    from freebody.model.bodies import Body, Frame
    from freebody.model.description import Drive, Joint
    from freebody.model.model import Model


Pose = tuple[Matrix, Vector]
"""(R, p): axes and origin of a frame."""


@dataclass(frozen=True)
class Attached(Keeps):
    """The inertia of one link or load, given in a frame placed in the body's frame."""

    link: str
    inertia: Inertia
    placement: Placement = Placement()
    load: bool = False
    frame: str = ""
    """The frame that a load rides in."""


@dataclass(frozen=True)
class Coordinates:
    """The entries of q and q̇ that move a joint, and how: joint position = ratio · q + offset."""

    q: tuple[int, ...]
    v: tuple[int, ...]
    ratio: float
    offset: float

    def position(self, q: Vector) -> Vector:
        """The position scalars of the joint itself."""
        if self.ratio == 1.0 and self.offset == 0.0:
            return tuple(q[k] for k in self.q)
        return tuple(self.ratio * q[k] + self.offset for k in self.q)

    def rates(self, qd: Vector) -> Vector:
        """The rates of the joint itself, from q̇ or q̈."""
        if self.ratio == 1.0:
            return tuple(qd[k] for k in self.v)
        return tuple(self.ratio * qd[k] for k in self.v)


@dataclass(frozen=True)
class Mass:
    """Mass m, with first moment h and inertia about a point c of the body, in its axes.

    In the central form c is the centre of mass and h None. In the linear form c is the body's
    origin: there masses add up entry by entry, and without mass nothing is divided by it.
    """

    m: Scalar
    c: Vector
    inertia: Scalar
    h: Vector | None = None


@dataclass(frozen=True)
class TreeBody:
    """A body behind one primitive joint; R, p: the joint's frame in the parent's."""

    name: str
    parent: int
    primitive: Primitive
    axis: Vector
    columns: tuple[Column, ...]
    R: Matrix
    p: Vector
    coordinates: Coordinates
    masses: tuple[Mass, ...]
    drive: DriveScalars | None
    """Scalars of the joint's drive; None where no law of a drive acts."""

    def position(self, q: Vector) -> Vector:
        """The position scalars of the joint itself."""
        return self.coordinates.position(q)

    def rates(self, qd: Vector) -> Vector:
        """The rates of the joint itself, from q̇ or q̈."""
        return self.coordinates.rates(qd)


@dataclass(frozen=True)
class TreeLoop:
    """A loop in scalars: its equations, its two frames, and the distance between their origins
    where its kind fixes one."""

    name: str
    closure: Closure
    frames: tuple[str, str]
    distance: Scalar


@dataclass(frozen=True)
class TreeStrut:
    """A strut between the origins of two frames, with its numbers."""

    name: str
    frames: tuple[str, str]
    stiffness: Scalar
    rest: Scalar
    damping: Scalar
    preload: Scalar


@dataclass(frozen=True)
class Tree:
    """A robot in scalars: its bodies, parents first, and gravity."""

    space: AnySpace
    bodies: tuple[TreeBody, ...]
    gravity: Vector
    nq: int
    nv: int
    body_of: tuple[int, ...]
    """For each body of the model, its index here."""
    frames: dict[str, tuple[int, Matrix, Vector]]
    """For each frame its body here (-1: base) and its constant pose in it."""
    base: tuple[Mass, ...]
    loops: tuple[TreeLoop, ...] = ()
    struts: tuple[TreeStrut, ...] = ()

    @property
    def constraints(self) -> int:
        """Number of loop equations."""
        return sum(loop.closure.size(self.space) for loop in self.loops)

    @property
    def follows(self) -> bool:
        """Whether some coordinate moves more than one joint."""
        used = [k for body in self.bodies for k in body.coordinates.v]
        return len(used) != len(set(used))

    @property
    def lossy(self) -> bool:
        """Whether some joint loses part of the torque that it transmits."""
        return any(body.drive is not None and body.drive.lossy for body in self.bodies)

    def children(self, i: int) -> tuple[int, ...]:
        """Indices of the bodies that hang on body i."""
        return tuple(k for k, body in enumerate(self.bodies) if body.parent == i)


class Pieces:
    """The pieces of a model as scalars: here each quantity is read by a reader."""

    def __init__(self, space: AnySpace, reader: QuantityReader):
        self.space, self.reader = space, reader

    def pose(self, placement: Placement) -> Pose:
        """A constant pose (R, p) in scalars."""
        return placement.lower(self.space, self.reader)

    def axis(self, axis: Vector) -> Vector:
        """The constant unit axis of a joint."""
        return self.reader.axis(axis)

    def own(self, joint: Joint) -> Vector:
        """The numbers of a joint's kind other than its axis; they are read after the joint's
        pose."""
        return tuple(map(self.reader.quantity, joint.numbers))

    def masses(self, parts: tuple[Attached, ...]) -> tuple[Mass, ...]:
        """The masses that are fixed to a body."""
        return _masses(self.space, parts, self.reader)

    def laws(self, body: Body) -> tuple[ActingLaw, ...]:
        """The laws of drives along a body's joint."""
        return laws_of(body.joint.drive, self.reader)

    def gravity(self, size: Quantity, direction: tuple[float, ...]) -> Vector:
        """Gravity field in world axes."""
        return scale(self.reader.quantity(size), tuple(self.reader.quantity(x) for x in direction))

    def distance(self, distance: Quantity) -> Scalar:
        """The distance at which a loop keeps two frames."""
        return self.reader.quantity(distance)

    def strut(self, numbers: tuple[Quantity, ...]) -> Vector:
        """The numbers of a strut."""
        return tuple(map(self.reader.quantity, numbers))

    def frames(self, model: Model) -> tuple[Frame, ...]:
        """The frames that the tree shall hold."""
        return model.frames


def lower(model: Model, reader: QuantityReader) -> Tree:
    """The model's tree, its numbers and parameters read by `reader`."""
    return tree_of(model, Pieces(of_dimension(model.dim), reader))


def tree_of(model: Model, pieces: Pieces) -> Tree:
    """The model's tree, its pieces taken in a fixed order: bodies, parents first; gravity; loops;
    struts; base; frames."""
    if problem := loss_fault(model.bodies, model.loops):
        raise ModelError(f"{model.name!r}: {problem}.")
    space = pieces.space
    bodies: list[TreeBody] = []
    body_of: dict[int, int] = {-1: -1}
    for i in parents_first(model.bodies):
        body = model.bodies[i]
        at = model.coordinates[i]
        R, p = pieces.pose(body.joint.placement)
        numbers = pieces.own(body.joint)
        masses = pieces.masses(body.inertias)
        chain = body.kind.primitives(space, pieces.axis(body.joint.axis), numbers)
        laws = pieces.laws(body) if len(chain) == 1 else ()
        parent = body_of[body.parent]
        iq = iv = 0
        for k, (primitive, axis) in enumerate(chain):
            last = k == len(chain) - 1
            own = Coordinates(
                at.q[iq : iq + primitive.nq], at.v[iv : iv + primitive.nv], at.ratio, at.offset
            )
            bodies.append(
                TreeBody(
                    body.name,
                    parent,
                    primitive,
                    axis,
                    primitive.columns(space, axis),
                    R,
                    p,
                    own,
                    masses if last else (),
                    DriveScalars(laws, own) if laws else None,
                )
            )
            iq, iv = iq + primitive.nq, iv + primitive.nv
            parent = len(bodies) - 1
            R, p = identity(space.dim), space.zero
        body_of[i] = parent
    gravity = pieces.gravity(model.gravity_size, model.gravity_direction)
    loops = tuple(
        TreeLoop(
            loop.name,
            LOOP_KINDS[loop.kind].closure(space, pieces.axis(loop.axis)),
            loop.frames,
            0.0 if loop.distance is None else pieces.distance(loop.distance),
        )
        for loop in model.loops
    )
    struts = tuple(
        TreeStrut(strut.name, strut.frames, *pieces.strut(strut.numbers)) for strut in model.struts
    )
    base = pieces.masses(model.base_inertias)
    return Tree(
        space,
        tuple(bodies),
        gravity,
        model.nq,
        model.nv,
        tuple(body_of[i] for i in range(len(model.bodies))),
        {f.name: (body_of[f.body], *pieces.pose(f.placement)) for f in pieces.frames(model)},
        base,
        loops,
        struts,
    )


def parents_first(bodies: Sequence[Body]) -> list[int]:
    """Indices of a model's bodies, each after its parent, otherwise in the file's order."""
    carried: dict[int, list[int]] = {}
    for i, body in enumerate(bodies):
        carried.setdefault(body.parent, []).append(i)
    order: list[int] = []
    level = carried.get(-1, [])
    while level:
        order += level
        level = sorted(child for i in level for child in carried.get(i, ()))
    return order


def _masses(
    space: AnySpace, parts: tuple[Attached, ...], reader: QuantityReader
) -> tuple[Mass, ...]:
    """The masses fixed to a body, in its axes; those with plain numbers are combined to one."""
    varied = [any(each_parameter(a)) or bool(arrays_in(a)) for a in parts]
    plain = [
        a
        for a, x in zip(parts, varied, strict=True)
        if not x and any((a.inertia.mass, *a.inertia.tensor))
    ]
    named = [a for a, x in zip(parts, varied, strict=True) if x]
    # negative masses may add up to a first moment without mass, which has no centre
    positive = all(a.inertia.numbers()[0] >= 0.0 for a in plain)
    if reader.combines and len(plain) > 1 and positive:
        moved = [a.inertia.placed(*a.placement.lower(space, reader)) for a in plain]
        plain = [Attached("", combined(moved))]
    masses = [placed_mass(space, a, reader) for a in (*named, *plain)]
    return tuple(mass for mass in masses if not _is_nothing(mass))


def placed_mass(space: AnySpace, part: Attached, reader: QuantityReader) -> Mass:
    """A mass that is fixed to a body, in the body's axes."""
    return in_body(space, part.inertia.lower(reader), part.placement.lower(space, reader))


def in_body(space: AnySpace, inertia: tuple[Scalar, Vector, Scalar], pose: Pose) -> Mass:
    """(mass, centre, inertia about it) of what is fixed to a body at a pose, in the body's axes."""
    return Mass(*_placed(space, inertia, pose))


def _placed(
    space: AnySpace, inertia: tuple[Scalar, Vector, Scalar], pose: Pose
) -> tuple[Scalar, Vector, Scalar]:
    (m, c, about), (R, p) = inertia, pose
    if R is identity(space.dim):  # as it is where nothing turns
        return m, add(p, c), about
    turned = about if _is_zero(about) else space.turned_inertia(R, about)
    return m, add(p, times(R, c)), turned


def placed_composite(
    space: AnySpace, inertia: tuple[Scalar, Vector, Scalar], pose: Pose
) -> tuple[Scalar, Vector, Scalar]:
    """The mass, first moment and inertia about the body's origin of what is fixed to a body."""
    m, c, about = _placed(space, inertia, pose)
    return m, scale(m, c), space.plus_inertia(about, space.steiner(m, space.zero, c))


Composite = tuple[Scalar, Vector, Scalar]
"""(mass, first moment, inertia) about an origin."""


def about_origin(space: AnySpace, masses: Iterable[Mass]) -> Composite:
    """Masses as one: mass, first moment and inertia about the body's origin."""
    total = None
    for mass in masses:
        about = space.zero if mass.h is None else mass.h
        m = mass.m
        h = scale(mass.m, mass.c) if mass.h is None else add(scale(mass.m, mass.c), mass.h)
        inertia = space.plus_inertia(mass.inertia, space.steiner(mass.m, about, mass.c))
        if total is not None:
            m, h, inertia = total[0] + m, add(total[1], h), space.plus_inertia(total[2], inertia)
        total = m, h, inertia
    return total or (0.0, space.zero, space.no_inertia)


def _is_nothing(mass: Mass) -> bool:
    return isinstance(mass.m, float) and mass.m == 0.0 and _is_zero(mass.inertia)


def _is_zero(inertia: Scalar) -> bool:
    """Whether all entries are the number 0, and none a parameter's scalar or an array of a
    family."""
    for row in inertia if isinstance(inertia, tuple) else ((inertia,),):
        for x in row:
            if not isinstance(x, float) or x != 0.0:
                return False
    return True


def laws_of(drive: Drive, reader: QuantityReader) -> tuple[ActingLaw, ...]:
    """The laws of a drive that act, and the usual ones with them, with their scalars."""
    return counted(every_law(lambda name: reader.quantity(getattr(drive, name))))
