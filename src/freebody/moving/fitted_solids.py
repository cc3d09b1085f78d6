"""Solids fitted to the skeleton of a robot: bars, joints, wheels and rods between places that move
with its bodies, whoever says where these are."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import SAME
from freebody.figures.layers.bare_robot import RING, along
from freebody.figures.skeleton import BodyPlace, DrawnJoint, End, Skeleton, StrutPlace

AXES = 0.16
"""Length of the world's axes, of the drawing's size."""
_LINK, _JOINT, _CROWDED = 0.025, 0.031, 0.55
"""Radii of links and joints, of the drawing's size; what they shrink by where bodies are many."""
_PIN, _LONG = 0.22, 1.25
"""Factors of the symbol of a joint between bodies that have shapes of their own, which shows the
axis and hides little: of its radius and its length."""
MANY = 12
"""Bodies up to which all are named, and drawn in full."""
_THIN = 0.35  # of a link's radius: rods of loops and struts
_AXIS = 0.005  # radius of the world's axes, of the drawing's size
_ABOVE = 0.02  # of the drawing's size: a plane's body lies so far above its predecessor

Role = Literal["link", "joint", "rod", "x", "y", "z"]
"""The part that a solid stands for, which says its colour."""


@dataclass(frozen=True)
class FramePlace:
    """A place fixed in a frame: 0 the world, 1 + k frame k; always with three coordinates."""

    frame: int
    at: tuple[float, ...]

    @property
    def data(self) -> list[float]:
        """The frame's number and the coordinates, as a page reads them."""
        return [self.frame, *(rounded(x) for x in self.at)]


@dataclass(frozen=True)
class MovingPlace:
    """A place of a robot, with the frame that it moves with and the axes (dim, dim) that this frame
    has in the pose to which solids are fitted."""

    frame: int
    at: Array
    axes: Array

    def place(self, away: Array | None = None, above: float = 0.0) -> FramePlace:
        """A place at a distance (dim,) from the anchor, in world axes of that pose; above: the
        height over the plane."""
        local = self.at if away is None else self.at + self.axes.T @ away
        at = [*map(float, local)]
        return FramePlace(self.frame, (*at, above) if len(at) == 2 else tuple(at))

    def way(self, direction: Array) -> FramePlace:
        """A direction (dim,) that moves with the frame, as a place's three numbers."""
        return MovingPlace(self.frame, np.zeros(len(self.at)), self.axes).place(direction)


class Anchors(Protocol):
    """The places of a robot's skeleton as places that move with its bodies."""

    base: MovingPlace

    def origin(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its child."""
        ...

    def carrier(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its parent."""
        ...

    def end(self, body: BodyPlace, end: End | None) -> MovingPlace:
        """An end of a body; None: its centre of mass."""
        ...

    def strut(self, strut: StrutPlace, end: int) -> MovingPlace:
        """The first end (0) of a strut, or the second (1)."""
        ...


@dataclass(frozen=True)
class DrawnSolid:
    """A solid of revolution between two places, metres: a capsule where its ends are round, a
    cylinder, or a prism of few sides, where they are flat, or an ellipsoid."""

    ends: tuple[FramePlace, FramePlace]
    radius: float
    role: Role
    round: bool = True
    sides: int = 20
    bodies: tuple[int, ...] = ()
    """Indices of the bodies with which it is drawn where each stands alone."""
    across: FramePlace | None = None
    """The direction of its first side, for one whose breadth is not its depth."""
    ratio: float = 1.0
    """Breadth of the second side to that of the first."""
    oval: bool = False
    """Whether it is an ellipsoid, whose ends are tips."""

    @property
    def data(self) -> list[Any]:
        """The solid as a page reads it."""
        first, second = (end.data for end in self.ends)
        shape = rounded(self.radius), 2 if self.oval else int(self.round), self.sides
        told = [self.role, first, second, *shape, list(self.bodies)]
        return told if self.across is None else [*told, self.across.data, rounded(self.ratio)]


class FittedSolids:
    """Solids fitted to a skeleton of some size (m); links: indices of bodies that stand for nothing
    real; own: indices of bodies (-1: the base) that have shapes of their own instead of bars."""

    def __init__(
        self,
        pose: Skeleton,
        size: float,
        anchors: Anchors,
        links: Collection[int] = (),
        own: Collection[int] = (),
    ):
        self._pose, self._size, self._anchors = pose, size, anchors
        self._links, self._own = links, own
        thin = _CROWDED if len(pose.bodies) > MANY else 1.0
        self._link, self._joint = thin * _LINK * size, thin * _JOINT * size
        self._flat = pose.dim == 2

    def all(self) -> Iterator[DrawnSolid]:
        """All solids of the robot, and the world's axes."""
        at, base = self._anchors, self._anchors.base
        yield from self._axes()
        for root in self._pose.roots:
            if (
                not self._flat
                and -1 not in self._own
                and root.kind.holds
                and np.linalg.norm(root.carrier) > SAME
            ):
                yield self._bar(base, at.carrier(root), 0.0, self._link)
        for body in self._pose.bodies:
            if body.index not in self._links:
                yield from self._body(body)
        for loop in self._pose.loops:
            yield from self._symbol(loop, (loop.index, loop.parent))
            if np.linalg.norm(loop.origin - loop.carrier) > SAME:
                above = self._height(max(loop.index, loop.parent))
                yield self._rod(at.carrier(loop), at.origin(loop), above)
        for strut in self._pose.struts:
            yield self._rod(at.strut(strut, 0), at.strut(strut, 1), self._height(max(strut.bodies)))

    def _height(self, body: int) -> float:
        """How far above the plane a body is drawn, so that links that cross do not merge."""
        return _ABOVE * self._size * (body + 1) if self._flat else 0.0

    def _bar(
        self, a: MovingPlace, b: MovingPlace, above: float, radius: float, body: int | None = None
    ) -> DrawnSolid:
        own = () if body is None else (body,)
        return DrawnSolid((a.place(above=above), b.place(above=above)), radius, "link", bodies=own)

    def _rod(self, a: MovingPlace, b: MovingPlace, above: float) -> DrawnSolid:
        return DrawnSolid((a.place(above=above), b.place(above=above)), _THIN * self._link, "rod")

    def _body(self, body: BodyPlace) -> Iterator[DrawnSolid]:
        at, above = self._anchors, self._height(body.index)
        if body.kind.holds and np.linalg.norm(body.origin - body.carrier) > SAME:
            yield self._bar(at.carrier(body), at.origin(body), above, 0.6 * self._link)
        for end in body.stick if body.index not in self._own else ():
            bar = at.origin(body), at.end(body, end), above, self._link
            yield self._bar(*bar, body.index)
        if body.kind.holds and body.parent not in self._links:
            yield from self._symbol(body, (body.index,))
        if body.wheel:
            yield self._wheel(body)

    def _wheel(self, body: BodyPlace) -> DrawnSolid:
        middle, half = self._anchors.origin(body), 0.4 * self._link
        ends = self._ends(middle, body.axis, half, self._height(body.index))
        radius, own = RING * self._size, (body.index,)
        return DrawnSolid(ends, radius, "link", round=False, sides=40, bodies=own)

    def _symbol(self, joint: DrawnJoint, own: tuple[int, ...]) -> Iterator[DrawnSolid]:
        """The solids of a joint; in the plane a pin, or the block of a slide."""
        r, above, at = self._joint, self._height(joint.index), self._anchors
        if self._flat:
            if joint.kind.slides and joint.axis is not None:
                ends = self._ends(at.origin(joint), joint.axis, 1.6 * r, above)
                yield DrawnSolid(ends, 1.3 * r, "joint", False, 4, own)
            else:
                ends = self._ends(at.origin(joint), None, 1.2 * r, above)
                yield DrawnSolid(ends, 0.75 * r, "joint", round=False, bodies=own)
            return
        if not joint.kind.solids and joint.kind.mark:
            place = at.origin(joint).place()
            yield DrawnSolid((place, place), 1.25 * r, "joint", bodies=own)
        inside = joint.index in self._own and joint.parent in self._own
        thin, long = (_PIN, _LONG) if inside else (1.0, 1.0)
        for part in joint.kind.solids:
            way = along(joint, part)
            if way is not None:
                middle = at.origin(joint) if part.moves else at.carrier(joint)
                ends = self._ends(middle, way, long * part.half * r)
                alone = own if part.moves else ()
                yield DrawnSolid(ends, thin * part.radius * r, "joint", False, part.sides, alone)

    def _ends(
        self, middle: MovingPlace, way: Array | None, half: float, above: float = 0.0
    ) -> tuple[FramePlace, FramePlace]:
        """Both ends of a solid about its middle; in the plane without a direction, along z."""
        if way is not None:
            return middle.place(-half * way, above), middle.place(half * way, above)
        return middle.place(above=above - half), middle.place(above=above + half)

    def _axes(self) -> Iterator[DrawnSolid]:
        base = self._anchors.base
        roles: tuple[Role, ...] = ("x", "y", "z")
        for role, end in zip(roles, AXES * self._size * np.eye(self._pose.dim), strict=False):
            ends = base.place(), base.place(end)
            radius = _AXIS * self._size
            yield DrawnSolid(ends, radius, role, round=False, sides=8)


def rounded(x: float) -> float:
    """A number of a drawing, to a micrometre."""
    return round(float(x), 6) + 0.0
