"""Helical joint: a screw, which turns about a constant axis and advances along it by its pitch for
each radian (Featherstone 2008, table 4.1; Lynch, Park 2017, section 2.2.1)."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.elementary import Scalar
from freebody.model.joints.kind import Column, JointKind, JointWords, Own, Primitive, Solid
from freebody.spatial import AnySpace, Matrix, Vector, scale


@dataclass(frozen=True)
class Screwing(Primitive):
    """Rotation by q[0] (rad) about the axis, and translation by pitch times q[0] (m) along it."""

    advance: Scalar
    """Pitch of the screw, m/rad."""
    nq = nv = 1
    turns = slides = True
    words = JointWords("helical", "angle", "torque", "nut", "rad", "N m")

    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        return space.rotation(axis, q[0]), scale(self.advance * q[0], axis)

    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        return ((axis, scale(self.advance, axis)),)


class Helical(JointKind):
    """Helical; a right-handed thread has a pitch above 0."""

    name = "helical"
    motion = Screwing
    nq = nv = 1
    numbers = (Own("pitch", "m/rad", "pitch (advance for each radian)"),)
    angular = (True,)
    coordinate = "theta"
    solids = (Solid(0.55, 2.6), Solid(1.3, 0.8, sides=6, moves=False))
    needs_axis = True

    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        (pitch,) = numbers
        return ((Screwing(pitch), axis),)
