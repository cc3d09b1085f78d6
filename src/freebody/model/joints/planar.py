"""Planar joint: x, y and θ and their rates, in the parent's axes. It is two slides and a turn
without mass between."""

from __future__ import annotations

from freebody.model.joints.kind import JointKind, Primitive
from freebody.model.joints.prismatic import SLIDING
from freebody.model.joints.revolute import TURNING
from freebody.spatial import AnySpace, Vector


class Planar(JointKind):
    """Moves in the xy plane of the joint's frame and turns about its z; in the plane it frees a
    body altogether."""

    name = "planar"
    nq = nv = 3
    position_names = velocity_names = ("x", "y", "theta")
    angular = (False, False, True)
    holds = False
    mark = ""
    solids = ()
    dimensions = (2, 3)

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        x, y = ((1.0, 0.0, 0.0)[: space.dim], (0.0, 1.0, 0.0)[: space.dim])
        z = (0.0, 0.0, 1.0) if space.dim == 3 else (1.0,)
        return ((SLIDING, x), (SLIDING, y), (TURNING, z))
