"""A robot as a scene that a page draws in any pose: its solids, the ground and the floor that they
move over, names, and the first view."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.figures.drawing import SAME, round_down
from freebody.figures.labelling import RULE
from freebody.figures.layers.bare_robot import clear_way, sticks
from freebody.figures.marked_text import marked, runs
from freebody.figures.skeleton import (
    BodyPlace,
    DrawnJoint,
    End,
    Skeleton,
    StrutPlace,
    extent,
    skeleton,
)
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT, View, best_view
from freebody.model.model import Model
from freebody.moving.fitted_solids import (
    AXES,
    MANY,
    Anchors,
    DrawnSolid,
    FittedSolids,
    FramePlace,
    MovingPlace,
    rounded,
)
from freebody.moving.hulls import DrawnHull
from freebody.moving.shape_solids import drawn_shapes

_POSES = 24  # of a motion: the box that is seen holds them
_MARGIN = 0.05  # of the drawing's size, around all places


class LabelTexts:
    """The formulas that stand in a scene, each typeset once and numbered."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def number(self, formula: str) -> int:
        """The number of a formula; -1 of an empty one."""
        return self._numbers.setdefault(formula, len(self._numbers)) if formula else -1

    @property
    def data(self) -> list[str]:
        """All formulas as the insides of SVG texts, in the order of their numbers."""
        return [marked(runs(formula)) for formula in self._numbers]


@dataclass(frozen=True)
class PlacedName:
    """A name that stands at a place: its colour (a class of `figures.colours`), its number among
    the formulas, the direction in which it would like to go, in the plane."""

    css: str
    label: int
    place: FramePlace
    way: tuple[float, float] = (1.0, 0.5)

    @property
    def data(self) -> list[Any]:
        """The name as a page reads it."""
        return [self.css, self.label, self.place.data, [rounded(x) for x in self.way]]


@dataclass(frozen=True)
class Ground:
    """The support of a robot of the plane: a pedestal under a turn, at a place, or a slide's guide,
    from its beginning to where it has moved, and its direction."""

    places: tuple[FramePlace, ...]

    @property
    def data(self) -> list[list[float]]:
        """The place, or both and the direction, as a page reads them."""
        return [place.data for place in self.places]


@dataclass(frozen=True)
class Scene:
    """A robot's solids, the box and the floor that they move over, and how they are seen first."""

    dim: int
    solids: tuple[DrawnSolid | DrawnHull, ...]
    box: Array
    """Lowest and highest coordinates (2, 3) of what moves, m."""
    size: float
    """Diagonal of the box around the robot, m."""
    view: View
    labels: LabelTexts
    ground: tuple[Ground, ...] = ()
    names: tuple[PlacedName, ...] = ()
    tip: FramePlace | None = None
    level: float = 0.0
    """Height of the floor, m."""
    step: float = 0.0
    """Distance of the floor's lines, m; 0: there is no floor."""

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
            "box": [[rounded(x) for x in corner] for corner in self.box],
            "size": self.size,
            "level": rounded(self.level),
            "step": rounded(self.step),
            "view": [round(azimuth), round(elevation)],
            "ground": [one.data for one in self.ground],
            "names": [name.data for name in self.names],
            "labels": self.labels.data,
            "rule": RULE,
            "tip": self.tip
            and [self.tip.frame, *self.tip.at],  # compared with Python's: not rounded
        }


def scene(model: Model, q: Array) -> Scene:
    """The scene of a robot that moves through the poses q (T, nq); in the plane seen from the
    front."""
    rows = q[np.unique(np.linspace(0, len(q) - 1, _POSES).astype(int))]
    poses = [skeleton(model, row) for row in rows]
    still = np.zeros(model.nv)
    seen, anchors = snapshot(model, rows[0], still, still), BodyAnchors(model, rows[0])
    size, flat, labels = extent(poses), model.dim == 2, LabelTexts()
    box = box_of(poses, size)
    shapes = drawn_shapes(model)
    fitted = FittedSolids(seen.pose, size, anchors, own=shapes.unbarred)
    tip = seen.pose.tip
    return Scene(
        model.dim,
        (*fitted.all(), *chain.from_iterable(shapes.solids.values())),
        box,
        size,
        FLAT if flat else best_view([ends for pose in poses for ends in sticks(pose)]),
        labels,
        tuple(grounds(seen.pose, anchors)),
        tuple(_names(seen, anchors, labels, size)),
        None if tip is None or model.tip is None else anchors.tip(model.tip, tip),
        min(0.0, float(box[0, 2]) + _MARGIN * size),
        round_down(size / 4),
    )


def joint_axes(model: Model, q: Array) -> list[tuple[FramePlace, FramePlace | None]]:
    """The place of each body's joint and the direction of its axis, fixed in the body; None: it has
    no axis in space. A turn of the plane is about z."""
    pose, anchors = skeleton(model, q), BodyAnchors(model, q)
    found: list[tuple[FramePlace, FramePlace | None]] = []
    for body in pose.bodies:
        at, way = anchors.origin(body), None
        if body.axis is not None:
            way = at.way(body.axis)
        elif model.dim == 2 and body.kind.turns:
            way = FramePlace(0, (0.0, 0.0, 1.0))
        found.append((at.place(), way))
    return found


def joint_marks(model: Model, q: Array) -> list[str]:
    """The mark that the joint of each rate has on the robot: a number, in the plane the letter of
    a point; empty where nothing is written, or the joint's own name. Joints that follow another
    have no rate of their own."""
    still = np.zeros(model.nv)
    seen, found = snapshot(model, q, still, still), [""] * model.nv
    for body in seen.drawn if len(seen.pose.bodies) <= MANY else ():
        mark, follows = _mark(seen, body), model.bodies[body.index].joint.mimic is not None
        for k in () if follows else model.coordinates[body.index].v:
            found[k] = "" if mark == model.velocity_names[k] else mark
    return found


def _mark(seen: Snapshot, body: BodyPlace) -> str:
    flat = seen.model.dim == 2
    return seen.names.point(seen.pose, body.number) if flat else str(body.number)


def box_of(poses: Iterable[Skeleton], size: float) -> Array:
    """The box (2, 3) around all places of some poses, with a margin."""
    places = np.concatenate([pose.places for pose in poses])
    places = np.pad(places, ((0, 0), (0, 3 - places.shape[1])))
    return np.array([places.min(axis=0) - _MARGIN * size, places.max(axis=0) + _MARGIN * size])


def grounds(pose: Skeleton, anchors: Anchors) -> Iterator[Ground]:
    """The supports of a robot of the plane; in space it stands on a bar."""
    for root in pose.roots if pose.dim == 2 else ():
        if not root.kind.holds:
            continue
        carrier = anchors.carrier(root)
        if root.kind.slides and root.axis is not None:
            ends = carrier.place(), anchors.origin(root).place(), carrier.way(root.axis)
            yield Ground(ends)
        else:
            yield Ground((carrier.place(),))


class BodyAnchors:
    """The places of a robot of given numbers, each fixed in one of its bodies."""

    def __init__(self, model: Model, q: Array):
        tree = model.tree
        found = world_poses(tree, joint_poses(tree, tuple(map(float, q))))
        own = [found[k] for k in tree.body_of]
        self._frames = [(np.asarray(R, dtype=float), np.asarray(p, dtype=float)) for R, p in own]
        self._frames.append((np.eye(model.dim), np.zeros(model.dim)))  # the world, at -1
        self._model = model
        self.base = self._in(-1, np.zeros(model.dim))

    def _in(self, body: int, world: Array) -> MovingPlace:
        R, p = self._frames[body]
        return MovingPlace(body + 1, R.T @ (world - p), R)

    def origin(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its child."""
        return self._in(joint.index, joint.origin)

    def carrier(self, joint: DrawnJoint) -> MovingPlace:
        """The place of a joint on its parent."""
        return self._in(joint.parent, joint.carrier)

    def end(self, body: BodyPlace, end: End | None) -> MovingPlace:
        """An end of a body, or its centre of mass."""
        return self._in(body.index, body.com if end is None else end.place)

    def strut(self, strut: StrutPlace, end: int) -> MovingPlace:
        """An end of a strut."""
        return self._in(strut.bodies[end], strut.ends[end])

    def tip(self, name: str, place: Array) -> FramePlace:
        """The tip, a frame by name that is at a place (dim,)."""
        return self._in(self._model.frame(name).body, place).place()


def axis_names(
    dim: int, size: float, base: MovingPlace, labels: LabelTexts
) -> Iterator[PlacedName]:
    """The names of the world's axes, at their heads."""
    for css, name, end in zip(
        "xyz", "xy" if dim == 2 else "XYZ", 1.05 * AXES * size * np.eye(dim), strict=False
    ):
        way = (1.0, 0.0) if css == "x" else (0.0, 1.0)
        yield PlacedName(f"{css}-text", labels.number(name), base.place(end), way)


def _names(
    seen: Snapshot, anchors: BodyAnchors, labels: LabelTexts, size: float
) -> Iterator[PlacedName]:
    """Names as the figures have them: the world's axes, the tip, and where bodies are few, the
    points of the plane or the numbers of the joints; one at each place."""
    model, pose = seen.model, seen.pose
    yield from axis_names(model.dim, size, anchors.base, labels)
    taken: list[Array] = []
    if pose.tip is not None and model.tip is not None:
        yield PlacedName(
            "label-text", labels.number(seen.names.tip), anchors.tip(model.tip, pose.tip)
        )
        taken.append(pose.tip)
    for body in seen.drawn if len(pose.bodies) <= MANY else ():
        if any(np.linalg.norm(body.origin - other) < SAME for other in taken):
            continue
        taken.append(body.origin)
        way = clear_way(seen, body) if model.dim == 2 else (0.0, -1.0)
        at, label = anchors.origin(body).place(), labels.number(_mark(seen, body))
        yield PlacedName("label-text", label, at, (float(way[0]), float(way[1])))
