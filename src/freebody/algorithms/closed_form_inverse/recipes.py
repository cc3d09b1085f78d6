"""Recipes for arms with a spherical wrist or three parallel axes, for such arms seen from the tip,
and for arms with one joint more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from freebody.algorithms.closed_form_inverse.joint_places import (
    JointPlace,
    JointPlaces,
    PlacedBranch,
    known_turn,
    least,
    level,
    line,
    mark,
    numbers,
    turn_by,
    turning,
)
from freebody.algorithms.closed_form_inverse.one_joint import at_angle, at_height
from freebody.algorithms.closed_form_inverse.quartic import QuarticArm
from freebody.algorithms.closed_form_inverse.recipe import ReachCondition, Recipe, WantedMotion
from freebody.algorithms.closed_form_inverse.two_and_three_joints import (
    JointPair,
    ThreeJointArm,
    Wrist,
)
from freebody.algorithms.joint_lines import off_axis
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.elementary import Scalar, less, maximum, sqrt, where
from freebody.spatial import dot, sub


@dataclass(frozen=True, eq=False)
class PositionByThree(Recipe):
    """The recipe that places the point c with three joints, whatever the orientation is."""

    arm: ThreeJointArm | QuarticArm
    screws: Sequence[Screw]
    c: Array

    @property
    def title(self) -> str:
        return "position by three joints (Pieper 1968)"

    @property
    def by_quartic(self) -> bool:
        return self.arm.by_quartic

    def reached(self, X: WantedMotion) -> ReachCondition:
        return self.screws, self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        c = numbers(self.c)
        return self.arm.ways(c, X.point(c))


@dataclass(frozen=True, eq=False)
class OrientationByThree(Recipe):
    """The recipe that turns the frame into its orientation with three turning joints."""

    wrist: Wrist

    @property
    def title(self) -> str:
        return "orientation by three revolute joints (a spherical triangle)"

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        return self.wrist.ways(X.direction)


@dataclass(frozen=True, eq=False)
class SphericalWrist(Recipe):
    """Six joints, the last three through one point c, which the first three bring to its place
    (Pieper 1968)."""

    arm: ThreeJointArm | QuarticArm
    wrist: Wrist
    screws: Sequence[Screw]
    c: Array

    @property
    def title(self) -> str:
        return "spherical wrist (Pieper 1968; Paden and Kahan's subproblems)"

    @property
    def by_quartic(self) -> bool:
        return self.arm.by_quartic

    def reached(self, X: WantedMotion) -> ReachCondition:
        return self.screws[:3], self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        c = numbers(self.c)
        found = []
        for arm, clear in self.arm.ways(c, X.point(c)):
            for hand, also in self.wrist.ways(X.without(first=arm).direction):
                found.append(((*arm, *hand), least(clear, also)))
        return found


@dataclass(frozen=True, eq=False)
class ThreeParallel(Recipe):
    """Six turning joints, axes 2, 3, 4 parallel, 5 and 6 through one point c (Hawkins 2013; Elias
    and Wen 2022).

    Joint 1 puts c at its height along axis 2, joints 5 and 6 turn what is left into a motion in the
    plane across it, and the three parallel joints make that motion.
    """

    screws: Sequence[Screw]
    c: Array
    length: float

    @property
    def title(self) -> str:
        return "three parallel axes (Elias and Wen 2022)"

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        s2, s3, s4 = self.screws[1:4]
        l1, l2, _, l4 = map(line, self.screws[:4])
        height = float(self.c @ s2.w)
        home, across = numbers(s4.p), mark(l4)
        found = []
        for back1, clear1 in at_height(l1, X.point(numbers(self.c)), l2.w, height, self.length):
            x1 = back1.back()  # e1⁻¹ X c is at the height
            for (x5, x6), rest, clear56 in self._level(X, x1):
                goal = rest.point(home)
                seen = rest.direction(across)
                for (x2, x3), clear in JointPair(s2, s3, self.length).ways(home, goal):
                    left = x3.back().direction(x2.back().direction(seen))
                    x4 = known_turn(l4, left, across)
                    clear = least(clear1, clear56, clear)
                    found.append(((x1, x2, x3, x4, x5, x6), clear))
        return found

    def _level(
        self, X: WantedMotion, x1: JointPlace
    ) -> list[tuple[JointPlaces, WantedMotion, Scalar]]:
        """The places of joints 5 and 6 for which the rest of the motion turns about the parallel
        axes of joints 2 to 4, with that rest and the margin of each branch's existence."""
        l2, l5, l6 = map(line, (self.screws[1], self.screws[4], self.screws[5].undone()))
        aim = X.inverse().direction(x1.direction(l2.w))  # R6ᵀ R5ᵀ w
        found = []
        for back5, clear5 in at_angle(l5, l2.w, l6.w, aim):
            turned = back5.direction(l2.w)  # R5ᵀ w, which joint 6 turns back into aim
            back6, clear6 = turning(l6, turned, aim)
            last = (back5.back(), back6.back())
            found.append((last, X.without(first=(x1,), last=last), least(clear5, clear6)))
        return found

    def gaps(self, X: WantedMotion, x: Scalar) -> list[Scalar]:
        """Squares of two distances with joint 1 at x (rad): from the height at which the axes are
        parallel to the arm's plane, and from the ring that two joints reach in that plane."""
        s2, s3, s4 = self.screws[1:4]
        l2, upper, fore = line(s2), off_axis(s2, s3.p), off_axis(s3, s4.p)
        found = []
        for _, rest, clear in self._level(X, turn_by(line(self.screws[0]), x)):
            goal = rest.point(numbers(s4.p))
            lift = dot(sub(goal, numbers(s4.p)), l2.w)
            way = level(l2, goal)
            far = sqrt(dot(way, way))
            beside = maximum(maximum(far - (upper + fore), abs(upper - fore) - far), 0.0)
            # an orientation that cannot be had with joint 1 there is as far as can be
            none = where(less(clear, -1e-9), 1e6 * self.length, 0.0)
            found.append(lift * lift + beside * beside + none)
        return found


@dataclass(frozen=True, eq=False)
class SeenFromTip(Recipe):
    """A recipe for the joints in reverse order: X⁻¹ for X, motions the other way."""

    forward: Recipe

    @property
    def title(self) -> str:
        return self.forward.title + ", seen from the tip"

    @property
    def by_quartic(self) -> bool:
        return self.forward.by_quartic

    def reached(self, X: WantedMotion) -> ReachCondition | None:
        return self.forward.reached(X.inverse())

    def gaps(self, X: WantedMotion, x: Scalar) -> list[Scalar] | None:
        return self.forward.gaps(X.inverse(), x)

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        return [
            (tuple(x.back() for x in places[::-1]), clear)
            for places, clear in self.forward.ways(X.inverse())
        ]


@dataclass(frozen=True, eq=False)
class OneJointHeld(Recipe):
    """A recipe for an arm of one joint more than the recipe solves, such as an arm of seven joints:
    the first or last joint of the chain is held at a given position."""

    rest: Recipe
    screw: Screw
    first: bool

    @property
    def title(self) -> str:
        return f"{self.rest.title}, the {'first' if self.first else 'last'} joint given"

    @property
    def by_quartic(self) -> bool:
        return self.rest.by_quartic

    def reached(self, X: WantedMotion) -> ReachCondition | None:
        found = self.rest.reached(X)
        if found is None or self.first is isinstance(self.rest, SeenFromTip):
            return None
        screws, c, point = found  # the joint that may stand anywhere is the first of them
        return (self.screw, *screws), c, point

    def reached_at(self, X: WantedMotion, x: Scalar) -> ReachCondition | None:
        """The condition under which a target is within reach, with the joint at x."""
        held = (turn_by(line(self.screw), x),)
        return self.rest.reached(X.without(first=held) if self.first else X.without(last=held))

    def at(self, X: WantedMotion, x: Scalar) -> list[PlacedBranch]:
        """The branches with the joint at x (rad, m)."""
        held = (turn_by(line(self.screw), x),)
        if self.first:
            return [((*held, *p), clear) for p, clear in self.rest.ways(X.without(first=held))]
        return [((*p, *held), clear) for p, clear in self.rest.ways(X.without(last=held))]

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
        """Branches of the other joints, the held one at zero."""
        return self.at(X, 0.0)
