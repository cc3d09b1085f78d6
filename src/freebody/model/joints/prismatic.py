"""Prismatic joint: slides along a constant axis (6.23-6.27)."""

from __future__ import annotations

from freebody.model.joints.kind import Column, JointKind, JointWords, Primitive, Solid
from freebody.spatial import AnySpace, Matrix, Vector, identity, scale


class Sliding(Primitive):
    """Translation by q[0] (m) along the axis."""

    nq = nv = 1
    slides = True
    advance = 1.0
    words = JointWords("prismatic", "displacement", "force", "guide", "m", "N")

    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        return identity(space.dim), scale(q[0], axis)

    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        return ((space.zero_angular, axis),)


SLIDING = Sliding()


class Prismatic(JointKind):
    """Prismatic joint, which slides along its axis."""

    name = "prismatic"
    motion = Sliding
    nq = nv = 1
    angular = (False,)
    coordinate = "d"
    letter = "P"
    axis_letter = "u"
    mark = "slider"
    solids = (Solid(1.15, 1.5, sides=4, moves=False),)
    needs_axis = True
    dimensions = (2, 3)

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((SLIDING, axis),)

    def axis_in_space(self, axis: tuple[float, ...]) -> tuple[float, ...]:
        return (*axis, 0.0)
