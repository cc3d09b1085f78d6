"""Shapes of links as a file gives them. The dynamics do not depend on them: they serve to draw, and
to check or estimate masses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from freebody.errors import IncludedLine
from freebody.model.inertia import Inertia
from freebody.model.placement import Placement

DENSEST, LIGHTEST = 20e3, 5.0
"""kg/m³: gold and tungsten are near the one, air is 1.2."""
ShapeRole = Literal["collision", "visual"]
"""The use of a shape: it is to be seen, or it collides."""
SolidKind = Literal["box", "cylinder", "sphere", "capsule", "ellipsoid"]


@dataclass(frozen=True)
class ShapeKind:
    """A kind of solid, from its sizes (m): their names, its volume (m³), the largest distance of a
    point from its centre (m), and its inertia, filled evenly with a mass (kg)."""

    sizes: tuple[str, ...]
    volume: Callable[..., float]
    radius: Callable[..., float]
    uniform: Callable[..., Inertia]


def _ball(radius: float) -> float:
    return 4 / 3 * math.pi * radius * radius * radius


def _rod(radius: float, length: float) -> float:
    return math.pi * radius * radius * length


def _capsule(mass: float, radius: float, length: float) -> Inertia:
    ends = mass * _ball(radius) / (_ball(radius) + _rod(radius, length))
    middle, r2, l2 = mass - ends, radius * radius, length * length
    along = middle * r2 / 2 + ends * 0.4 * r2
    across = middle * (3 * r2 + l2) / 12 + ends * (0.4 * r2 + 0.375 * radius * length + l2 / 4)
    return Inertia.of(mass, (0.0, 0.0, 0.0), (across, 0.0, 0.0, across, 0.0, along))


def _ellipsoid(mass: float, a: float, b: float, c: float) -> Inertia:
    x, y, z = (mass * half * half / 5 for half in (a, b, c))
    return Inertia.of(mass, (0.0, 0.0, 0.0), (y + z, 0.0, 0.0, x + z, 0.0, x + y))


SHAPE_KINDS: dict[str, ShapeKind] = {
    "box": ShapeKind(
        ("x", "y", "z"),
        lambda x, y, z: x * y * z,
        lambda x, y, z: 0.5 * math.hypot(x, y, z),
        lambda mass, *sides: Inertia.box(mass, sides),
    ),
    "cylinder": ShapeKind(
        ("radius", "length"), _rod, lambda r, length: math.hypot(r, 0.5 * length), Inertia.cylinder
    ),
    "sphere": ShapeKind(("radius",), _ball, lambda r: r, Inertia.sphere),
    "capsule": ShapeKind(
        ("radius", "length"),
        lambda r, length: _ball(r) + _rod(r, length),
        lambda r, length: r + 0.5 * length,
        _capsule,
    ),
    "ellipsoid": ShapeKind(
        ("x", "y", "z"), lambda a, b, c: _ball(1.0) * a * b * c, max, _ellipsoid
    ),
}
"""Kinds of solids by their names. Boxes have sides, ellipsoids half axes; cylinders and capsules
are along z, and the length of a capsule is that between the middles of its ends."""


@dataclass(frozen=True)
class Shape:
    """A solid (`SHAPE_KINDS`), the mesh in a file, or the hull of points, placed in the link's
    frame; solids are centred."""

    kind: SolidKind | Literal["mesh", "hull"]
    size: tuple[float, ...]
    """Sizes of the solid, m; of a mesh the factors along x, y, z; of a hull nothing."""
    placement: Placement
    role: ShapeRole
    file: str = ""
    """The file of a mesh, as written."""
    line: int | IncludedLine | None = None
    points: tuple[tuple[float, float, float], ...] = field(default=(), repr=False)
    """Points of a hull, m."""
    folders: tuple[str, ...] = field(default=(), compare=False, repr=False)
    """Folders where a mesh's file is looked for: that of the robot's file ("": none), then those
    of packages that the user named."""

    @property
    def is_solid(self) -> bool:
        """Whether the shape is a solid of known form, no mesh and no hull."""
        return self.kind in SHAPE_KINDS

    @property
    def volume(self) -> float:
        """Volume of the solid, m³; NaN of a mesh, whose file would have to be opened, and of a
        hull."""
        return SHAPE_KINDS[self.kind].volume(*self.size) if self.is_solid else math.nan

    @property
    def radius(self) -> float:
        """The largest distance of a point of the shape from its centre, of a hull from its frame
        (m); 0 for a mesh, which is not opened."""
        if self.is_solid:
            return SHAPE_KINDS[self.kind].radius(*self.size)
        return max((math.hypot(*point) for point in self.points), default=0.0)

    def uniform(self, density: float) -> Inertia:
        """The inertia (own frame) of a solid filled with a density (kg/m³)."""
        return SHAPE_KINDS[self.kind].uniform(density * self.volume, *self.size)
