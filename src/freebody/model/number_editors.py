"""Editors of a model's numbers: where each number is stored, and how it is replaced. One mechanism
for names, values and inputs.

An *editor* knows one piece of the model (a placement, the inertia of a link, a drive): it reads the
numbers that the piece is made of, by field, and writes some of them. What is written may be a
number, one for each member of a family, or a parameter that a kernel reads as an input.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.model.cut import behind, rides
from freebody.model.families import Members, NamedNumber, changed
from freebody.model.inertia import Inertia
from freebody.model.parameters import LARGEST, Parameter, ParameterProduct, Quantity, each_parameter
from freebody.model.piece_paths import Fields, PiecePath, get, is_plain, named_leaves, put, put_at
from freebody.model.placement import AxisRotation, Placement, Rotate, Shift, shift, turn
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached
from freebody.spatial import AnySpace, Matrix, Vector, identity, of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model


TENSOR = {2: ("zz",), 3: ("xx", "xy", "xz", "yy", "yz", "zz")}
_TENSOR = {dim: tuple(f"inertia.{x}" for x in entries) for dim, entries in TENSOR.items()}
_CENTRE = {dim: tuple(f"com.{x}" for x in of_dimension(dim).axes) for dim in TENSOR}


class Editor(Protocol):
    """A reader and writer of the numbers of one piece of a model."""

    @property
    def first(self) -> bool:
        """Whether the editor writes at paths that other editors may move, so that it must write
        first."""
        ...

    @property
    def keeps_places(self) -> bool:
        """Whether every number keeps its path after the editor has written."""
        ...

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        """The numbers, symbols or arrays of members by field: of all fields, or at least of those
        wanted."""
        ...

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        """The paths at which a field's number is stored unchanged, where writing it only replaces
        it there; empty otherwise."""
        ...

    def write(self, model: Model, values: Fields) -> Model:
        """The model with other numbers in some fields."""
        ...


@dataclass(frozen=True)
class Leaves:
    """An editor of a symbol or named DH entry at all places where it is stored."""

    paths: tuple[PiecePath, ...]
    first = True
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        return {"": get(model, self.paths[0])}

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        return self.paths

    def write(self, model: Model, values: Fields) -> Model:
        value = values[""]
        old = get(model, self.paths[0])
        if not isinstance(value, Parameter):
            if isinstance(old, Parameter):
                value = Parameter(old.name, value)
            elif isinstance(value, Members):
                value = Members(value.array, old.name)
            else:
                value = NamedNumber(value, old.name)
        return put_at(model, self.paths, value)


@dataclass(frozen=True)
class PieceEntries:
    """An editor of numbers that are attributes of a piece or entries of a tuple, by field."""

    path: PiecePath
    steps: Mapping[str, str | int]
    first = False
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        piece = get(model, self.path)
        fields = self.steps if wanted is None else wanted
        return {field: get(piece, (self.steps[field],)) for field in fields}

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        return ((*self.path, self.steps[field]),)

    def write(self, model: Model, values: Fields) -> Model:
        piece = get(model, self.path)
        for field, value in values.items():
            piece = put(piece, (self.steps[field],), value)
        return put(model, self.path, piece)


@dataclass(frozen=True)
class LinkInertiaEditor:
    """An editor of the inertia of a link, about its centre of mass and in the link's axes; `scale`
    is a factor on mass and tensor.

    frame: the link's, where the steps of the placement lead by way of it. Without, the numbers stay
    in the frame in which they are given.
    """

    path: PiecePath
    frame: str | None
    space: AnySpace
    first = False
    keeps_places = True

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        part = get(model, self.path)
        if wanted is not None and _FACTORS.issuperset(wanted):
            return {"mass": part.inertia.mass, "scale": 1.0}
        return self._fields(self._told(model, part).inertia) | {"scale": 1.0}

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        part, dim = get(model, self.path), self.space.dim
        if field == "mass":
            return ((*self.path, "inertia", "mass"),)
        if field == "scale" or self._told(model, part) is not part:
            return ()
        name, labels = ("com", _CENTRE[dim]) if field in _CENTRE[dim] else ("tensor", _TENSOR[dim])
        return ((*self.path, "inertia", name, labels.index(field)),)

    def write(self, model: Model, values: Fields) -> Model:
        part = get(model, self.path)
        factor = values.get("scale", 1.0)
        if not _FACTORS.issuperset(values):
            part = self._told(model, part)
        inertia = part.inertia
        other: dict[str, Any] = {"mass": _times(values.get("mass", inertia.mass), factor)}
        if len(values) > 1 or "mass" not in values:
            fields = self._fields(inertia) | dict(values)
            other["com"] = tuple([fields[label] for label in _CENTRE[self.space.dim]])
            other["tensor"] = tuple(
                [_times(fields[label], factor) for label in _TENSOR[self.space.dim]]
            )
        return put(model, self.path, changed(part, {"inertia": changed(inertia, other)}))

    def _fields(self, inertia: Inertia) -> dict[str, Quantity]:
        labels = ("mass", *_CENTRE[self.space.dim], *_TENSOR[self.space.dim])
        return dict(zip(labels, (inertia.mass, *inertia.com, *inertia.tensor), strict=True))

    def _told(self, model: Model, part: Attached) -> Attached:
        """The part with its inertia in the link's frame, where the placement there consists of
        plain numbers; else as it is."""
        steps = part.placement.steps
        start = len(steps) if self.frame is None else steps_to(model, self.frame)
        inner = Placement(steps[start:])
        if not inner.steps or not is_plain((inner.steps, part.inertia)):
            return part
        R, p = inner.lower(self.space, VALUES)
        m, c, tensor = part.inertia.lower(VALUES)
        turned = self.space.inertia_matrix(self.space.turned_inertia(R, tensor))
        com = tuple(
            x + sum(a * b for a, b in zip(row, c, strict=True)) for x, row in zip(p, R, strict=True)
        )
        entries = tuple(turned[i][j] for i in range(len(turned)) for j in range(i, len(turned)))
        inertia = changed(
            part.inertia,
            {
                "mass": as_quantity(m),
                "com": tuple(map(as_quantity, com)),
                "tensor": tuple(map(as_quantity, entries)),
            },
        )
        return changed(part, {"inertia": inertia, "placement": Placement(steps[:start])})


@dataclass(frozen=True)
class NewPayloadEditor:
    """An editor of a payload at the tip that does not exist yet."""

    name: str
    frame: str
    space: AnySpace
    first = False
    keeps_places = False

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        return dict.fromkeys(("mass", *_CENTRE[self.space.dim], *_TENSOR[self.space.dim]), 0.0)

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        return ()

    def write(self, model: Model, values: Fields) -> Model:
        at = model.frame(self.frame)
        added = Attached(self.name, Inertia.nothing(self.space.dim), at.placement, True, self.frame)
        path = ("base_inertias",) if at.body < 0 else ("bodies", at.body, "inertias")
        there = get(model, path)
        grown = put(model, path, (*there, added))
        return LinkInertiaEditor((*path, len(there)), None, self.space).write(grown, values)


_FACTORS = frozenset({"mass", "scale"})
"""Fields that are the same in any axes and about any point."""


def _times(x: Quantity, factor: Quantity) -> Quantity:
    """The product x · factor; for quantities that a kernel reads, one that the kernel computes."""
    if isinstance(factor, float) and factor == 1.0:
        return x
    if any(each_parameter((x, factor))):
        return cast(Quantity, ParameterProduct((x, factor)))
    product = VALUES.quantity(x) * VALUES.quantity(factor)
    if np.max(np.abs(product)) > LARGEST:
        most = np.max(np.abs(VALUES.quantity(factor)))
        raise ModelError(
            f"scale: {most:g} makes a mass or inertia too large; numbers of a robot stay below "
            f"{LARGEST:g}."
        )
    return as_quantity(product)


ANGLES = {2: ("yaw",), 3: ("roll", "pitch", "yaw")}


@dataclass(frozen=True)
class PoseEditor:
    """An editor of a placement: x, y, z (m), then roll, pitch, yaw (rad) about the axes of the
    outer frame, R = Rz(yaw) Ry(pitch) Rx(roll).

    outer: the frame that its first steps lead to, and that it is told in; None: the body's.
    frame: its name, where it is a frame's: all that is fixed to that frame moves with it.
    """

    path: PiecePath
    outer: str | None
    space: AnySpace
    frame: str = ""
    first = False

    @property
    def keeps_places(self) -> bool:
        """Whether every number keeps its path after writing; not for a frame, since parts fixed to
        it start with its steps."""
        return not self.frame

    @staticmethod
    def tells(own: tuple[Any, ...]) -> bool:
        """Whether position and angles can describe these steps of a placement, which may hold
        symbols."""
        leaves = named_leaves(own)
        if any(len(name) > 1 for name in leaves):  # entries of a DH table are the numbers there
            return False
        return not leaves or not any(isinstance(step, Shift) for step in own[1:])

    def start(self, model: Model) -> int:
        """The number of steps in the placement that lead to the outer frame."""
        return 0 if self.outer is None else steps_to(model, self.outer)

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        by, turns = self._split(get(model, self.path).steps[self.start(model) :])
        return self._fields(by, turns)

    def alone(self, model: Model, field: str) -> tuple[PiecePath, ...]:
        start = self.start(model)
        first, *rest = get(model, self.path).steps[start:] or (None,)
        if (
            self.frame  # what is fixed to it moves too
            or field not in self.space.axes
            or not isinstance(first, Shift)
            or any(isinstance(step, Shift) for step in rest)
        ):
            return ()
        return ((*self.path, "steps", start, "by", self.space.axes.index(field)),)

    def write(self, model: Model, values: Fields) -> Model:
        old = get(model, self.path)
        start = self.start(model)
        outer, own = old.steps[:start], old.steps[start:]
        by, turns = self._split(own)
        by = tuple(values.get(x, b) for x, b in zip(self.space.axes, by, strict=True))
        names = ANGLES[self.space.dim]
        if not values.keys().isdisjoint(names):
            angles = self._fields(by, turns) | dict(values)
            turns = tuple(
                step for x in reversed(names) for step in turn(_ABOUT[x], angles[x]).steps
            )
        new = Placement((*outer, *shift(*by).steps, *turns))
        model = put(model, self.path, new)
        for path in _riders(model, self.frame) if self.frame else ():
            ridden = get(model, path).steps
            if ridden[: len(old.steps)] != old.steps:
                raise ModelError(
                    f"{model.name!r}: frame {self.frame!r} carries a long chain of fixed links, "
                    f"whose placements have been combined; it can no longer be moved. Give the "
                    f"number before the model is made."
                )
            model = put(model, path, Placement((*new.steps, *ridden[len(old.steps) :])))
        return model

    def _split(self, own: Iterable[Any]) -> tuple[Vector, tuple[Any, ...]]:
        """A shift and the turns behind it that are equivalent to the given steps."""
        steps = tuple(own)
        first, rest = (
            (steps[0].by, steps[1:])
            if steps and isinstance(steps[0], Shift)
            else (self.space.zero, steps)
        )
        if not any(isinstance(step, Shift) for step in rest):
            return first, rest
        R, p = Placement(steps).lower(self.space, VALUES)
        if all(isinstance(x, float) for row in R for x in row):
            turns: tuple[Any, ...] = (Rotate(R),)
        else:  # a member each: as angles, which have numbers for members
            angles = _angles_of(R)
            turns = tuple(
                AxisRotation(_ABOUT[x], as_quantity(angles[x]))
                for x in reversed(ANGLES[self.space.dim])
            )
        return tuple(map(as_quantity, p)), turns

    def _fields(self, by: Vector, turns: tuple[Any, ...]) -> dict[str, Quantity]:
        fields: dict[str, Quantity] = dict(zip(self.space.axes, by, strict=True))
        order = [_LETTER[step.axis] for step in turns if isinstance(step, AxisRotation)]
        names = ANGLES[self.space.dim]
        if len(order) == len(turns) and order == sorted(
            set(order), reverse=True
        ):  # already such turns
            told = {_ABOUT[x]: x for x in names}
            return (
                fields | dict.fromkeys(names, 0.0) | {told[step.axis]: step.angle for step in turns}
            )
        if not is_plain(turns):
            return fields
        R, _ = Placement(turns).lower(self.space, VALUES)
        return fields | {x: as_quantity(angle) for x, angle in _angles_of(R).items()}


def steps_to(model: Model, frame: str) -> int:
    """The number of steps in the placement of a frame in its body."""
    return len(model.frame(frame).placement.steps)


def _riders(model: Model, name: str) -> list[PiecePath]:
    """Paths of the placements that start with a frame's placement: of frames, inertias, loads and
    joints attached to it."""
    reached = behind(model, name)
    paths: list[PiecePath] = [
        ("frames", k, "placement")
        for k, f in enumerate(model.frames)
        if f.name in reached and f.name != name
    ]
    parts = [("base_inertias", k) for k in range(len(model.base_inertias))]
    for i, body in enumerate(model.bodies):
        parts += [("bodies", i, "inertias", k) for k in range(len(body.inertias))]
        if body.joint.parent in reached:
            paths.append(("bodies", i, "joint", "placement"))
    for path in parts:
        if rides(get(model, path), reached):
            paths.append((*path, "placement"))
    return paths


_ABOUT = {"roll": "x", "pitch": "y", "yaw": "z"}
_LETTER = {"x": 0, "y": 1, "z": 2}


def _angles_of(R: Matrix) -> dict[str, Scalar]:
    """Roll, pitch and yaw of a rotation (in the plane yaw alone); yaw = 0 where they are not
    unique."""
    if identity(len(R)) == R:
        return dict.fromkeys(ANGLES[len(R)], 0.0)
    atan2 = math.atan2 if all(isinstance(x, float) for row in R for x in row) else np.arctan2
    if len(R) == 2:
        return {"yaw": atan2(R[1][0], R[0][0]) + 0.0}
    flat = R[0][0] * R[0][0] + R[1][0] * R[1][0]
    upright = flat < 1e-24
    if atan2 is math.atan2:
        roll = math.atan2(-R[1][2], R[1][1]) if upright else math.atan2(R[2][1], R[2][2])
        yaw = 0.0 if upright else math.atan2(R[1][0], R[0][0])
    else:
        roll = np.where(upright, np.arctan2(-R[1][2], R[1][1]), np.arctan2(R[2][1], R[2][2]))
        yaw = np.where(upright, 0.0, np.arctan2(R[1][0], R[0][0]))
    return {"roll": roll + 0.0, "pitch": atan2(-R[2][0], np.sqrt(flat)) + 0.0, "yaw": yaw + 0.0}


def as_quantity(x: Scalar) -> Quantity:
    """A computed scalar as a number of the model."""
    return Members(x) if isinstance(x, np.ndarray) and x.ndim else float(x)
