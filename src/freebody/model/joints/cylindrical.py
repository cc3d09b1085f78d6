"""Cylindrical joint: turns about a constant axis and slides along it, one as free as the other."""

from __future__ import annotations

from freebody.model.joints.kind import JointKind, Primitive, Solid
from freebody.model.joints.prismatic import SLIDING
from freebody.model.joints.revolute import TURNING
from freebody.spatial import AnySpace, Vector


class Cylindrical(JointKind):
    """Cylindrical joint: turns about its axis and slides along it."""

    name = "cylindrical"
    nq = nv = 2
    position_names = velocity_names = ("theta", "d")
    angular = (True, False)
    mark = "slider"
    solids = (Solid(0.5, 2.6), Solid(1.1, 1.5, moves=False))
    needs_axis = True

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((TURNING, axis), (SLIDING, axis))
