"""The frames of a page's drawing: places and axes that follow from the sliders, as numbers in the
output of the page's program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import frame_pose
from freebody.arrays import Array
from freebody.figures.skeleton import BodyPlace, DrawnJoint, End, LoopPlace, StrutPlace
from freebody.model.model import Model
from freebody.model.tree import TreeBody
from freebody.moving.fitted_solids import MovingPlace
from freebody.moving.placements import in_space
from freebody.spatial import add, product, sub, times
from freebody_textbook.living.body_quantities import vector
from freebody_textbook.living.page_program import PageProgram
from freebody_textbook.methods.setting import Setting


class PageFrames:
    """The places of a robot's skeleton as symbols, each a frame of its own; the bodies of the
    skeleton are those of the model, which are `bodies` of the setting's tree. origin: the place
    from which all are seen; None: that of the world."""

    def __init__(
        self,
        kernel: PageProgram,
        setting: Setting,
        model: Model,
        bodies: Sequence[int],
        origin: Any = None,
    ):
        self._kernel, self._s, self._model = kernel, setting, model
        self._bodies, self._origin = bodies, origin
        self._unit = tuple(map(tuple, np.eye(model.dim).tolist()))
        self._numbers: dict[tuple[int, ...], int] = {}
        self.base = MovingPlace(0, np.zeros(model.dim), np.eye(model.dim))

    @property
    def data(self) -> list[int]:
        """Where the twelve numbers of each frame are in the program's output."""
        return [place for places in self._numbers for place in places]

    @property
    def count(self) -> int:
        """The number of frames."""
        return len(self._numbers)

    def frame(self, R: Any, p: Any, axes: Array) -> MovingPlace:
        """The origin of a frame with axes R at p; axes: their numbers at the start."""
        at = p if self._origin is None else sub(p, self._origin)
        places = tuple(self._kernel.places(vector(self._s, in_space(R, at))))
        number = self._numbers.setdefault(places, len(self._numbers))
        return MovingPlace(number + 1, np.zeros(len(axes)), axes)

    def point(self, p: Any) -> list[float]:
        """A place of the world as the page reads it."""
        return self.frame(self._unit, p, np.eye(len(self._unit))).place().data

    def named(self, name: str, axes: Array | None = None) -> MovingPlace:
        """The place of a frame by its name."""
        R, p = frame_pose(self._s.tree, self._s.world, name)
        return self.frame(R, p, np.eye(self._model.dim) if axes is None else axes)

    def origin(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its child."""
        if isinstance(joint, LoopPlace):
            return self.named(self._loop(joint)[1], joint.rotation)
        return self.frame(*self._s.world[self._bodies[joint.index]], joint.rotation)

    def carrier(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its parent."""
        if isinstance(joint, LoopPlace):
            return self.named(self._loop(joint)[0], joint.carrier_rotation)
        return self.frame(*self._carried(self._first(joint.index)), joint.carrier_rotation)

    def end(self, body: BodyPlace, end: End | None) -> MovingPlace:
        """An end of a body, or its centre of mass."""
        i = self._bodies[body.index]
        R, _ = self._s.world[i]
        if end is None:
            p = self._s.centre_position(i)
        elif end.child is None:
            _, p = frame_pose(self._s.tree, self._s.world, end.name)
        else:
            _, p = self._carried(self._first(end.child))
        return self.frame(R, p, body.rotation)

    def strut(self, strut: StrutPlace, end: int) -> MovingPlace:
        """An end of a strut."""
        own = next(x for x in self._model.struts if x.name == strut.name)
        return self.named(own.frames[end])

    def _loop(self, loop: LoopPlace) -> tuple[str, str]:
        return next(x.frames for x in self._model.loops if x.name == loop.name)

    def _carried(self, first: TreeBody) -> tuple[Any, Any]:
        """The axes and the place of a joint on the body before."""
        if first.parent < 0:
            return first.R, first.p
        R, origin = self._s.world[first.parent]
        return product(R, first.R), add(origin, times(R, first.p))

    def _first(self, body: int) -> TreeBody:
        """The first tree body of a joint that consists of several single joints."""
        own = self._bodies[body]
        before = (k for k in self._bodies if k < own)
        return self._s.tree.bodies[1 + max(before, default=-1)]
