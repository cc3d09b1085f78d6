"""The shapes of a robot's file as solids of a scene, each fixed in its body: boxes, cylinders,
spheres, capsules, ellipsoids, and the hulls of its meshes where their files are there."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, MissingPackageError, listed, shown
from freebody.formats.meshes import mesh_corners
from freebody.formats.packages import Packages
from freebody.lazy import cached_property, kept
from freebody.model.doubt_rules.inertias import is_bare
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import Shape, ShapeRole
from freebody.moving.fitted_solids import DrawnSolid, FramePlace
from freebody.moving.hulls import DrawnHull, hull
from freebody.outputs.pages import packed
from freebody.spatial import of_dimension

_ROUND = 24  # sides of a cylinder
_TOLD = 4  # names in a sentence
_REASONS = 12
_BEYOND = 20.0
"""Times the reach of the robot beyond which a mesh is of another unit than its file says."""
_SOUGHT = "not found beside the robot's file, above it or in the folders of packages"
_OUTSIDE = "outside the package of the robot's file; package_path= names its folder"
_ROLES: tuple[ShapeRole, ...] = ("visual", "collision")


class DrawnShapes:
    """The solids of all bodies that are drawn by shapes of the file; in the plane there are
    none."""

    def __init__(self, model: Model):
        self._model, self._reach = model, _reach(model)
        self._corners: dict[tuple[str, tuple[str, ...]], Array | None] = {}
        self._packages: dict[tuple[str, ...], Packages] = {}
        self.lost: dict[str, str] = {}
        """Why meshes are not drawn, by their names in the file."""
        self.roles: dict[int, ShapeRole] = {}
        """The use of the shapes with which each body is drawn, by its index (-1: the base)."""
        self.solids: dict[int, list[DrawnSolid | DrawnHull]] = {}
        """The solids of each body that is drawn by its shapes, by its index."""
        for body, roles in self._by_body().items():
            for role in _ROLES:
                solids = self._drawn(body, roles[role]) if role in roles else []
                if solids:
                    self.solids[body], self.roles[body] = solids, role
                    break

    def _by_body(self) -> dict[int, dict[ShapeRole, list[tuple[str, Shape]]]]:
        model = self._model
        found: dict[int, dict[ShapeRole, list[tuple[str, Shape]]]] = {}
        for frame, shape in model.shapes if model.dim == 3 else ():
            if frame in model.tree.frames:
                roles = found.setdefault(model.frame(frame).body, {})
                roles.setdefault(shape.role, []).append((frame, shape))
        return found

    def _drawn(
        self, body: int, shapes: Sequence[tuple[str, Shape]]
    ) -> list[DrawnSolid | DrawnHull]:
        """Solids for the shapes of a body, the meshes of a link as one hull; none where one of them
        cannot be drawn."""
        solids: list[DrawnSolid | DrawnHull] = []
        meshes: dict[str, list[Array]] = {}
        lost = False
        for frame, shape in shapes:
            R, p = self._pose(frame, shape)
            if shape.is_solid:
                solids.append(_SOLIDS[shape.kind](body, shape.size, R, p))
                continue
            corners = self._points(shape)
            lost |= corners is None  # and look at the others, so that all are told of
            if corners is not None:
                meshes.setdefault(frame, []).append(corners @ R.T + p)
        own = (body,) if body >= 0 else ()
        hulls = [hull(body + 1, points, own) for points in meshes.values()]
        return [] if lost else [*solids, *filter(None, hulls)]

    def _pose(self, frame: str, shape: Shape) -> tuple[Array, Array]:
        """The axes and the middle of a shape in the body of a frame."""
        outer, place = (_array(x) for x in self._model.tree.frames[frame][1:])
        R, p = (_array(x) for x in shape.placement.lower(of_dimension(3), VALUES))
        return outer @ R, place + outer @ p

    def _points(self, shape: Shape) -> Array | None:
        """Corners (n, 3) of a mesh or a hull in its own frame; None of one that is not drawn."""
        if shape.kind == "hull":
            return np.array(shape.points)
        key = shape.file, shape.folders
        if key not in self._corners:
            self._corners[key] = self._opened(shape)
        corners = self._corners[key]
        if corners is None:
            return None
        scaled = corners * np.array(shape.size)
        far = float(np.abs(scaled).max())
        if self._reach and far > _BEYOND * self._reach:
            self.lost[shape.file] = (
                f"it reaches {far:.3g} m, and the robot {self._reach:.3g} m: give its scale"
            )
            return None
        return scaled

    def _opened(self, shape: Shape) -> Array | None:
        own, *given = shape.folders or ("",)
        packages = self._packages.setdefault(
            shape.folders, Packages(Path(own) if own else None, tuple(map(Path, given)))
        )
        path = packages.located(shape.file)
        if path is None:
            self.lost[shape.file] = _SOUGHT
            return None
        if not packages.holds(shape.file, path):
            self.lost[shape.file] = _OUTSIDE
            return None
        try:
            return mesh_corners(path)
        except FileError as problem:
            self.lost[shape.file] = problem.problem.rstrip(".")
        except MissingPackageError as problem:
            self.lost[shape.file] = str(problem).rstrip(".")
        return None

    @cached_property
    def unbarred(self) -> set[int]:
        """Indices of the bodies that no bar stands for: those that are drawn by shapes, and beside
        such those that are nothing but a frame between two joints."""
        frames = (k for k, body in enumerate(self._model.bodies) if is_bare(body))
        return {*self.solids, *(frames if self.solids else ())}

    @cached_property
    def hulls(self) -> list[DrawnHull]:
        """The hulls among the solids."""
        solids = (solid for body in self.solids.values() for solid in body)
        return [solid for solid in solids if isinstance(solid, DrawnHull)]

    @property
    def words(self) -> str:
        """Words on which bodies are drawn by shapes of the file and which by bars, how large hulls
        are on the page, and which meshes are not drawn; empty in the plane."""
        return " ".join([*self._drawn_by(), *self._not_drawn()]) if self._model.dim == 3 else ""

    def _drawn_by(self) -> Iterator[str]:
        bodies = [body.name for body in self._model.bodies]
        shaped = [name for k, name in enumerate(bodies) if k in self.solids]
        bare = [name for k, name in enumerate(bodies) if k not in self.unbarred]
        if not shaped:
            yield "Bodies are drawn as bars between their joints."
        elif not bare:
            yield f"Bodies are drawn by {self._what()}."
        else:
            bars = "a bar" if len(bare) == 1 else "bars"
            are = "is" if len(shaped) == 1 else "are"
            yield f"{_names(shaped)} {are} drawn by {self._what()}, {_names(bare)} as {bars}."
        collide = [bodies[k] for k, role in self.roles.items() if role == "collision" and k >= 0]
        if collide:
            of = "" if len(collide) == len(shaped) else f"of {_names(collide)} "
            yield f"Shown are {of}the shapes for collisions."

    def _what(self) -> str:
        if not self.hulls:
            return "shapes of the file"
        size = len(packed(json.dumps([one.data for one in self.hulls], separators=(",", ":"))))
        count = f"{len(self.hulls)} {'hull' if len(self.hulls) == 1 else 'hulls'}"
        plain = any(isinstance(x, DrawnSolid) for body in self.solids.values() for x in body)
        of = "shapes of the file and hulls of its meshes" if plain else "hulls of the file's meshes"
        return f"{of} ({count}, {math.ceil(size / 1000)} kB)"

    def _not_drawn(self) -> Iterator[str]:
        by_reason: dict[str, list[str]] = {}
        for name, reason in self.lost.items():
            by_reason.setdefault(reason, []).append(shown(name.rpartition("/")[2]))
        told = [f"{_names(names)} ({reason})" for reason, names in by_reason.items()]
        if told:
            yield f"Meshes that are not drawn: {listed(told, _REASONS)}."


def drawn_shapes(model: Model) -> DrawnShapes:
    """The shapes with which a robot is drawn, their files opened once."""
    return kept(model, "drawn_shapes", DrawnShapes, model)


def _reach(model: Model) -> float:
    """How far the robot reaches at most, m: the distances of its joints and frames in a row."""
    if model.dim != 3:
        return 0.0
    space = of_dimension(3)
    joints = (body.joint.placement.lower(space, VALUES)[1] for body in model.bodies)
    frames = (_array(frame[2]) for frame in model.tree.frames.values())
    return sum(math.hypot(*p) for p in joints) + max((math.hypot(*p) for p in frames), default=0.0)


def _names(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    return listed(names, _TOLD + 1)


def _array(x: object) -> Array:
    return np.asarray(x, dtype=float)


# ------------------------------------------------------------ solids of each kind
def _ends(body: int, R: Array, p: Array, half: float) -> tuple[FramePlace, FramePlace]:
    """Both ends of a solid along z of its axes."""

    def at(z: float) -> FramePlace:
        x, y, above = p + z * R[:, 2]
        return FramePlace(body + 1, (float(x), float(y), float(above)))

    return at(-half), at(half)


def _side(body: int, R: Array) -> FramePlace:
    """The direction of x of a solid's axes."""
    return FramePlace(body + 1, tuple(map(float, R[:, 0])))


def _own(body: int) -> tuple[int, ...]:
    return (body,) if body >= 0 else ()


def _sphere(body: int, size: tuple[float, ...], R: Array, p: Array) -> DrawnSolid:
    return DrawnSolid(_ends(body, R, p, 0.0), size[0], "link", bodies=_own(body))


def _cylinder(body: int, size: tuple[float, ...], R: Array, p: Array) -> DrawnSolid:
    radius, length = size
    ends = _ends(body, R, p, length / 2)
    return DrawnSolid(ends, radius, "link", round=False, sides=_ROUND, bodies=_own(body))


def _capsule(body: int, size: tuple[float, ...], R: Array, p: Array) -> DrawnSolid:
    radius, length = size
    return DrawnSolid(_ends(body, R, p, length / 2), radius, "link", bodies=_own(body))


def _ellipsoid(body: int, size: tuple[float, ...], R: Array, p: Array) -> DrawnSolid:
    x, y, z = size
    ends, first = _ends(body, R, p, z), _side(body, R)
    return DrawnSolid(ends, x, "link", bodies=_own(body), across=first, ratio=y / x, oval=True)


def _box(body: int, size: tuple[float, ...], R: Array, p: Array) -> DrawnSolid:
    x, y, z = size
    ends, first = _ends(body, R, p, z / 2), _side(body, R)
    return DrawnSolid(ends, x / math.sqrt(2.0), "link", False, 4, _own(body), first, y / x)


_SOLIDS: Mapping[str, Callable[[int, tuple[float, ...], Array, Array], DrawnSolid]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "capsule": _capsule,
    "ellipsoid": _ellipsoid,
}
"""The solid of each kind of shape (`model.shapes.SHAPE_KINDS`) with its axes and middle in a
body."""
