"""How a placement is told in numbers, and how others are put there."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.model.families import Members
from freebody.model.parameters import Quantity
from freebody.model.piece_paths import Fields, Path, get, is_plain, named_leaves, put
from freebody.model.placement import AxisRotation, Placement, Rotate, Shift, shift, turn
from freebody.model.quantity_reader import VALUES
from freebody.spatial import AnySpace, Matrix, Vector, identity

if TYPE_CHECKING:
    from freebody.model.model import Model

ANGLES = {2: ("yaw",), 3: ("roll", "pitch", "yaw")}


@dataclass(frozen=True)
class PoseEditor:
    """A placement: x, y, z (m), then roll, pitch, yaw (rad) about the axes of the frame that it is
    told in, R = Rz(yaw) Ry(pitch) Rx(roll).

    outer: the frame that its first steps lead to, and that it is told in; None: the body's.
    frame: its name, where it is a frame's: all that is fixed to that frame moves with it.
    """

    path: Path
    outer: str | None
    space: AnySpace
    frame: str = ""
    first = False

    @property
    def keeps_places(self) -> bool:
        """What is fixed to a frame may have other steps in front."""
        return not self.frame

    @staticmethod
    def tells(own: tuple[Any, ...]) -> bool:
        """Whether such numbers can be told of these steps, which may hold symbols."""
        leaves = named_leaves(own)
        if any(len(name) > 1 for name in leaves):  # entries of a DH table are the numbers there
            return False
        return not leaves or not any(isinstance(step, Shift) for step in own[1:])

    def start(self, model: Model) -> int:
        """How many steps lead to the outer frame."""
        return 0 if self.outer is None else steps_to(model, self.outer)

    def read(self, model: Model, wanted: Collection[str] | None = None) -> dict[str, Quantity]:
        by, turns = self._split(get(model, self.path).steps[self.start(model) :])
        return self._fields(by, turns)

    def alone(self, model: Model, field: str) -> tuple[Path, ...]:
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
        """One shift, and the turns behind it, that come to the same as the steps."""
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
    """How many steps lead to a frame of its body."""
    return len(model.frame(frame).placement.steps)


def _riders(model: Model, name: str) -> list[Path]:
    """Paths of the placements that begin with that of a frame: of frames, inertias, loads and
    joints fixed to it."""
    on: dict[str, list[str]] = {}
    for frame in model.frames:
        on.setdefault(frame.parent, []).append(frame.name)
    reached, waiting = {name}, [name]
    while waiting:
        below = on.get(waiting.pop(), [])
        reached.update(below)
        waiting += below
    paths: list[Path] = [
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
        part = get(model, path)
        if (part.frame if part.load else part.link) in reached:
            paths.append((*path, "placement"))
    return paths


_ABOUT = {"roll": "x", "pitch": "y", "yaw": "z"}
_LETTER = {"x": 0, "y": 1, "z": 2}


def _angles_of(R: Matrix) -> dict[str, Scalar]:
    """Roll, pitch and yaw of a rotation, in the plane yaw; where they are not unique, yaw = 0."""
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
