"""The model in scalars: what the algorithms run on.

`lower` turns names and placements into numbers, or into whatever a reader makes of them. Joints become chains of
primitives, in an order where parents come first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from freebody.elementary import Scalar
from freebody.model.closures import LOOP_KINDS, Closure
from freebody.model.inertia import Inertia, combined
from freebody.model.joints.kind import Column, Primitive
from freebody.model.members import arrays_in
from freebody.model.parameters import each_parameter
from freebody.model.placement import Placement
from freebody.model.reading import Reader
from freebody.spatial import AnySpace, Matrix, Vector, add, identity, of_dimension, scale, times

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.model import Model


@dataclass(frozen=True)
class Attached:
    """The inertia of one link, or of a load, given in a frame placed in the body's."""

    link: str
    inertia: Inertia
    placement: Placement = Placement()
    load: bool = False
    frame: str = ""
    """Of a load: the frame that it rides in."""


@dataclass(frozen=True)
class Coordinates:
    """Which entries of q and q̇ move a joint, and how: joint position = ratio · q + offset."""

    q: tuple[int, ...]
    v: tuple[int, ...]
    ratio: float
    offset: float


@dataclass(frozen=True)
class Mass:
    """Mass m, with first moment h and inertia about a point c of the body, in its axes.

    In the central form c is the centre of mass and h None. In the linear form c is the body's origin: there masses add
    up entry by entry, and without mass nothing is divided by it.
    """

    m: Scalar
    c: Vector
    inertia: Scalar
    h: Vector | None = None


@dataclass(frozen=True)
class DriveScalars:
    """Friction, reflected rotor inertia and spring of a one-axis joint."""

    viscous: Scalar
    coulomb: Scalar
    rotor: Scalar
    stiffness: Scalar
    rest: Scalar


@dataclass(frozen=True)
class TreeBody:
    """A body behind one primitive joint. R, p: the joint's frame in the parent's."""

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
    """None where neither friction nor rotor nor spring acts."""

    def position(self, q: Vector) -> Vector:
        """The joint's own position scalars."""
        at = self.coordinates
        if at.ratio == 1.0 and at.offset == 0.0:
            return tuple(q[k] for k in at.q)
        return tuple(at.ratio * q[k] + at.offset for k in at.q)

    def rates(self, qd: Vector) -> Vector:
        """The joint's own rates, first or second."""
        at = self.coordinates
        return tuple(qd[k] for k in at.v) if at.ratio == 1.0 else tuple(at.ratio * qd[k] for k in at.v)


@dataclass(frozen=True)
class TreeLoop:
    """A loop: its equations, its two frames, and how far apart their origins stay where it is a distance."""

    name: str
    closure: Closure
    frames: tuple[str, str]
    distance: Scalar


@dataclass(frozen=True)
class Tree:
    """Bodies, parents first, and gravity, in scalars."""

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

    @property
    def constraints(self) -> int:
        """Number of loop equations."""
        return sum(loop.closure.size(self.space) for loop in self.loops)

    @property
    def follows(self) -> bool:
        """Whether some coordinate moves more than one joint."""
        used = [k for body in self.bodies for k in body.coordinates.v]
        return len(used) != len(set(used))

    def children(self, i: int) -> tuple[int, ...]:
        """Indices of the bodies that hang on body i."""
        return tuple(k for k, body in enumerate(self.bodies) if body.parent == i)


def lower(model: Model, reader: Reader) -> Tree:
    """The model's tree, its numbers and parameters read by `reader`."""
    space = of_dimension(model.dim)
    bodies: list[TreeBody] = []
    body_of: dict[int, int] = {-1: -1}
    for i in _parents_first(model):
        body = model.bodies[i]
        at = model.coordinates[i]
        R, p = body.joint.placement.lower(space, reader)
        parent = body_of[body.parent]
        iq = iv = 0
        chain = body.kind.primitives(space, reader.axis(body.joint.axis))
        for k, (primitive, axis) in enumerate(chain):
            last = k == len(chain) - 1
            bodies.append(
                TreeBody(
                    body.name,
                    parent,
                    primitive,
                    axis,
                    primitive.columns(space, axis),
                    R,
                    p,
                    Coordinates(
                        at.q[iq : iq + primitive.nq], at.v[iv : iv + primitive.nv], at.ratio, at.offset
                    ),
                    _masses(space, body.inertias, reader) if last else (),
                    _drive(body, reader) if len(chain) == 1 else None,
                )
            )
            iq, iv = iq + primitive.nq, iv + primitive.nv
            parent = len(bodies) - 1
            R, p = identity(space.dim), space.zero
        body_of[i] = parent
    size = reader.quantity(model.gravity_size)
    return Tree(
        space,
        tuple(bodies),
        scale(size, tuple(reader.quantity(x) for x in model.gravity_direction)),
        model.nq,
        model.nv,
        tuple(body_of[i] for i in range(len(model.bodies))),
        {f.name: (body_of[f.body], *f.placement.lower(space, reader)) for f in model.frames},
        _masses(space, model.base_inertias, reader),
        tuple(
            TreeLoop(
                loop.name,
                LOOP_KINDS[loop.kind].closure(space, reader.axis(loop.axis)),
                loop.frames,
                0.0 if loop.distance is None else reader.quantity(loop.distance),
            )
            for loop in model.loops
        ),
    )


def _parents_first(model: Model) -> list[int]:
    """Indices of the model's bodies, each after its parent, otherwise in the file's order."""
    carried: dict[int, list[int]] = {}
    for i, body in enumerate(model.bodies):
        carried.setdefault(body.parent, []).append(i)
    order: list[int] = []
    level = carried.get(-1, [])
    while level:
        order += level
        level = sorted(child for i in level for child in carried.get(i, ()))
    return order


def _masses(space: AnySpace, parts: tuple[Attached, ...], reader: Reader) -> tuple[Mass, ...]:
    """Masses in the body's axes; those with numbers alone are made one."""
    varied = [any(each_parameter(a)) or bool(arrays_in(a)) for a in parts]
    plain = [
        a for a, x in zip(parts, varied, strict=True) if not x and any((a.inertia.mass, *a.inertia.tensor))
    ]
    named = [a for a, x in zip(parts, varied, strict=True) if x]
    # negative masses may add up to a first moment without mass, which has no centre
    positive = all(a.inertia.numbers()[0] >= 0.0 for a in plain)
    if reader.combines and len(plain) > 1 and positive:
        moved = [a.inertia.placed(*a.placement.lower(space, reader)) for a in plain]
        plain = [Attached("", combined(moved))]
    masses = [_mass(space, a, reader) for a in (*named, *plain)]
    return tuple(mass for mass in masses if not _is_nothing(mass))


def _mass(space: AnySpace, part: Attached, reader: Reader) -> Mass:
    m, c, inertia = part.inertia.lower(reader)
    R, p = part.placement.lower(space, reader)
    return Mass(m, add(p, times(R, c)), space.turned_inertia(R, inertia))


def _is_nothing(mass: Mass) -> bool:
    rows = mass.inertia if isinstance(mass.inertia, tuple) else ((mass.inertia,),)
    return all(isinstance(x, float) and x == 0.0 for row in ((mass.m,), *rows) for x in row)


def _drive(body: Body, reader: Reader) -> DriveScalars | None:
    drive = body.joint.drive
    viscous, coulomb, rotor, gear, stiffness, rest = (
        reader.quantity(x)
        for x in (drive.viscous, drive.coulomb, drive.rotor, drive.gear, drive.stiffness, drive.rest)
    )
    if all(isinstance(x, float) and x == 0.0 for x in (viscous, coulomb, rotor, stiffness)):
        return None
    return DriveScalars(viscous, coulomb, rotor * gear * gear, stiffness, rest)
