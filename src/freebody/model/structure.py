"""The structure of a model: what remains when its numbers are taken out. Code is compiled for a
structure.

Structure: the tree, the kinds, axes, mimic ratios and laws of drives of joints, the kinds of loops,
the frames of struts, and of placements and of gravity's direction the entries that are exactly 0 or
±1 (of positions and gravity: exactly 0). Names are not part of it.

Numbers, in the order of `numbers`: of each body, parents first, the entries of its joint's
placement that are not exact (of a rotation about a coordinate axis its cosine and sine), what its
kind has besides, such as a pitch, its mass, first moment and inertia about its origin, and, if any
joint of the model has a drive, the scalars of the laws that count; then gravity, the loops'
distances, the
numbers of struts and the mass of the base, and the poses of the struts' frames, of closed chains of
all frames. They are numbers whether
zero or not. What each piece of a model contributes is found once and kept with the piece, so that a
changed copy of a model costs what was changed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.model.contributions import (
    JointContribution,
    SharedForm,
    as_row,
    body_parts,
    gravity_part,
    inertial,
    is_exactly,
    joined,
    laws_along,
    pose_part,
    rows_of,
)
from freebody.model.drives.acting import ActingLaw, of_names, size_of
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import (
    Attached,
    Mass,
    Pieces,
    Pose,
    Tree,
    parents_first,
    tree_of,
)
from freebody.spatial import Vector, of_dimension

if TYPE_CHECKING:
    from freebody.model.bodies import Body, Frame
    from freebody.model.description import Joint
    from freebody.model.model import Model
    from freebody.model.parameters import Quantity

_RECENT = 16
"""Structures that are kept, with what is compiled for them, though no model of theirs is left."""


class BodyRows(NamedTuple):
    """The places of a body's numbers: its joint's position, the numbers of the joint's kind, mass
    with first moment and inertia, and the drive, which may be empty."""

    position: slice
    joint: slice
    inertia: slice
    drive: slice
    laws: tuple[str, ...]
    """Names of the drive's laws."""
    turns: bool
    """Whether its joint does nothing but turn."""


class Structure:
    """The common part of models that differ only in numbers and names; equal structures are one
    object."""

    def __init__(self, key: tuple[Any, ...], model: Model):
        self.key = key
        self.laws: tuple[tuple[str, ...], ...] = key[-1]
        """For each body of the model the names of the laws whose scalars are among the numbers."""
        self.followers: bool = bool(key[3])
        """Whether a joint follows another."""
        self.order = tuple(parents_first(model.bodies))
        self.quaternions = tuple(
            at.q[body.kind.quaternion]
            for body, at in zip(model.bodies, model.coordinates, strict=True)
            if body.kind.quaternion is not None
        )
        """Indices in q at which quaternions begin."""
        self.kernels: dict[Any, Any] = {}
        """Code compiled for the structure; filled and read by `kernels`."""
        self.rows, self.gravity = self._rows(model)
        """Places of the numbers of each body, in that order, and the index at which those of
        gravity begin."""
        self.geometric = np.flatnonzero(
            [placed for row, placed in _pieces(model, self) for _ in range(row.shape[-1])]
        )
        """Indices of the numbers that say where something is, or how far: the others are inertias,
        drives and gravity."""

    def _rows(self, model: Model) -> tuple[tuple[BodyRows, ...], int]:
        known, found, end = body_parts(model), [], 0
        for i in self.order:
            part, kind = known[i], model.bodies[i].kind
            sizes = [row.shape[-1] for row in rows_of(part, self.laws[i])]
            _, *ends = accumulate(sizes, initial=end)
            shift = sum([x != 0.0 for x in part.joint.form.content[2].content.p])
            start = ends[0] - len(kind.numbers)
            found.append(
                BodyRows(
                    slice(start - shift, start),
                    slice(start, ends[0]),
                    slice(ends[0], ends[1]),
                    slice(ends[1], ends[-1]),
                    self.laws[i],
                    all(kind.angular),
                )
            )
            end = ends[-1]
        return tuple(found), end


def structure_of(model: Model) -> Structure:
    """The structure of a model with all values."""
    own = model.__dict__
    edits, numbers = own.get("_edits"), None
    if edits is not None:
        numbers = own["_layout"].numbers_with(edits, own["_slot_values"])
    if numbers is None:
        found = _structure(model)
    else:
        found = own["_layout"].structure
        own.setdefault("numbers", numbers)
    if not _recent or _recent[-1] is not found:
        _recent.append(found)
    return found


def _structure(model: Model) -> Structure:
    joints = [part.joint for part in body_parts(model)]
    key = (
        model.dim,
        tuple([joint.form for joint in joints]),
        tuple([body.parent for body in model.bodies]),
        _followers(model),
        gravity_part(model)[0],
        _loops(model) if model.loops else (),
        _struts(model) if model.struts else (),
        _laws(joints),
    )
    found = _structures.get(key)
    if found is None:
        found = _structures.setdefault(key, Structure(key, model))
    return found


_structures: WeakValueDictionary[tuple[Any, ...], Structure] = WeakValueDictionary()
_recent: deque[Structure] = deque(maxlen=_RECENT)


def numbers_of(model: Model) -> Array:
    """The numbers (..., k) of a model with all values, in the order in which `ScalarPieces` takes
    them."""
    structure = model.structure
    found = model.__dict__.get("numbers")  # they may have come with it
    if found is None:
        found = joined([row for row, _ in _pieces(model, structure)])
        found.setflags(write=False)
    return found


def _pieces(model: Model, structure: Structure) -> Iterator[tuple[Array, bool]]:
    """The numbers in order, a row for each piece, and for each row whether it holds positions."""
    known = body_parts(model)
    for i in structure.order:
        yield from zip(rows_of(known[i], structure.laws[i]), (True, False, False), strict=False)
    yield gravity_part(model)[1], False
    for loop in model.loops:
        if loop.distance is not None:
            yield as_row([VALUES.quantity(loop.distance)]), True
    for strut in model.struts:
        yield as_row([VALUES.quantity(x) for x in strut.numbers]), False
    yield inertial(model.base_inertias, model.dim), False
    for name in own_frames(model):
        yield pose_part(model.frame(name).placement, model.dim).numbers, True


def own_frames(model: Model) -> tuple[str, ...]:
    """Names of the frames whose poses belong to the structure: all for a closed chain, those of
    struts for a tree, whose kernels bring along the frames they need."""
    if model.loops:
        return model.frame_names
    return tuple(dict.fromkeys([name for strut in model.struts for name in strut.frames]))


class ScalarPieces(Pieces):
    """The pieces of a model with scalars in place of its numbers, in the order of `numbers_of`,
    followed by those of the poses of `frames`."""

    def __init__(
        self,
        model: Model,
        scalars: Sequence[Scalar],
        frames: Sequence[str],
        shown: Sequence[Sequence[str]] | None,
    ):
        super().__init__(of_dimension(model.dim), VALUES)
        laws = model.structure.laws
        self.known = {
            id(body): pair for body, *pair in zip(model.bodies, laws, shown or laws, strict=True)
        }
        self.scalars, self.chosen = scalars, frames
        self.used = 0

    def pose(self, placement: Placement) -> Pose:
        part = pose_part(placement, self.space.dim)
        return part.form.content.filled(self._next(part.numbers.shape[-1]))

    def own(self, joint: Joint) -> Vector:
        return tuple(self._next(len(joint.numbers)))

    def masses(self, parts: tuple[Attached, ...]) -> tuple[Mass, ...]:
        dim = self.space.dim
        m, *h = self._next(1 + dim)
        if dim == 2:
            (inertia,) = self._next(1)
        else:
            xx, xy, xz, yy, yz, zz = self._next(6)
            inertia = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        return (Mass(m, self.space.zero, inertia, tuple(h)),)

    def laws(self, body: Body) -> tuple[ActingLaw, ...]:
        names, shown = self.known[id(body)]
        found = of_names(names, self._next(size_of(names)))
        return tuple(x for x in found if x.law.name in shown)

    def gravity(self, size: Quantity, direction: tuple[float, ...]) -> Vector:
        zeros = [is_exactly(x, 0.0) for x in direction]
        values = iter(self._next(zeros.count(False)))
        return tuple(0.0 if zero else next(values) for zero in zeros)

    def distance(self, distance: Quantity) -> Scalar:
        return self._next(1)[0]

    def strut(self, numbers: tuple[Quantity, ...]) -> Vector:
        return tuple(self._next(len(numbers)))

    def frames(self, model: Model) -> tuple[Frame, ...]:
        return tuple(model.frame(name) for name in self.chosen)

    def _next(self, count: int) -> Sequence[Scalar]:
        self.used += count
        return self.scalars[self.used - count : self.used]


def tree_over(
    model: Model,
    scalars: Sequence[Scalar],
    frames: Sequence[str] = (),
    shown: Sequence[Sequence[str]] | None = None,
) -> Tree:
    """The tree of a model's structure over scalars in the place of its numbers.

    It holds `frames`, those of struts, and of closed chains all others; the former's numbers stand
    at the end, one after the other. shown: for each body the laws of its drive, where that counts;
    else those of the structure.
    """
    return tree_of(model, ScalarPieces(model, scalars, (*own_frames(model), *frames), shown))


def laws_shown(model: Model) -> tuple[tuple[str, ...], ...]:
    """For each body the names of the drive laws that act along its joint."""
    return tuple([part.joint.laws for part in body_parts(model)])


def _laws(joints: Sequence[JointContribution]) -> tuple[tuple[str, ...], ...]:
    """For each body the names of the drive laws whose scalars are among the structure's numbers."""
    driven = any(joint.laws for joint in joints)
    return tuple([laws_along(joint, driven) for joint in joints])


def _followers(model: Model) -> tuple[Any, ...]:
    """(body, its leader, ratio, offset, further coefficients) of each joint that follows
    another."""
    if not [body for body in model.bodies if body.joint.mimic is not None]:
        return ()
    at = {name: i for i, name in enumerate(model.joint_names)}
    return tuple(
        (i, at[mimic.joint], mimic.ratio, mimic.offset, mimic.powers)
        for i, body in enumerate(model.bodies)
        if (mimic := body.joint.mimic) is not None
    )


def _loops(model: Model) -> tuple[Any, ...]:
    """The loops of a closed chain with all its frames, which the mechanism's length scale depends
    on."""
    at = {name: i for i, name in enumerate(model.frame_names)}
    loops = [(loop.kind, loop.axis, *(at[name] for name in loop.frames)) for loop in model.loops]
    return tuple(loops), tuple(frame_form(model, name) for name in at)


def _struts(model: Model) -> tuple[Any, ...]:
    """The frames of each strut."""
    at = {name: i for i, name in enumerate(own_frames(model))}
    ends = tuple([tuple([at[name] for name in strut.frames]) for strut in model.struts])
    return ends, tuple([frame_form(model, name) for name in at])


def frame_form(model: Model, name: str) -> tuple[int, SharedForm]:
    """The body that a frame is fixed to, and the form of its pose there, which is the same for all
    values of its numbers."""
    frame = model.frame(name)
    return frame.body, pose_part(frame.placement, model.dim).form
