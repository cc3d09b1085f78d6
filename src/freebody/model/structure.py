"""The structure of a model: what remains when its numbers are taken out. Code is compiled for a structure.

Structure: the tree, the kinds, axes and mimic ratios of joints, the kinds of loops, and of placements and of gravity's
direction the entries that are exactly 0 or ±1 (of positions and gravity: exactly 0). Names are not part of it.

Numbers, in the order of `numbers`: of each body, parents first, the entries of its joint's placement that are not
exact (of a rotation about a coordinate axis its cosine and sine), its mass, first moment and inertia about its origin,
and, if any joint of the model has a drive, friction, rotor and spring; then gravity, the loops' distances and the
mass of the base, and of closed chains the frames' poses. They are numbers whether zero or not. What each piece of a
model contributes is found once and kept with the piece, so that a changed copy of a model costs what was changed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.lazy import kept
from freebody.model.placement import Placement
from freebody.model.reading import VALUES
from freebody.model.tree import (
    Attached,
    DriveScalars,
    Mass,
    Pieces,
    Pose,
    Tree,
    about_origin,
    drive_of,
    in_body,
    parents_first,
    tree_of,
)
from freebody.spatial import AnySpace, Vector, of_dimension

if TYPE_CHECKING:
    from freebody.model.bodies import Body, Frame
    from freebody.model.model import Model
    from freebody.model.parameters import Quantity
    from freebody.model.parts import Joint

_RECENT = 16
"""Structures that are kept, with what is compiled for them, though no model of theirs is left."""
_SAME = 1e-15  # by how much rounding may part the two cosines, and sines, of a turn about a coordinate axis

Entry = float | tuple[int, float]
"""An exact entry, or which number stands there and its sign."""


@dataclass(frozen=True)
class Pattern:
    """A pose without its numbers."""

    R: tuple[tuple[Entry, ...], ...]
    p: tuple[Entry, ...]

    def filled(self, scalars: Sequence[Scalar]) -> Pose:
        """(R, p) with its numbers put in."""

        def entry(x: Entry) -> Scalar:
            if not isinstance(x, tuple):
                return x
            return scalars[x[0]] if x[1] > 0.0 else -scalars[x[0]]

        return tuple(tuple(map(entry, row)) for row in self.R), tuple(map(entry, self.p))


class Form:
    """The structure of a piece; equal ones are one object, so that keys made of them are quick."""

    __slots__ = ("__weakref__", "content")

    def __init__(self, content: Any):
        self.content = content


_forms: WeakValueDictionary[Any, Form] = WeakValueDictionary()


def _form(content: Any) -> Form:
    return _forms.get(content) or _forms.setdefault(content, Form(content))


@dataclass(frozen=True)
class Part:
    """What a constant pose contributes, its structure and its numbers (..., k), and the pose itself."""

    form: Form
    numbers: Array
    pose: Pose


class JointPart(NamedTuple):
    """What a joint contributes: structure, numbers of its placement, and of a one-axis joint those of its drive."""

    form: Form
    placed: Array
    drive: Array | None
    driven: bool
    """Whether friction, a rotor or a spring acts."""


class BodyPart(NamedTuple):
    """What a body contributes: its joint, and its mass, first moment and inertia."""

    joint: JointPart
    inertia: Array


class Structure:
    """What models have in common that differ in numbers and names alone; equal structures are one object."""

    def __init__(self, key: tuple[Any, ...], model: Model):
        self.key = key
        self.driven: bool = key[-1]
        """Whether the numbers of drives are among the numbers."""
        self.order = tuple(parents_first(model))
        self.quaternions = tuple(
            at.q[body.kind.quaternion]
            for body, at in zip(model.bodies, model.coordinates, strict=True)
            if body.kind.quaternion is not None
        )
        """Where in q a quaternion begins, for each there is."""
        self.kernels: dict[Any, Any] = {}
        """What has been compiled for it; filled and read by `kernels`."""
        known = body_parts(model)
        sizes = [sum(row.shape[-1] for row in _rows(known[i], self.driven)) for i in self.order]
        self.starts = dict(zip(self.order, accumulate(sizes, initial=0), strict=False))
        """Where the numbers of each body begin."""


def made_from(new: Model, old: Model) -> Model:
    """`new`, a changed copy, which takes over what is known of the pieces that stay."""
    new.__dict__[_SOURCE] = old.__dict__.get(_SOURCE, old)
    return new


_SOURCE = "made from"
"""Under this name a model without `numbers` keeps one that it shares pieces with: what it was made from, or where
numbers were found of neither that nor anything else, the first copy of it of which they were. Never a row of models:
who has numbers keeps none."""


def _source(model: Model) -> Model | None:
    """Another model that shares pieces, whose structure and numbers are known."""
    source = model.__dict__.get(_SOURCE)
    if source is not None and "numbers" not in source.__dict__:
        source = source.__dict__.get(_SOURCE)
    return None if source is None or "numbers" not in source.__dict__ else source


def _other_bodies(model: Model, source: Model) -> list[int] | None:
    """Which bodies are others; None where more is, and structure and numbers have to be put together anew."""
    if (
        model.gravity_size is not source.gravity_size
        or model.gravity_direction is not source.gravity_direction
        or model.base_inertias is not source.base_inertias
        or model.loops is not source.loops
        or (model.loops and model.frames is not source.frames)
        or model.dim != source.dim
        or len(model.bodies) != len(source.bodies)
    ):
        return None
    return [i for i, (a, b) in enumerate(zip(model.bodies, source.bodies, strict=True)) if a is not b]


def _inherited(model: Model) -> Structure | None:
    """The structure of the model that this one is made from, if it is surely the same."""
    source = _source(model)
    others = None if source is None else _other_bodies(model, source)
    if source is None or others is None:
        return None
    for i in others:
        new, old = model.bodies[i], source.bodies[i]
        a, b = _part(new, model.dim).joint, _part(old, model.dim).joint
        if a is not b and (a.form is not b.form or a.driven != b.driven):
            return None
        if (
            new.parent != old.parent
            or new.joint.mimic is not old.joint.mimic
            or new.joint.name != old.joint.name
        ):
            return None
    return source.structure


def structure_of(model: Model) -> Structure:
    """The structure of a model with all values."""
    found = _inherited(model) or _structure(model)
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
        _gravity(model)[0],
        _loops(model) if model.loops else (),
        True in [joint.driven for joint in joints],
    )
    found = _structures.get(key)
    if found is None:
        found = _structures.setdefault(key, Structure(key, model))
    return found


_structures: WeakValueDictionary[tuple[Any, ...], Structure] = WeakValueDictionary()
_recent: deque[Structure] = deque(maxlen=_RECENT)


def numbers_of(model: Model) -> Array:
    """The numbers (..., k) of a model with all values, in the order in which `Inputs` asks for them."""
    source = _source(model)
    numbers = None if source is None else _patched(model, source)
    if numbers is None:
        numbers = _numbers(model)
    origin = model.__dict__.pop(_SOURCE, None)
    if source is None and origin is not None and numbers.ndim == 1:
        origin.__dict__.setdefault(_SOURCE, model)
    return numbers


def _numbers(model: Model) -> Array:
    structure, dim = model.structure, model.dim
    known = body_parts(model)
    parts = [row for i in structure.order for row in _rows(known[i], structure.driven)]
    parts.append(_gravity(model)[1])
    for loop in model.loops:
        if loop.distance is not None:
            parts.append(_row([VALUES.quantity(loop.distance)]))
    parts.append(inertial(model.base_inertias, dim))
    for name in _own_frames(model):
        parts.append(pose_part(model.frame(name).placement, dim).numbers)
    return joined(parts)


def _patched(model: Model, source: Model) -> Array | None:
    """The numbers of the model that this one is made from, those of the bodies that are others put in."""
    others, numbers = _other_bodies(model, source), source.numbers
    if others is None or model.structure is not source.structure or numbers.ndim > 1:
        return None
    numbers = numbers.copy()
    for i in others:
        start = model.structure.starts[i]
        for row in _rows(_part(model.bodies[i], model.dim), model.structure.driven):
            if row.ndim > 1:
                return None
            end = start + len(row)
            numbers[start:end] = row
            start = end
    return numbers


def _rows(part: BodyPart, driven: bool) -> list[Array]:
    """What a body adds to the numbers, in order."""
    joint, inertia = part
    return (
        [joint.placed, inertia, joint.drive]
        if driven and joint.drive is not None
        else [joint.placed, inertia]
    )


def joined(parts: Sequence[Array]) -> Array:
    """Numbers one after the other, (..., k); those of a family broadcast against those of one robot."""
    if max([part.ndim for part in parts]) == 1:
        return np.concatenate(parts)
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)


def _own_frames(model: Model) -> tuple[str, ...]:
    """The frames that belong to the structure: of a tree none, since a call brings along those that it asks for."""
    return model.frame_names if model.loops else ()


class Inputs(Pieces):
    """The pieces of a model with scalars in the place of its numbers, as they come in `numbers_of` and then those of
    the poses of `frames`."""

    def __init__(
        self,
        model: Model,
        scalars: Sequence[Scalar],
        frames: Sequence[str],
        shown: Sequence[bool] | None,
    ):
        super().__init__(of_dimension(model.dim), VALUES)
        self.idle = {id(b) for b, s in zip(model.bodies, shown, strict=True) if not s} if shown else set()
        self.scalars, self.chosen = scalars, frames
        self.driven = model.structure.driven
        self.used = 0

    def pose(self, placement: Placement) -> Pose:
        part = pose_part(placement, self.space.dim)
        return part.form.content.filled(self._next(part.numbers.shape[-1]))

    def masses(self, parts: tuple[Attached, ...]) -> tuple[Mass, ...]:
        dim = self.space.dim
        m, *h = self._next(1 + dim)
        if dim == 2:
            (inertia,) = self._next(1)
        else:
            xx, xy, xz, yy, yz, zz = self._next(6)
            inertia = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        return (Mass(m, self.space.zero, inertia, tuple(h)),)

    def drive(self, body: Body) -> DriveScalars | None:
        if not self.driven or body.kind.nv != 1:
            return None
        scalars = self._next(5)
        return None if id(body) in self.idle else DriveScalars(*scalars)

    def gravity(self, size: Quantity, direction: tuple[float, ...]) -> Vector:
        zeros = [_is(x, 0.0) for x in direction]
        values = iter(self._next(zeros.count(False)))
        return tuple(0.0 if zero else next(values) for zero in zeros)

    def distance(self, distance: Quantity) -> Scalar:
        return self._next(1)[0]

    def frames(self, model: Model) -> tuple[Frame, ...]:
        return tuple(model.frame(name) for name in self.chosen)

    def _next(self, count: int) -> Sequence[Scalar]:
        self.used += count
        return self.scalars[self.used - count : self.used]


def tree_over(
    model: Model,
    scalars: Sequence[Scalar],
    frames: Sequence[str] = (),
    shown: Sequence[bool] | None = None,
) -> Tree:
    """The tree of a model's structure over scalars in the place of its numbers.

    It holds `frames`, and of closed chains all others; the former's numbers stand at the end, one after the other.
    shown: the bodies whose joints have a drive, where that counts; else all have one, or none.
    """
    return tree_of(model, Inputs(model, scalars, (*_own_frames(model), *frames), shown))


def drives(model: Model) -> tuple[bool, ...]:
    """For each body whether friction, a rotor or a spring acts along its joint."""
    return tuple([part.joint.driven for part in body_parts(model)])


# ---------------------------------------------------------------- what each piece contributes
def body_parts(model: Model) -> list[BodyPart]:
    """Of each body in the model's order."""
    return [_part(body, model.dim) for body in model.bodies]


def _part(body: Body, dim: int) -> BodyPart:
    """Of one body; a new payload and one call are to take microseconds."""
    name = _NAME[dim]
    return body.__dict__.get(name) or kept(body, name, partial(_body_part, body, dim))


_NAME = {2: "part in the plane", 3: "part in space"}


def _body_part(body: Body, dim: int) -> BodyPart:
    joint = kept(body.joint, _NAME[dim], partial(_joint_part, body.joint, body.kind.nv == 1, dim))
    return BodyPart(joint, inertial(body.inertias, dim))


def _joint_part(joint: Joint, one_axis: bool, dim: int) -> JointPart:
    placed = pose_part(joint.placement, dim)
    drive = _row(drive_of(joint.drive, VALUES)) if one_axis else None
    driven = drive is not None and bool(drive[..., :4].any())
    return JointPart(_form((joint.kind, joint.axis, placed.form)), placed.numbers, drive, driven)


def pose_part(placement: Placement, dim: int) -> Part:
    """Of a constant pose."""
    return kept(placement, _NAME[dim], partial(_pose_part, placement, dim))


def _pose_part(placement: Placement, dim: int) -> Part:
    R, p = placement.lower(of_dimension(dim), VALUES)
    numbers: list[Scalar] = []

    def entry(x: Scalar, *exact: float) -> Entry:
        if _is(x, *exact):
            return float(x) + 0.0
        numbers.append(x)
        return len(numbers) - 1, 1.0

    rows = _coordinate_turn(R, numbers) or tuple(tuple(entry(x, 0.0, 1.0, -1.0) for x in row) for row in R)
    shift = tuple(entry(x, 0.0) for x in p)
    return Part(_form(Pattern(rows, shift)), _row(numbers), (R, p))


def _coordinate_turn(R: Any, numbers: list[Scalar]) -> tuple[tuple[Entry, ...], ...] | None:
    """A rotation that maps one coordinate axis to one, otherwise by a cosine and a sine, which are its two numbers."""
    n = len(R)
    exact = [(i, j) for i in range(n) for j in range(n) if _is(R[i][j], 1.0, -1.0)]
    if len(exact) != n - 2:
        return None
    i, j = exact[0] if exact else (n, n)
    if any(not _is(R[r][k], 0.0) for r in range(n) for k in range(n) if (r == i) != (k == j)):
        return None
    (a, b), (c, d) = ([R[r][k] for k in range(n) if k != j] for r in range(n) if r != i)
    turn = 1.0 if not exact else float((-1) ** (i + j)) * R[i][j]  # the determinant of what is left
    if not (np.all(np.abs(b + turn * c) <= _SAME) and np.all(np.abs(d - turn * a) <= _SAME)):
        return None
    numbers += a, c
    left: Iterator[Entry] = iter(((0, 1.0), (1, -turn), (1, 1.0), (0, turn)))
    return tuple(
        tuple(R[r][k] if (r, k) == (i, j) else 0.0 if r == i or k == j else next(left) for k in range(n))
        for r in range(n)
    )


def inertial(parts: tuple[Attached, ...], dim: int) -> Array:
    """Mass, first moment and inertia about the body's origin (..., 10), or (..., 4) in the plane, of all its parts."""
    if not parts:
        return _NOTHING[dim]
    total = _linear(parts[0], dim)
    for part in parts[1:]:
        total = total + _linear(part, dim)
    return total


def _linear(part: Attached, dim: int) -> Array:
    return kept(part, _NAME[dim], lambda: _row(_linear_entries(of_dimension(dim), part)))


def _linear_entries(space: AnySpace, part: Attached) -> list[Scalar]:
    mass = in_body(space, part.inertia.lower(VALUES), pose_part(part.placement, space.dim).pose)
    m, h, inertia = about_origin(space, (mass,))
    if space.dim == 2:
        return [m, *h, inertia]
    return [m, *h, *inertia[0], inertia[1][1], inertia[1][2], inertia[2][2]]


_NOTHING = {2: np.zeros(4), 3: np.zeros(10)}


def _gravity(model: Model) -> tuple[tuple[bool, ...], Array]:
    """Which entries of the field are zero, and the others."""
    return kept(model, "gravity part", partial(_field, model))


def _field(model: Model) -> tuple[tuple[bool, ...], Array]:
    size = VALUES.quantity(model.gravity_size)
    direction = [VALUES.quantity(x) for x in model.gravity_direction]
    zeros = tuple([_is(x, 0.0) for x in direction])
    return zeros, _row([size * x for x, zero in zip(direction, zeros, strict=True) if not zero])


def _followers(model: Model) -> tuple[Any, ...]:
    """(body, its leader, ratio, offset) of each joint that follows another."""
    if not [body for body in model.bodies if body.joint.mimic is not None]:
        return ()
    at = {name: i for i, name in enumerate(model.joint_names)}
    return tuple(
        (i, at[mimic.joint], mimic.ratio, mimic.offset)
        for i, body in enumerate(model.bodies)
        if (mimic := body.joint.mimic) is not None
    )


def _loops(model: Model) -> tuple[Any, ...]:
    """Of closed chains the loops, and all frames: these say how long the mechanism is."""
    at = {name: i for i, name in enumerate(model.frame_names)}
    loops = [(loop.kind, loop.axis, *(at[name] for name in loop.frames)) for loop in model.loops]
    return tuple(loops), tuple(frame_form(model, name) for name in at)


def frame_form(model: Model, name: str) -> tuple[int, Form]:
    """The body that a frame is fixed to, and its pose there without its numbers."""
    frame = model.frame(name)
    return frame.body, pose_part(frame.placement, model.dim).form


def _is(x: Scalar, *exact: float) -> bool:
    """Whether it is one of these numbers, and no array of a family."""
    return isinstance(x, float | int) and x in exact


def _row(values: Sequence[Scalar]) -> Array:
    """Scalars, or arrays of a family, as one array (..., k)."""
    if {*map(type, values)} <= {float, int}:
        row = np.array(values, dtype=float)
    else:
        row = np.stack(np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in values)), axis=-1)
    row.flags.writeable = False
    return row
