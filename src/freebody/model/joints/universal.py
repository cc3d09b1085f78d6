"""Universal joint: turns about x of the joint's frame, then about y as the first turn leaves it
(Hooke's joint). It is two revolute joints without mass between."""

from __future__ import annotations

from freebody.model.joints.kind import JointKind, Primitive, Solid
from freebody.model.joints.revolute import TURNING
from freebody.spatial import AnySpace, Vector


class Universal(JointKind):
    """Universal joint, which turns about two crossing axes."""

    name = "universal"
    nq = nv = 2
    position_names = velocity_names = ("phi", "psi")
    angular = (True, True)
    solids = (Solid(0.5, 1.7, moves=False, along="x"), Solid(0.5, 1.7, along="y"))

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((TURNING, (1.0, 0.0, 0.0)), (TURNING, (0.0, 1.0, 0.0)))
