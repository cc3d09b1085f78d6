"""Spherical joint: a quaternion w, x, y, z for position, the angular velocity in the child's axes
for rate."""

from __future__ import annotations

from freebody.model.joints import quaternions as turn
from freebody.model.joints.kind import Column, JointKind, Primitive
from freebody.model.joints.revolute import TURNING
from freebody.spatial import AnySpace, Matrix, Space, Vector, add, identity, scale

QUATERNION = ("quat_w", "quat_x", "quat_y", "quat_z")


class Pivoting(Primitive):
    """Rotation by a quaternion, which is normalised on the way."""

    nq = 4
    nv = 3

    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        assert isinstance(space, Space)  # the kind's `dimensions` keep it out of the plane
        return space.quaternion(q), space.zero

    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        return tuple((unit, space.zero) for unit in identity(3))

    def position_rates(self, space: AnySpace, q: Vector, rates: Vector) -> Vector:
        (w, x, y, z), (a, b, c) = q, rates
        # half the quaternion product q (0, ω)
        twice = (
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        )
        return tuple(0.5 * rate for rate in twice)

    def moved(self, space: AnySpace, q: Vector, v: Vector) -> Vector:
        return turn.unit(turn.product(q, turn.exponential(v)))

    def between(self, space: AnySpace, q0: Vector, q1: Vector) -> Vector:
        return turn.logarithm(turn.product(turn.conjugate(q0), q1))

    def dexp_inverse(self, space: AnySpace, x: Vector, v: Vector) -> Vector:
        once = space.cross(x, v)
        return add(v, scale(0.5, once), scale(1.0 / 12.0, space.cross(x, once)))


PIVOTING = Pivoting()
_X, _Y, _Z = identity(3)
YAW_PITCH_ROLL = (("yaw", TURNING, _Z), ("pitch", TURNING, _Y), ("roll", TURNING, _X))
"""Three turns in a row: R = R_z R_y R_x."""


class Spherical(JointKind):
    """Spherical joint, which turns about its centre in any way."""

    name = "spherical"
    nq = 4
    nv = 3
    position_names = QUATERNION
    velocity_names = ("wx", "wy", "wz")
    quaternion = 0
    by_angles = YAW_PITCH_ROLL
    angular = (True, True, True)
    mark = "sphere"
    solids = ()

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((PIVOTING, axis),)
