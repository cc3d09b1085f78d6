"""A robot as solids that a page draws in any pose: stretches between places of its bodies, round or
flat at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.figures.drawing import SAME, round_down
from freebody.figures.layers.bare_robot import RING, along, bars, sticks
from freebody.figures.skeleton import BodyPlace, DrawnJoint, Skeleton, extent, skeleton
from freebody.figures.view import FLAT, View, best_view
from freebody.model.model import Model

_LINK, _JOINT, _CROWDED = 0.025, 0.031, 0.55
"""Radii of links and joints, of the drawing's size; what they shrink by where bodies are many."""
_MANY = 12  # bodies
_THIN = 0.35  # of a link's radius: rods of loops and struts
_AXES = 0.16, 0.005  # length and radius of the world's axes, of the drawing's size
_POSES = 24  # of a motion: the box that is seen holds them
_ABOVE = 0.02  # of the drawing's size: a plane's body lies so far above its predecessor

Role = Literal["link", "joint", "rod", "x", "y", "z"]
"""The part that a solid stands for, which says its colour."""


@dataclass(frozen=True)
class FramePlace:
    """A place fixed in a frame: 0 the world, 1 + i body i; always with three coordinates."""

    frame: int
    at: tuple[float, ...]

    @property
    def data(self) -> list[float]:
        """The frame's number and the coordinates, as a page reads them."""
        return [self.frame, *(_rounded(x) for x in self.at)]


@dataclass(frozen=True)
class DrawnSolid:
    """A solid of revolution between two places, metres: a capsule where its ends are round, a
    cylinder, or a prism of few sides, where they are flat."""

    ends: tuple[FramePlace, FramePlace]
    radius: float
    role: Role
    round: bool = True
    sides: int = 20

    @property
    def data(self) -> list[Any]:
        """The solid as a page reads it."""
        first, second = (end.data for end in self.ends)
        return [self.role, first, second, _rounded(self.radius), int(self.round), self.sides]


@dataclass(frozen=True)
class Scene:
    """A robot's solids, the box and the floor that they move over, and how they are seen first."""

    dim: int
    solids: tuple[DrawnSolid, ...]
    box: Array
    """Lowest and highest coordinates (2, 3) of what moves, m."""
    level: float
    """Height of the floor, m."""
    step: float
    """Distance of the floor's lines, m."""
    view: View
    names: tuple[tuple[str, FramePlace], ...]
    """Texts that stand at places."""
    tip: FramePlace | None

    @property
    def data(self) -> dict[str, Any]:
        """The scene as JSON data."""
        azimuth, elevation = 0.0, 90.0
        if self.view.towards:
            x, y, z = self.view.towards
            azimuth, elevation = math.degrees(math.atan2(y, x)), math.degrees(math.asin(z))
        return {
            "flat": self.dim == 2,
            "solids": [solid.data for solid in self.solids],
            "box": [[_rounded(x) for x in corner] for corner in self.box],
            "level": _rounded(self.level),
            "step": _rounded(self.step),
            "view": [round(azimuth), round(elevation)],
            "names": [[text, place.data] for text, place in self.names],
            "tip": self.tip
            and [self.tip.frame, *self.tip.at],  # compared with Python's: not rounded
        }


def scene(model: Model, q: Array) -> Scene:
    """The scene of a robot that moves through the poses q (T, nq); in the plane seen from the
    front."""
    rows = q[np.unique(np.linspace(0, len(q) - 1, _POSES).astype(int))]
    poses = [skeleton(model, row) for row in rows]
    size = extent(poses)
    first = _PoseSolids(model, rows[0], poses[0], size)
    flat = model.dim == 2
    places = np.concatenate([pose.places for pose in poses])
    places = np.pad(places, ((0, 0), (0, 3 - model.dim)))
    margin = 1.5 * _JOINT * size
    box = np.array([places.min(axis=0) - margin, places.max(axis=0) + margin])
    view = FLAT if flat else best_view([ends for pose in poses for ends in sticks(pose)])
    return Scene(
        model.dim,
        tuple(first.solids()),
        box,
        min(0.0, float(places[:, 2].min())),
        round_down(size / 4),
        view,
        tuple(first.names()),
        first.tip(),
    )


class _PoseSolids:
    """Solids fitted to the skeleton of a robot in one pose."""

    def __init__(self, model: Model, q: Array, pose: Skeleton, size: float):
        tree = model.tree
        found = world_poses(tree, joint_poses(tree, tuple(map(float, q))))
        own = [found[k] for k in tree.body_of]
        self._frames = [(np.asarray(R, dtype=float), np.asarray(p, dtype=float)) for R, p in own]
        self._model, self._pose, self._size = model, pose, size
        thin = _CROWDED if len(model.bodies) > _MANY else 1.0
        self._link, self._joint = thin * _LINK * size, thin * _JOINT * size

    def place(self, body: int, world: Array, above: float = 0.0) -> FramePlace:
        """A place of the world as one of a body (-1: the base), in the plane lifted above it."""
        local = world
        if body >= 0:
            R, p = self._frames[body]
            local = R.T @ (world - p)
        at = [*map(float, local)]
        return FramePlace(body + 1, (*at, above) if len(at) == 2 else tuple(at))

    def solids(self) -> Iterator[DrawnSolid]:
        """All solids of the robot."""
        yield from self._axes()
        for root in self._pose.roots:
            if root.kind.holds and np.linalg.norm(root.carrier) > SAME:
                base = np.zeros(self._model.dim)
                yield self._bar(-1, base, -1, root.carrier, self._link, "link")
        for body in self._pose.bodies:
            yield from self._body(body)
        for loop in self._pose.loops:
            yield from self._symbol(loop)
            if np.linalg.norm(loop.origin - loop.carrier) > SAME:
                ends = loop.parent, loop.carrier, loop.index, loop.origin
                yield self._bar(*ends, _THIN * self._link, "rod")
        for strut in self._pose.struts:
            (i, j), (a, b) = strut.bodies, strut.ends
            yield self._bar(i, a, j, b, _THIN * self._link, "rod")

    def _height(self, body: int) -> float:
        """How far above the plane a body is drawn, so that links that cross do not merge."""
        return _ABOVE * self._size * (body + 1) if self._model.dim == 2 else 0.0

    def _bar(self, i: int, a: Array, j: int, b: Array, radius: float, role: Role) -> DrawnSolid:
        above = self._height(max(i, j))
        return DrawnSolid((self.place(i, a, above), self.place(j, b, above)), radius, role)

    def _body(self, body: BodyPlace) -> Iterator[DrawnSolid]:
        slid = body.kind.holds and np.linalg.norm(body.origin - body.carrier) > SAME
        for k, (_, (a, b)) in enumerate(bars(body)):
            carried = body.parent if slid and not k else body.index
            radius = 0.6 * self._link if slid and not k else self._link
            yield self._bar(carried, a, body.index, b, radius, "link")
        if body.kind.holds:
            yield from self._symbol(body)
        if not bars(body) and body.mass and body.kind.turns:
            yield self._wheel(body)

    def _wheel(self, body: BodyPlace) -> DrawnSolid:
        axis = np.zeros(self._model.dim) if body.axis is None else body.axis
        half = 0.4 * self._link
        ends = self._ends(body.index, body.origin, axis, half, self._height(body.index))
        return DrawnSolid(ends, RING * self._size, "link", round=False, sides=40)

    def _symbol(self, joint: DrawnJoint) -> Iterator[DrawnSolid]:
        """The solids of a joint; in the plane a pin, or the block of a slide."""
        r, above = self._joint, self._height(joint.index)
        if self._model.dim == 2:
            if joint.kind.slides and joint.axis is not None:
                half = 1.6 * r
                ends = self._ends(joint.index, joint.origin, joint.axis, half, above)
                yield DrawnSolid(ends, 1.3 * r, "joint", round=False, sides=4)
            else:
                ends = self._ends(joint.index, joint.origin, np.zeros(2), 1.2 * r, above)
                yield DrawnSolid(ends, 0.75 * r, "joint", round=False)
            return
        if not joint.kind.solids and joint.kind.mark:
            at = self.place(joint.index, joint.origin)
            yield DrawnSolid((at, at), 1.25 * r, "joint")
        for part in joint.kind.solids:
            way = along(joint, part)
            if way is not None:
                body = joint.index if part.moves else joint.parent
                middle = joint.origin if part.moves else joint.carrier
                ends = self._ends(body, middle, way, part.half * r)
                yield DrawnSolid(ends, part.radius * r, "joint", round=False, sides=part.sides)

    def _ends(
        self, body: int, middle: Array, way: Array | None, half: float, above: float = 0.0
    ) -> tuple[FramePlace, FramePlace]:
        """Both ends of a solid about its middle; in the plane without a direction, along z."""
        if way is not None and np.any(way):
            low, high = (self.place(body, middle + s * half * way, above) for s in (-1, 1))
            return low, high
        low = self.place(body, middle, above)
        first, second = (FramePlace(low.frame, (*low.at[:2], above + z)) for z in (-half, half))
        return first, second

    def _axes(self) -> Iterator[DrawnSolid]:
        length, radius = (share * self._size for share in _AXES)
        for name, end in zip(("x", "y", "z")[: self._model.dim], np.eye(3), strict=False):
            ends = FramePlace(0, (0.0, 0.0, 0.0)), FramePlace(0, tuple(map(float, length * end)))
            yield DrawnSolid(ends, radius, name, round=False, sides=8)  # type: ignore[arg-type]

    def names(self) -> Iterator[tuple[str, FramePlace]]:
        """Names of the world's axes, of the tip, and the numbers of the joints where they are
        few."""
        letters = "xy" if self._model.dim == 2 else "XYZ"
        for name, end in zip(letters, np.eye(3), strict=False):
            yield name, FramePlace(0, tuple(map(float, 1.15 * _AXES[0] * self._size * end)))
        tip = self.tip()
        if tip is not None and self._model.tip is not None:
            yield self._model.tip, tip
        if len(self._pose.bodies) <= _MANY:
            for body in self._pose.bodies:
                yield str(body.number), self.place(body.index, body.origin)

    def tip(self) -> FramePlace | None:
        """The robot's tip; None without one."""
        if self._model.tip is None or self._pose.tip is None:
            return None
        return self.place(self._model.frame(self._model.tip).body, self._pose.tip)


def _rounded(x: float) -> float:
    """A number of a drawing, to a micrometre."""
    return round(float(x), 6) + 0.0
