"""Building blocks for the values of one body's quantities."""

from __future__ import annotations

from typing import Any

from freebody.algorithms.kinematics import BodyMotions
from freebody.algorithms.rnea import Recursion
from freebody.scalars.trig import Trig
from freebody.spatial import Matrix, Vector, add, neg, scale, times
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.setting import Setting


class BodyValues:
    """Body i of a derivation, for any tree or closed chain with solved reactions; vectors in the
    printed axes."""

    def __init__(self, s: Setting, i: int, reactions: SolvedReactions):
        self.s, self.i, self.reactions = s, i, reactions

    @property
    def n(self) -> int:
        """Number of the body in symbols."""
        return self.s.numbers[self.i]

    @property
    def is_whole(self) -> bool:
        """Whether the body has a single mass, not several parts."""
        return len(self.s.tree.bodies[self.i].masses) < 2

    @property
    def motion(self) -> BodyMotions:
        """The motion of all bodies, in their own axes."""
        return self.s.motion

    @property
    def joint(self) -> tuple[Matrix, Vector]:
        """The rotation from the body's axes to those of the preceding body, and its origin
        there."""
        R, p = self.motion.joints[self.i]
        return R, p

    @property
    def start(self) -> Vector:
        """The acceleration of the ground."""
        return self.s.tree.space.zero

    @property
    def centre_acceleration(self) -> Vector:
        """The acceleration of the body's centre of mass."""
        return self.s.centre_acceleration(self.i)

    @property
    def force(self) -> Vector:
        """The force on the body at its joint."""
        return self.reactions.f[self.i]

    @property
    def moment(self) -> Vector:
        """The moment on the body at its joint."""
        return self.reactions.n[self.i]

    @property
    def inertia_force(self) -> Vector:
        """The body's mass times the acceleration of its centre of mass."""
        return scale(self.s.mass(self.i), self.centre_acceleration)

    @property
    def inertia_moment(self) -> Vector:
        """The rate of the body's angular momentum about its centre of mass."""
        I, w, wd = self.s.inertia(self.i), self.motion.w[self.i], self.motion.wd[self.i]
        if self.s.planar:
            return scale(I, wd)
        return add(times(I, wd), self.s.tree.space.cross(w, times(I, w)))

    # ------------------------------------------------------------ shapes
    def element(self, x: Any) -> Trig:
        """A number as polynomial of the ring."""
        return self.s.symbols.element(x)

    def vector(self, v: Vector) -> tuple[Trig, ...]:
        """A vector of polynomials from one of scalars."""
        return tuple(map(self.element, v))

    def matrix(self, rows: Any) -> tuple[tuple[Trig, ...], ...]:
        """A matrix of polynomials from one of scalars."""
        return tuple(map(self.vector, rows))

    def axes(self, v: Vector) -> tuple[Trig, ...]:
        """Components of a vector in body axes, converted to the printed axes."""
        return self.vector(self.s.axes(self.i, v))

    def angular(self, v: Vector) -> Any:
        """An angular vector: three components in space, a scalar in the plane."""
        return self.element(v[0]) if self.s.planar else self.vector(v)


class RecursionValues(BodyValues):
    """Body i of a derivation, with motion and forces from one run of the recursive Newton-Euler
    algorithm; gravity is a force or part of the base's acceleration."""

    def __init__(self, s: Setting, i: int, record: Recursion, accelerated: bool):
        self.s, self.i, self.record, self.accelerated = s, i, record, accelerated

    @property
    def motion(self) -> BodyMotions:
        return self.record.motion

    @property
    def start(self) -> Vector:
        return neg(self.s.tree.gravity) if self.accelerated else self.s.tree.space.zero

    @property
    def centre_acceleration(self) -> Vector:
        own = self.record.vd_com[self.i] or [self.motion.vd[self.i]]
        return self.s.axes(self.i, own[0])

    @property
    def force(self) -> Vector:
        return self.s.axes(self.i, self.record.f[self.i])

    @property
    def moment(self) -> Vector:
        return self.record.n[self.i]

    @property
    def inertia_force(self) -> Vector:
        return self.s.axes(self.i, (self.record.F[self.i] or [self.s.tree.space.zero])[0])

    @property
    def inertia_moment(self) -> Vector:
        return (self.record.N[self.i] or [self.s.tree.space.zero_angular])[0]
