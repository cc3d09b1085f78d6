"""Recipes for inverse kinematics: from a displacement X = e1 … en to the places of all joints,
branch by branch.

X = T T(0)⁻¹ is given as what it does to a point and to a direction. Each recipe lists as many
branches for every target, with how clear it is that a branch exists; whoever calls verifies them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from freebody.algorithms.closed_form_inverse.joint_places import JointPlaces, PlacedBranch
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.spatial import Matrix, Vector, add, times, transposed


@dataclass(frozen=True)
class WantedMotion:
    """X: rotation R (3, 3) and shift p (3), of scalars, between known motions of joints."""

    R: Matrix
    p: Vector
    before: JointPlaces = ()
    """Motions done last: X is these, the first of them outermost, times the rest."""
    after: JointPlaces = ()
    """Motions that are done before this one."""

    def point(self, x: Vector) -> Vector:
        """The point to which X takes a point."""
        for place in reversed(self.after):
            x = place.point(x)
        x = add(times(self.R, x), self.p)
        for place in reversed(self.before):
            x = place.point(x)
        return x

    def direction(self, v: Vector) -> Vector:
        """A direction, turned by the motion."""
        for place in reversed(self.after):
            v = place.direction(v)
        v = times(self.R, v)
        for place in reversed(self.before):
            v = place.direction(v)
        return v

    def without(self, first: JointPlaces = (), last: JointPlaces = ()) -> WantedMotion:
        """e⁻¹ X for the first joints e, X e⁻¹ for the last ones."""
        before = (*(x.back() for x in reversed(first)), *self.before)
        after = (*self.after, *(x.back() for x in reversed(last)))
        return WantedMotion(self.R, self.p, before, after)

    def inverse(self) -> WantedMotion:
        """The opposite motion X⁻¹."""
        back = transposed(self.R)
        return WantedMotion(
            back,
            tuple(-x for x in times(back, self.p)),
            tuple(x.back() for x in reversed(self.after)),
            tuple(x.back() for x in reversed(self.before)),
        )


ReachCondition = tuple[Sequence[Screw], Array, Vector]
"""(screws, c, point): as far as the screws leave c (3,) from the point, the target is out of
reach."""


class Recipe(ABC):
    """A closed form for some joints in a row."""

    @abstractmethod
    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        """Branches of the joints that bring the tip to a wanted motion."""

    @property
    @abstractmethod
    def title(self) -> str:
        """The recipe in words, with its source."""

    @property
    def by_quartic(self) -> bool:
        """Whether the recipe finds one of its joints from a polynomial of degree four."""
        return False

    def reached(self, X: WantedMotion) -> ReachCondition | None:
        """The condition under which a target is within reach, that some screws bring one point to
        another; None where reach depends on something else."""
        return None

    def gaps(self, X: WantedMotion, x: Scalar) -> list[Scalar] | None:
        """Squares of the distances (m²) between the wanted motion X and what the other joints can
        reach, branch by branch, with the deciding joint at x (rad); None where `reached` gives the
        condition."""
        return None
