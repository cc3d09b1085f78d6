"""The contribution of each piece of a model to its structure and its numbers, found once and kept
with the piece."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.lazy import kept
from freebody.model.drives.acting import USUAL, ActingLaw, counted, every_law
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, Pose, placed_composite
from freebody.spatial import AnySpace, Matrix, Vector, of_dimension

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.description import Drive, Joint
    from freebody.model.model import Model

# by how much rounding may part the two cosines, and sines, of a turn about a coordinate axis
_SAME = 1e-15

PatternEntry = float | tuple[int, float]
"""An exact entry, or which number stands there and its sign."""


@dataclass(frozen=True)
class PosePattern:
    """The structure of a pose, with places for its numbers."""

    R: tuple[tuple[PatternEntry, ...], ...]
    p: tuple[PatternEntry, ...]

    def filled(self, scalars: Sequence[Scalar]) -> Pose:
        """The pose (R, p) with the pattern's numbers filled in."""

        def entry(x: PatternEntry) -> Scalar:
            if not isinstance(x, tuple):
                return x
            return scalars[x[0]] if x[1] > 0.0 else -scalars[x[0]]

        return tuple(tuple(map(entry, row)) for row in self.R), tuple(map(entry, self.p))


class SharedForm:
    """The structure of a piece; equal structures are one object, so that keys made of them compare
    quickly."""

    __slots__ = ("__weakref__", "content")

    def __init__(self, content: Any):
        self.content = content


_forms: WeakValueDictionary[Any, SharedForm] = WeakValueDictionary()


def _form(content: Any) -> SharedForm:
    return _forms.get(content) or _forms.setdefault(content, SharedForm(content))


class PoseContribution(NamedTuple):
    """The contribution of a constant pose: its structure, its numbers (..., k), and the pose
    itself."""

    form: SharedForm
    numbers: Array
    pose: Pose


class JointContribution(NamedTuple):
    """The contribution of a joint: its structure, the numbers of its placement and kind, and for a
    joint of one coordinate its drive with the names of the acting laws."""

    form: SharedForm
    placed: Array
    drive: Drive | None
    laws: tuple[str, ...]


class BodyContribution(NamedTuple):
    """The contribution of a body: its joint, and its mass, first moment and inertia."""

    joint: JointContribution
    inertia: Array


def body_parts(model: Model) -> list[BodyContribution]:
    """The contributions of all bodies, in the model's order."""
    return [part_of(body, model.dim) for body in model.bodies]


def part_of(body: Body, dim: int) -> BodyContribution:
    """The contribution of one body, fast enough for a new payload and a call to take
    microseconds."""
    name = _NAME[dim]
    return body.__dict__.get(name) or kept(body, name, _body_part, body, dim)


_NAME = {2: "_part_in_plane", 3: "_part_in_space"}


def _body_part(body: Body, dim: int) -> BodyContribution:
    return BodyContribution(joint_part(body, dim), inertial(body.inertias, dim))


def joint_part(body: Body, dim: int) -> JointContribution:
    """The contribution of the joint that carries a body."""
    return kept(body.joint, _NAME[dim], _joint_part, body.joint, body.kind.nv == 1, dim)


def _joint_part(joint: Joint, one_axis: bool, dim: int) -> JointContribution:
    placed = pose_part(joint.placement, dim)
    drive, laws = (joint.drive, counted_laws(joint.drive)) if one_axis else (None, ())
    own = [as_row([VALUES.quantity(x)]) for x in joint.numbers]
    where = joined([placed.numbers, *own]) if own else placed.numbers
    return JointContribution(_joint_form(joint.kind, joint.axis, placed.form), where, drive, laws)


@lru_cache(maxsize=1024)
def _joint_form(kind: str, axis: tuple[float, ...], placed: SharedForm) -> SharedForm:
    return _form((kind, axis, placed))


def counted_laws(drive: Drive) -> tuple[str, ...]:
    """Names of the laws of a drive that take part: those that act, and the usual ones with them."""
    return kept(drive, "_counted", _counted_laws, drive)


def _counted_laws(drive: Drive) -> tuple[str, ...]:
    return tuple([x.law.name for x in counted(_scalars(drive))])


def _scalars(drive: Drive) -> tuple[ActingLaw, ...]:
    return kept(drive, "_scalars", _found_scalars, drive)


def _found_scalars(drive: Drive) -> tuple[ActingLaw, ...]:
    return every_law(lambda name: VALUES.quantity(getattr(drive, name)), drive.listed_laws)


def drive_row(drive: Drive, names: tuple[str, ...]) -> Array:
    """The scalars of some laws of a drive, one after the other."""
    rows = kept(drive, "_rows", dict)
    row = rows.get(names)
    return rows.setdefault(names, _drive_row(drive, names)) if row is None else row


def _drive_row(drive: Drive, names: tuple[str, ...]) -> Array:
    return as_row([scalar for x in _scalars(drive) if x.law.name in names for scalar in x.p])


def laws_along(part: JointContribution, driven: bool) -> tuple[str, ...]:
    """Names of the drive laws whose scalars are among a joint's numbers: its acting laws, or the
    usual ones where some other joint of the model is driven."""
    return part.laws or (USUAL if driven and part.drive is not None else ())


def pose_part(placement: Placement, dim: int) -> PoseContribution:
    """The contribution of a constant pose."""
    return kept(placement, _NAME[dim], _pose_part, placement, dim)


def _pose_part(placement: Placement, dim: int) -> PoseContribution:
    R, p = placement.lower(of_dimension(dim), VALUES)
    try:
        form, turning = _known_pose_form(R, tuple([x == 0.0 for x in p]))
        shift = [x for x in p if x != 0.0]
    except TypeError:  # a member each
        zeros = tuple([is_exactly(x, 0.0) for x in p])
        form, turning = _pose_form(R, zeros)
        shift = [x for x, zero in zip(p, zeros, strict=True) if not zero]
    return PoseContribution(form, as_row((*turning, *shift)), (R, p))


def _pose_form(R: Matrix, zeros: tuple[bool, ...]) -> tuple[SharedForm, tuple[Scalar, ...]]:
    """The form of a pose, given which entries of its position are zero, and the numbers of its
    rotation."""
    rows, turning = _rotation(R)
    place = count(len(turning))
    shift = tuple([0.0 if zero else (next(place), 1.0) for zero in zeros])
    return _form(PosePattern(rows, shift)), turning


_known_pose_form = lru_cache(maxsize=256)(_pose_form)
"""`_pose_form` where entries are numbers: a length changes often, and rotations with it seldom."""


def _rotation(R: Matrix) -> tuple[tuple[tuple[PatternEntry, ...], ...], tuple[Scalar, ...]]:
    """A rotation as a pattern without its numbers, and the numbers."""
    found = _coordinate_turn(R)
    if found is not None:
        return found
    numbers: list[Scalar] = []

    def entry(x: Scalar) -> PatternEntry:
        if is_exactly(x, 0.0, 1.0, -1.0):
            return float(x) + 0.0
        numbers.append(x)
        return len(numbers) - 1, 1.0

    return tuple(tuple(map(entry, row)) for row in R), tuple(numbers)


def _coordinate_turn(
    R: Matrix,
) -> tuple[tuple[tuple[PatternEntry, ...], ...], tuple[Scalar, ...]] | None:
    """A rotation that maps one coordinate axis to a coordinate axis as a pattern with a cosine and
    a sine, its two numbers; None for other rotations."""
    n = len(R)
    kept_axis = _kept_axis(R)
    if kept_axis is None:
        return None
    i, j = kept_axis
    (a, b), (c, d) = ([R[r][k] for k in range(n) if k != j] for r in range(n) if r != i)
    # the determinant of what is left
    turn = 1.0 if n == 2 else float((-1) ** (i + j)) * R[i][j]
    if not (np.all(np.abs(b + turn * c) <= _SAME) and np.all(np.abs(d - turn * a) <= _SAME)):
        return None
    left: Iterator[PatternEntry] = iter(((0, 1.0), (1, -turn), (1, 1.0), (0, turn)))
    rows = tuple(
        tuple(
            R[r][k] if (r, k) == (i, j) else 0.0 if r == i or k == j else next(left)
            for k in range(n)
        )
        for r in range(n)
    )
    return rows, (a, c)


def _kept_axis(R: Matrix) -> tuple[int, int] | None:
    """The row and column of the coordinate axis that a rotation maps to a coordinate axis, in the
    plane (2, 2), the normal; None for other rotations."""
    n = len(R)
    exact = [(i, j) for i in range(n) for j in range(n) if is_exactly(R[i][j], 1.0, -1.0)]
    if len(exact) != n - 2:
        return None
    i, j = exact[0] if exact else (n, n)
    others = [R[r][k] for r in range(n) for k in range(n) if (r == i) != (k == j)]
    return (i, j) if all(is_exactly(x, 0.0) for x in others) else None


def inertial(parts: tuple[Attached, ...], dim: int) -> Array:
    """Mass, first moment and inertia about the body's origin (..., 10), in the plane (..., 4), of
    all parts of a body together."""
    if not parts:
        return _NOTHING[dim]
    total = linear_row(parts[0], dim)
    for part in parts[1:]:
        total = total + linear_row(part, dim)
    return total


def linear_row(part: Attached, dim: int) -> Array:
    """Mass, first moment and inertia of one part about the body's origin, as in `inertial`."""
    return kept(part, _NAME[dim], _linear_row, of_dimension(dim), part)


def _linear_row(space: AnySpace, part: Attached) -> Array:
    pose = pose_part(part.placement, space.dim).pose
    return as_row(inertial_entries(space, part.inertia.lower(VALUES), pose))


def inertial_entries(
    space: AnySpace, inertia: tuple[Scalar, Vector, Scalar], pose: Pose
) -> tuple[Scalar, ...]:
    """Mass, first moment and inertia about the body's origin, as scalars, given (mass, centre,
    inertia about it) and the pose."""
    m, h, about = placed_composite(space, inertia, pose)
    if space.dim == 2:
        return m, *h, about
    (_, yy, yz), zz = about[1], about[2][2]
    return m, *h, *about[0], yy, yz, zz


_NOTHING = {2: np.zeros(4), 3: np.zeros(10)}


def gravity_part(model: Model) -> tuple[tuple[bool, ...], Array]:
    """The contribution of gravity: for each entry of the field whether it is zero, and the entries
    that are not."""
    return kept(model, "_gravity_part", _field, model)


def _field(model: Model) -> tuple[tuple[bool, ...], Array]:
    size = VALUES.quantity(model.gravity_size)
    direction = [VALUES.quantity(x) for x in model.gravity_direction]
    zeros = tuple([is_exactly(x, 0.0) for x in direction])
    return zeros, as_row([size * x for x, zero in zip(direction, zeros, strict=True) if not zero])


def rows_of(part: BodyContribution, laws: tuple[str, ...]) -> list[Array]:
    """The numbers of a body as rows: its joint's, its inertia's, and its drive's for the given
    laws."""
    joint, inertia = part
    if joint.drive is None or not laws:
        return [joint.placed, inertia]
    return [joint.placed, inertia, drive_row(joint.drive, laws)]


def joined(parts: Sequence[Array]) -> Array:
    """Rows of numbers joined to one array (..., k); those of one robot are broadcast against a
    family's."""
    if max([part.ndim for part in parts]) == 1:
        return np.concatenate(parts)
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate(
        [np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1
    )


def is_exactly(x: Scalar, *exact: float) -> bool:
    """Whether a scalar equals one of some exact numbers, and is no array of a family."""
    return (type(x) is float or isinstance(x, (float, int))) and x in exact


def as_row(values: Sequence[Scalar]) -> Array:
    """Scalars, or arrays of a family, as one array (..., k)."""
    try:
        row = np.array(values, dtype=float)
    except ValueError:  # arrays beside numbers
        row = None
    if row is None or row.ndim != 1:
        row = np.stack(np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in values)), axis=-1)
    row.setflags(write=False)
    return row
