"""Fixed joint: no motion. Assembly lumps what it carries into the body before; it never reaches an
algorithm."""

from __future__ import annotations

from freebody.model.joints.kind import JointKind, Primitive
from freebody.spatial import AnySpace, Vector


class Fixed(JointKind):
    """Fixed joint, which does not move."""

    name = "fixed"
    nq = nv = 0
    position_names = velocity_names = ()
    angular = ()
    mark = ""
    solids = ()
    dimensions = (2, 3)

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ()
