"""Revolute joint: turns about a constant axis (6.16-6.21)."""

from __future__ import annotations

from freebody.model.joints.kind import Column, JointKind, JointWords, Primitive
from freebody.spatial import AnySpace, Matrix, Vector


class Turning(Primitive):
    """Rotation by q[0] (rad) about the axis."""

    nq = nv = 1
    turns = True
    words = JointWords("revolute", "angle", "torque", "bearing", "rad", "N m")

    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        return space.rotation(axis, q[0]), space.zero

    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        return ((axis, space.zero),)


TURNING = Turning()


class Revolute(JointKind):
    """Revolute, usually with limits."""

    name = "revolute"
    motion = Turning
    nq = nv = 1
    angular = (True,)
    coordinate = "theta"
    letter = "R"
    needs_axis = True
    dimensions = (2, 3)

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((TURNING, axis),)

    def axis_size(self, dim: int) -> int:
        return 1 if dim == 2 else dim

    def axis_in_space(self, axis: tuple[float, ...]) -> tuple[float, ...]:
        return (0.0, 0.0, axis[0])


class Continuous(Revolute):
    """Revolute without limits; the angle is one number, not a point on a circle."""

    name = "continuous"
    letter = ""
    ranged = False
