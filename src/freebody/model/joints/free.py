"""Free joint: a body that nothing holds. q = x, y, z, quaternion w, x, y, z; rate = v, ω in the
body's axes."""

from __future__ import annotations

from freebody.model.joints import quaternions as turn
from freebody.model.joints.kind import Column, JointKind, Primitive
from freebody.model.joints.prismatic import SLIDING
from freebody.model.joints.spherical import PIVOTING, QUATERNION, YAW_PITCH_ROLL
from freebody.spatial import AnySpace, Matrix, Vector, add, identity, scale, sub, times, transposed


class Floating(Primitive):
    """Primitive of a free joint: any motion of a rigid body."""

    nq = 7
    nv = 6

    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        R, _ = PIVOTING.pose(space, axis, q[3:])
        return R, q[:3]

    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        units = identity(3)
        return tuple((space.zero, unit) for unit in units) + tuple(
            (unit, space.zero) for unit in units
        )

    def position_rates(self, space: AnySpace, q: Vector, rates: Vector) -> Vector:
        R, _ = self.pose(space, (), q)
        return times(R, rates[:3]) + PIVOTING.position_rates(space, q[3:], rates[3:])

    def moved(self, space: AnySpace, q: Vector, v: Vector) -> Vector:
        R, p = self.pose(space, (), q)
        shift = turn.screw_shift(space, v[3:], v[:3])
        return add(p, times(R, shift)) + PIVOTING.moved(space, q[3:], v[3:])

    def between(self, space: AnySpace, q0: Vector, q1: Vector) -> Vector:
        R, p = self.pose(space, (), q0)
        w = PIVOTING.between(space, q0[3:], q1[3:])
        return turn.unshifted(space, w, times(transposed(R), sub(q1[:3], p))) + w

    def dexp_inverse(self, space: AnySpace, x: Vector, v: Vector) -> Vector:
        def bracket(v: Vector) -> Vector:
            linear = add(space.cross(x[3:], v[:3]), space.cross(x[:3], v[3:]))
            return linear + space.cross(x[3:], v[3:])

        once = bracket(v)
        return add(v, scale(0.5, once), scale(1.0 / 12.0, bracket(once)))

    def bias(self, space: AnySpace, rates: Vector) -> Column:
        # p̈ = d/dt (R v) = R (v̇ + ω × v)
        return space.zero_angular, space.cross(rates[3:], rates[:3])


FLOATING = Floating()
_SLIDES = tuple((name, SLIDING, axis) for name, axis in zip("xyz", identity(3), strict=True))


class Free(JointKind):
    """Free joint of a floating base, with all motions of a body."""

    name = "free"
    nq = 7
    nv = 6
    position_names = ("x", "y", "z", *QUATERNION)
    velocity_names = ("vx", "vy", "vz", "wx", "wy", "wz")
    quaternion = 3
    by_angles = (*_SLIDES, *YAW_PITCH_ROLL)
    angular = (False, False, False, True, True, True)
    holds = False
    mark = ""
    solids = ()

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        return ((FLOATING, axis),)
