"""Kinds of loops: the joints that close a chain, each as the motions it forbids.

A loop joins frame A and frame B. Every kind is made of three things, and an algorithm knows no
others:

- the origins coincide (as many equations as the space has dimensions), or stay a fixed distance
  apart (one);
- directions n fixed in A along which the origin of B does not leave that of A: n · (p_B - p_A) = 0;
- pairs (n fixed in A, u fixed in B) that stay perpendicular: n · u = 0, the sine of an angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freebody.spatial import AnySpace, Vector, identity, neg, scale

AxisPair = tuple[Vector, Vector]


@dataclass(frozen=True)
class Closure:
    """The equations of a loop: see the module. `turns` are ordered and signed so that u × n is an
    axis of frame A."""

    point: bool = False
    distance: bool = False
    slides: tuple[Vector, ...] = ()
    turns: tuple[AxisPair, ...] = ()
    aligned: bool = True
    """Whether the pairs together hold axes of B to those of A, so that u × n stays what it is; the
    two axes of a universal joint may cross either way."""

    @property
    def facing(self) -> tuple[AxisPair, ...]:
        """The pairs of which u × n tells whether the loop is closed the right way round."""
        return self.turns if self.aligned else ()

    def size(self, space: AnySpace) -> int:
        """Number of equations of the closure."""
        return (space.dim if self.point else 0) + self.distance + len(self.slides) + len(self.turns)

    def row_names(self, space: AnySpace) -> tuple[str, ...]:
        """Names of the multipliers of the equations, each a force or a moment."""
        forces = (
            [f"f{x}" for x in space.axes] if self.point else ["tension"] if self.distance else []
        )
        forces += [f"f{_letter(n, k)}" for k, n in enumerate(self.slides)]
        if space.dim == 2:
            return (*forces, *["m"] * len(self.turns))
        return (
            *forces,
            *(f"m{_letter(space.moment(u, n), k)}" for k, (n, u) in enumerate(self.turns)),
        )


def _letter(direction: Vector, k: int) -> str:
    """x, y or z of a coordinate axis of frame A, else a number."""
    along = [i for i, x in enumerate(direction) if isinstance(x, float) and abs(x) == 1.0]
    return "xyz"[along[0]] if along else str(k + 1)


@dataclass(frozen=True)
class LoopKind:
    """A kind of loop as a user names it."""

    name: str
    closure: Callable[[AnySpace, Vector], Closure]
    dimensions: tuple[int, ...] = (2, 3)
    axis_in: tuple[int, ...] = ()
    """The spaces in which it has an axis."""
    needs_distance: bool = False
    elsewhere: str = ""
    """Name of this kind in the space in which its own name does not exist."""
    pins: bool = False
    """Whether it does no more than hold two points, or lines, together."""
    symbols: tuple[str, str] = ("", "")
    """The kinds of joint whose symbols it has in drawings of the plane and of space; default: that
    of its own name."""

    def symbol(self, dim: int) -> str:
        """The kind of joint whose symbol it has in drawings of that dimension."""
        return self.symbols[dim - 2] or self.name

    def axis_in_space(self, axis: tuple[float, ...]) -> tuple[float, ...]:
        """The axis of a planar model's loop in its twin in space, whose xy-plane the plane is."""
        if 2 in self.axis_in:
            return (*axis, 0.0)
        return (0.0, 0.0, 1.0) if 3 in self.axis_in else ()


def normals(axis: Vector) -> tuple[Vector, ...]:
    """Unit vectors that span what is perpendicular to a unit axis: one in the plane; in space t1 ×
    t2 = axis."""
    if len(axis) == 2:
        return ((-axis[1], axis[0]),)
    along = [i for i, x in enumerate(axis) if abs(x) == 1.0]
    if along:
        i = along[0]
        units = identity(3)
        t1, t2 = units[(i + 1) % 3], units[(i + 2) % 3]
        return t1, scale(float(axis[i]), t2)
    a = np.array(axis, dtype=float)
    t1 = np.cross(a, np.eye(3)[int(np.argmin(abs(a)))])
    t1 /= np.linalg.norm(t1)
    return tuple(map(float, t1)), tuple(map(float, np.cross(a, t1)))


def _parallel(space: AnySpace, axis: Vector) -> tuple[AxisPair, ...]:
    """The axis of B stays parallel to that of A; in the plane it always is."""
    if space.dim == 2:
        return ()
    t1, t2 = normals(axis)
    return (neg(t2), axis), (t1, axis)


def _aligned(space: AnySpace) -> tuple[AxisPair, ...]:
    """The axes of B stay those of A."""
    if space.dim == 2:
        return (((0.0, 1.0), (1.0, 0.0)),)
    x, y, z = identity(3)
    return (z, y), (x, z), (y, x)


_X_ACROSS_Y: AxisPair = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
"""The x axis of A stays perpendicular to the y axis of B."""

LOOP_KINDS: dict[str, LoopKind] = {
    kind.name: kind
    for kind in (
        LoopKind(
            "revolute",
            lambda s, a: Closure(point=True, turns=_parallel(s, a)),
            axis_in=(3,),
            pins=True,
        ),
        LoopKind(
            "prismatic", lambda s, a: Closure(slides=normals(a), turns=_aligned(s)), axis_in=(2, 3)
        ),
        LoopKind(
            "universal",
            lambda s, a: Closure(point=True, turns=(_X_ACROSS_Y,), aligned=False),
            (3,),
            elsewhere="point",
        ),
        LoopKind("spherical", lambda s, a: Closure(point=True), (3,), elsewhere="point", pins=True),
        LoopKind(
            "point",
            lambda s, a: Closure(point=True),
            (2,),
            elsewhere="spherical",
            pins=True,
            symbols=("revolute", ""),
        ),
        LoopKind("fixed", lambda s, a: Closure(point=True, turns=_aligned(s))),
        LoopKind(
            "distance",
            lambda s, a: Closure(distance=True),
            needs_distance=True,
            symbols=("revolute", "spherical"),
        ),
    )
}
"""A further kind is a line here."""
