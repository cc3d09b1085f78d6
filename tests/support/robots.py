"""Robots described part by part, written as freebody's TOML and loaded as a user's file is."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import freebody as fb

Quantity = float | str | fb.Parameter


@dataclass(frozen=True)
class Kind:
    """A kind of joint as the tests know it: in which dimensions it exists, how many velocities it
    has, whether it has an axis and is expected to have a range, and the names of its own
    numbers."""

    dimensions: tuple[int, ...]
    nv: int
    axis: bool = False
    ranged: bool = True
    numbers: tuple[str, ...] = ()


KINDS = {
    "revolute": Kind((2, 3), 1, axis=True),
    "continuous": Kind((2, 3), 1, axis=True, ranged=False),
    "prismatic": Kind((2, 3), 1, axis=True),
    "helical": Kind((3,), 1, axis=True, numbers=("pitch",)),
    "fixed": Kind((2, 3), 0),
    "cylindrical": Kind((3,), 2, axis=True),
    "universal": Kind((3,), 2),
    "planar": Kind((2, 3), 3),
    "spherical": Kind((3,), 3),
    "free": Kind((3,), 6),
}
"""A row for each kind of joint; a test holds it against the package's own table."""


# ---------------------------------------------------------------- placements
@dataclass(frozen=True)
class Shift:
    """A translation (m), in the axes reached so far."""

    by: tuple[Quantity, ...]

    def text(self) -> str:
        return _table(shift=_list(self.by))

    def pose(self, dim: int) -> np.ndarray:
        return homogeneous(np.eye(dim), self.by)


@dataclass(frozen=True)
class Turn:
    """A rotation about a coordinate axis by an angle (rad)."""

    axis: str
    angle: Quantity

    def text(self) -> str:
        return _table(turn=_quoted(self.axis), angle=_number(self.angle))

    def pose(self, dim: int) -> np.ndarray:
        s, c = np.sin(self.angle), np.cos(self.angle)
        if dim == 2:
            return homogeneous([[c, -s], [s, c]], np.zeros(2))
        i = "xyz".index(self.axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        R = np.eye(3)
        R[j, j] = R[k, k] = c
        R[k, j], R[j, k] = s, -s
        return homogeneous(R, np.zeros(3))


@dataclass(frozen=True)
class Rotate:
    """A rotation matrix."""

    matrix: tuple[tuple[float, ...], ...]

    def text(self) -> str:
        return _table(matrix=_rows(self.matrix))

    def pose(self, dim: int) -> np.ndarray:
        return homogeneous(self.matrix, np.zeros(dim))


@dataclass(frozen=True)
class Placement:
    """A constant pose as steps, the first step first."""

    steps: tuple[Shift | Turn | Rotate, ...] = ()

    def then(self, other: Placement) -> Placement:
        return Placement(self.steps + other.steps)

    def matrix(self, dim: int = 3) -> np.ndarray:
        """The pose of a placement of numbers, by plain NumPy, one step at a time."""
        T = np.eye(dim + 1)
        for step in self.steps:
            T = T @ step.pose(dim)
        return T

    def inverse(self, dim: int = 3) -> Placement:
        """The way back."""
        return placed(np.linalg.inv(self.matrix(dim)))

    def entries(self) -> dict[str, str]:
        """The entries of a table that has this placement."""
        return {"steps": _texts(step.text() for step in self.steps)} if self.steps else {}


def homogeneous(R: Any, p: Any) -> np.ndarray:
    """The pose with this rotation and origin."""
    dim = len(p)
    T = np.eye(dim + 1)
    T[:dim, :dim], T[:dim, dim] = R, p
    return T


def shift(*by: Quantity) -> Placement:
    """A translation; nothing at all where it is zero."""
    return Placement((Shift(by),)) if any(x != 0.0 for x in by) else Placement()


def turn(axis: str, angle: Quantity) -> Placement:
    """A rotation about a coordinate axis; nothing at all where it is zero."""
    return Placement((Turn(axis, angle),)) if angle != 0.0 else Placement()


def rotate(matrix: Any) -> Placement:
    """A rotation matrix; nothing at all where it is the unit one."""
    R = np.asarray(matrix, dtype=float)
    return Placement() if np.array_equal(R, np.eye(len(R))) else Placement((Rotate(_tuples(R)),))


def rpy(roll: float, pitch: float, yaw: float) -> Placement:
    """Fixed-axis roll, pitch and yaw, as in a URDF."""
    return turn("z", yaw).then(turn("y", pitch)).then(turn("x", roll))


def placed(T: np.ndarray) -> Placement:
    """A pose as a placement, its rotation one to the last digit."""
    dim = len(T) - 1
    R = T[:dim, :dim]
    if not np.array_equal(R, np.eye(dim)):
        U, _, V = np.linalg.svd(R)
        R = U @ V
    return shift(*T[:dim, dim].tolist()).then(rotate(R))


# ---------------------------------------------------------------- parts
@dataclass(frozen=True)
class Link:
    """A rigid part, its inertia in a frame placed in its own."""

    name: str
    inertia: fb.Inertia | None = None
    placement: Placement = Placement()

    def text(self) -> str:
        frame = self.placement.entries()
        more = {"inertia_frame": _table(**frame)} if frame else {}
        return _section("link", name=_quoted(self.name), **_mass(self.inertia), **more)


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = ratio · q(joint) + offset, and the terms of the
    square, the cube, … of q(joint) besides."""

    joint: str
    ratio: float = 1.0
    offset: float = 0.0
    powers: tuple[float, ...] = ()


@dataclass(frozen=True)
class Joint:
    """A joint, its frame placed in the parent link's."""

    name: str
    kind: str
    parent: str
    child: str
    placement: Placement = Placement()
    axis: tuple[float, ...] = ()
    limits: fb.Limits = fb.Limits()
    drive: fb.Drive = fb.Drive()
    mimic: Mimic | None = None
    passive: bool = False
    numbers: tuple[Quantity, ...] = ()

    def text(self) -> str:
        entries = {
            key: _quoted(getattr(self, key)) for key in ("name", "kind", "parent", "child")
        } | self.placement.entries()
        if self.axis:
            entries["axis"] = _number(self.axis[0]) if len(self.axis) == 1 else _list(self.axis)
        entries |= zip(KINDS[self.kind].numbers, map(_number, self.numbers), strict=True)
        if self.limits != fb.Limits():
            entries["limits"] = _numbers(vars(self.limits))
        drive = self.drive
        if drive.viscous or drive.coulomb:
            entries["friction"] = _numbers({"viscous": drive.viscous, "coulomb": drive.coulomb})
        if drive.rotor or drive.gear != 1.0:
            entries["rotor"] = _numbers({"inertia": drive.rotor, "gear": drive.gear})
        if drive.stiffness or drive.rest:
            entries["spring"] = _numbers({"stiffness": drive.stiffness, "rest": drive.rest})
        if self.mimic:
            ratio, offset = _number(self.mimic.ratio), _number(self.mimic.offset)
            if self.mimic.powers:
                ratio = _list((self.mimic.ratio, *self.mimic.powers))
            entries["mimic"] = _table(joint=_quoted(self.mimic.joint), ratio=ratio, offset=offset)
        if self.passive:
            entries["passive"] = "true"
        return _section("joint", **entries)


@dataclass(frozen=True)
class Mount:
    """A named frame fixed to a link or frame."""

    name: str
    link: str
    placement: Placement = Placement()

    def text(self) -> str:
        at = self.placement.entries()
        return _section("frame", name=_quoted(self.name), parent=_quoted(self.link), **at)


@dataclass(frozen=True)
class Payload:
    """A rigid load fixed to a frame."""

    name: str
    frame: str
    inertia: fb.Inertia

    def text(self) -> str:
        names = {"name": _quoted(self.name), "frame": _quoted(self.frame)}
        return _section("payload", **names, **_mass(self.inertia))


@dataclass(frozen=True)
class Loop:
    """A closed chain: two frames held together."""

    name: str
    kind: str
    frames: tuple[str, str]
    axis: tuple[float, ...] = ()
    distance: Quantity | None = None

    def text(self) -> str:
        more = {"axis": _list(self.axis)} if self.axis else {}
        if self.distance is not None:
            more["distance"] = _number(self.distance)
        frames = _texts(map(_quoted, self.frames))
        return _section(
            "loop", name=_quoted(self.name), kind=_quoted(self.kind), frames=frames, **more
        )


@dataclass(frozen=True)
class Robot:
    """Links and joints, and what goes with them; gravity is a size, downwards, a vector, or
    a size and a direction."""

    name: str
    dim: int
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    gravity: Any
    mounts: tuple[Mount, ...] = ()
    loops: tuple[Loop, ...] = ()
    payloads: tuple[Payload, ...] = ()
    tip: str | None = None
    home: tuple[tuple[str, float], ...] = ()
    source: str = ""

    def text(self) -> str:
        """Its TOML."""
        head = {"name": _quoted(self.name), "dim": str(self.dim), "gravity": self._gravity()}
        head |= {key: _quoted(x) for key in ("tip", "source") if (x := getattr(self, key))}
        home = {_quoted(name): _number(x) for name, x in self.home}
        parts = (*self.links, *self.joints, *self.mounts, *self.payloads, *self.loops)
        return "\n".join(
            [_lines(head), *(part.text() for part in parts), "[home]\n" + _lines(home)]
        )

    def _gravity(self) -> str:
        if isinstance(self.gravity, int | float):
            size, direction = self.gravity, (0.0,) * (self.dim - 1) + (-1.0,)
        elif np.ndim(self.gravity[-1]) == 0:
            return _list(self.gravity)
        else:
            size, direction = self.gravity
        return _table(size=_number(size), direction=_list(direction))


def loaded(robot: Robot | str, **options: Any) -> fb.Model:
    """The model that a file of this robot, or of this text, describes; options as for fb.load."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.toml"
        path.write_text(robot if isinstance(robot, str) else robot.text(), encoding="utf-8")
        return fb.load(path, **({"physical": "refuse"} | options))


# ---------------------------------------------------------------- TOML text
def _number(value: Quantity) -> str:
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, fb.Parameter):
        name = _quoted(value.name)
        return name if value.value is None else _table(name=name, value=_number(value.value))
    return repr(float(value))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _texts(texts: Iterable[str]) -> str:
    return f"[{', '.join(texts)}]"


def _list(values: Iterable[Quantity]) -> str:
    return _texts(map(_number, values))


def _rows(rows: Iterable[Sequence[float]]) -> str:
    return _texts(map(_list, rows))


def _table(**entries: str) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in entries.items())} }}"


def _numbers(entries: Mapping[str, Quantity]) -> str:
    return _table(**{key: _number(value) for key, value in entries.items()})


def _lines(entries: Mapping[str, str]) -> str:
    return "\n".join(f"{key} = {value}" for key, value in entries.items())


def _section(kind: str, /, **entries: str) -> str:
    return f"[[{kind}]]\n{_lines(entries)}"


def _mass(inertia: fb.Inertia | None) -> dict[str, str]:
    if inertia is None:
        return {}
    tensor = _number(inertia.tensor[0]) if len(inertia.tensor) == 1 else _list(inertia.tensor)
    return {"mass": _number(inertia.mass), "com": _list(inertia.com), "inertia": tensor}


def _tuples(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, matrix.tolist()))
