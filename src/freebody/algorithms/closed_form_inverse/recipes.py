"""Recipes from a displacement X = e1 … en to the places of all joints, branch by branch.

X = T T(0)⁻¹ is given as what it does to a point and to a direction. Each recipe lists as many
branches for every target, with how clear it is that a branch exists; whoever calls verifies them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import (
    JointPlace,
    known_turn,
    least,
    line,
    mark,
    onto,
    turn_by,
    turning,
)
from freebody.algorithms.closed_form_inverse.one_joint import at_angle, at_height
from freebody.algorithms.closed_form_inverse.two_and_three_joints import (
    Arm,
    Pair,
    Places,
    Way,
    Wrist,
    numbers,
)
from freebody.algorithms.joint_lines import off_axis
from freebody.algorithms.screws import SAME, Screw
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.spatial import Matrix, Vector, add, dot, scale, sub, times, transposed


@dataclass(frozen=True)
class WantedMotion:
    """X: rotation R (3, 3) and shift p (3), of scalars, between known motions of joints."""

    R: Matrix
    p: Vector
    before: Places = ()
    """Motions done last: X is these, the first of them outermost, times the rest."""
    after: Places = ()
    """Motions done first."""

    def point(self, x: Vector) -> Vector:
        """Where X takes a point."""
        for place in reversed(self.after):
            x = place.point(x)
        x = add(times(self.R, x), self.p)
        for place in reversed(self.before):
            x = place.point(x)
        return x

    def direction(self, v: Vector) -> Vector:
        """What X makes of a direction."""
        for place in reversed(self.after):
            v = place.direction(v)
        v = times(self.R, v)
        for place in reversed(self.before):
            v = place.direction(v)
        return v

    def without(self, first: Places = (), last: Places = ()) -> WantedMotion:
        """e⁻¹ X for the first joints e, X e⁻¹ for the last ones."""
        before = (*(x.back() for x in reversed(first)), *self.before)
        after = (*self.after, *(x.back() for x in reversed(last)))
        return WantedMotion(self.R, self.p, before, after)

    def inverse(self) -> WantedMotion:
        """X⁻¹."""
        back = transposed(self.R)
        return WantedMotion(
            back,
            tuple(-x for x in times(back, self.p)),
            tuple(x.back() for x in reversed(self.after)),
            tuple(x.back() for x in reversed(self.before)),
        )


Reached = tuple[Sequence[Screw], Array, Vector]
"""(screws, c, point): as far as the screws leave c (3,) from the point, the target is out of
reach."""


class Recipe(ABC):
    """A closed form for some joints in a row."""

    @abstractmethod
    def ways(self, X: WantedMotion) -> list[Way]:
        """The branches."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What is done, with its source."""

    @property
    def of_scalars(self) -> bool:
        """Whether it takes any scalars, and not numbers alone."""
        return True

    def reached(self, X: WantedMotion) -> Reached | None:
        """A target is within reach where screws bring a point to another one: see `Reached`; None
        where that is not what decides."""
        return None


@dataclass(frozen=True, eq=False)
class PositionByThree(Recipe):
    """Three joints that bring the point c to its place."""

    arm: Arm
    screws: Sequence[Screw]
    c: Array

    @property
    def title(self) -> str:
        return "position by three joints (Pieper 1968)"

    @property
    def of_scalars(self) -> bool:
        return not self.arm.by_quartic

    def reached(self, X: WantedMotion) -> Reached:
        return self.screws, self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[Way]:
        c = numbers(self.c)
        return self.arm.ways(c, X.point(c))


@dataclass(frozen=True, eq=False)
class OrientationByThree(Recipe):
    """Three turning joints and the orientation of the frame."""

    wrist: Wrist

    @property
    def title(self) -> str:
        return "orientation by three revolute joints (a spherical triangle)"

    def ways(self, X: WantedMotion) -> list[Way]:
        return self.wrist.ways(X.direction)


@dataclass(frozen=True, eq=False)
class SphericalWrist(Recipe):
    """Six joints, the last three through one point c, which the first three bring to its place
    (Pieper 1968)."""

    arm: Arm
    wrist: Wrist
    screws: Sequence[Screw]
    c: Array

    @property
    def title(self) -> str:
        return "spherical wrist (Pieper 1968; Paden and Kahan's subproblems)"

    @property
    def of_scalars(self) -> bool:
        return not self.arm.by_quartic

    def reached(self, X: WantedMotion) -> Reached:
        return self.screws[:3], self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[Way]:
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

    def ways(self, X: WantedMotion) -> list[Way]:
        s2, s3, s4 = self.screws[1:4]
        l1, l2, _, l4, l5, l6 = map(line, (*self.screws[:5], self.screws[5].undone()))
        height = float(self.c @ s2.w)
        home, across = numbers(s4.p), mark(l4)
        found = []
        for back1, clear1 in at_height(l1, X.point(numbers(self.c)), l2.w, height, self.length):
            x1 = back1.back()  # e1⁻¹ X c is at the height
            aim = X.inverse().direction(x1.direction(l2.w))  # R6ᵀ R5ᵀ w
            for back5, clear5 in at_angle(l5, l2.w, l6.w, aim):
                turned = back5.direction(l2.w)  # R5ᵀ w, which joint 6 turns back into aim
                back6, clear6 = turning(l6, turned, aim)
                x5, x6 = back5.back(), back6.back()
                rest = X.without(first=(x1,), last=(x5, x6))
                goal = rest.point(home)
                seen = rest.direction(across)
                for (x2, x3), clear in Pair(s2, s3, self.length).ways(home, goal):
                    left = x3.back().direction(x2.back().direction(seen))
                    x4 = known_turn(l4, left, across)
                    clear = least(clear1, clear5, clear6, clear)
                    found.append(((x1, x2, x3, x4, x5, x6), clear))
        return found


@dataclass(frozen=True, eq=False)
class SeenFromTip(Recipe):
    """A recipe for the joints in reverse order: X⁻¹ for X, motions the other way."""

    forward: Recipe

    @property
    def title(self) -> str:
        return self.forward.title + ", seen from the tip"

    @property
    def of_scalars(self) -> bool:
        return self.forward.of_scalars

    def reached(self, X: WantedMotion) -> Reached | None:
        return self.forward.reached(X.inverse())

    def ways(self, X: WantedMotion) -> list[Way]:
        return [
            (tuple(x.back() for x in places[::-1]), clear)
            for places, clear in self.forward.ways(X.inverse())
        ]


@dataclass(frozen=True, eq=False)
class Across(Recipe):
    """Up to three joints across `normal` at places `across` of the chain, and perhaps a lift along
    it: planar arms and SCARA robots; c: the frame's origin at zero."""

    screws: Sequence[Screw]
    normal: Array
    across: tuple[int, ...]
    lift: int | None
    c: Array
    length: float

    @property
    def title(self) -> str:
        word = "".join("R" if self.screws[i].turning else "P" for i in self.across)
        lifted = " and a lift" if self.lift is not None else ""
        source = " (2.14, 2.15)" if word.startswith("RR") else ""
        return f"{word} across parallel axes{lifted}{source}"

    def reached(self, X: WantedMotion) -> Reached:
        if len(self.across) == 3:
            first, last = self.screws[self.across[0]], self.screws[self.across[-1]]
            if last.turning:
                rest = [s for s in self.screws if s is not last]
                return rest, last.p, X.point(numbers(last.p))
            if first.turning:
                rest = [s for s in self.screws[::-1] if s is not first]
                return rest, first.p, X.inverse().point(numbers(first.p))
        return self.screws, self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[Way]:
        s = [self.screws[i] for i in self.across]
        lifted: JointPlace | None = None
        if self.lift is not None:
            lift, c = self.screws[self.lift], numbers(self.c)
            rise = dot(sub(X.point(c), c), numbers(self.normal))
            lifted = turn_by(line(lift), rise * float(self.normal @ lift.w))
            X = X.without(first=(lifted,))
        found = []
        for places, clear in self._level(s, X):
            whole = dict(zip(self.across, places, strict=True))
            if lifted is not None and self.lift is not None:
                whole[self.lift] = lifted
            found.append((tuple(whole[k] for k in range(len(whole))), clear))
        return found

    def _level(self, s: Sequence[Screw], X: WantedMotion) -> list[Way]:
        c = numbers(self.c)
        if len(s) == 1:
            return [self._one(s[0], X)]
        if len(s) == 2:
            return Pair(s[0], s[1], self.length).ways(c, X.point(c))
        if s[2].turning:
            return self._last_turns(s, X)
        if s[0].turning:
            back = self._last_turns([x.undone() for x in s[::-1]], X.inverse())
            return [(tuple(x.back() for x in places[::-1]), clear) for places, clear in back]
        return [self._turn_between_slides(s, X)]

    def _one(self, s: Screw, X: WantedMotion) -> Way:
        l, c = line(s), numbers(self.c)
        if s.turning and off_axis(s, self.c) <= SAME * self.length:  # the frame is on the axis
            return (known_turn(l, X.direction(mark(l)), mark(l)),), 1.0
        place, clear = onto(l, c, X.point(c), self.length)
        return (place,), clear

    def _last_turns(self, s: Sequence[Screw], X: WantedMotion) -> list[Way]:
        """The first two joints bring a point of the third's axis home, the third turns the rest."""
        l3 = line(s[2])
        seen, home = X.direction(mark(l3)), numbers(s[2].p)
        found = []
        for (x1, x2), clear in Pair(s[0], s[1], self.length).ways(home, X.point(home)):
            left = x2.back().direction(x1.back().direction(seen))
            found.append(((x1, x2, known_turn(l3, left, mark(l3))), clear))
        return found

    def _turn_between_slides(self, s: Sequence[Screw], X: WantedMotion) -> Way:
        """P R P: the turn is given; what the two slides must do is linear."""
        l1, l2, l3 = map(line, s)
        x2 = known_turn(l2, X.direction(mark(l2)), mark(l2))
        second, zero = x2.direction(l3.w), (0.0, 0.0, 0.0)
        way = sub(X.point(zero), x2.point(zero))
        m = numbers(np.cross(s[0].w, s[1].w))
        across = dot(second, m)
        x3 = dot(way, m) / across
        x1 = dot(sub(way, scale(x3, second)), l1.w)
        places = (JointPlace(l1, shift=x1), x2, JointPlace(l3, shift=x3))
        return places, across * across


@dataclass(frozen=True, eq=False)
class OneJointHeld(Recipe):
    """A joint more than a recipe has, the first or the last of the chain, at a position that is
    given: the redundancy of an arm of seven joints."""

    rest: Recipe
    screw: Screw
    first: bool

    @property
    def title(self) -> str:
        return f"{self.rest.title}, the {'first' if self.first else 'last'} joint given"

    @property
    def of_scalars(self) -> bool:
        return self.rest.of_scalars

    def reached(self, X: WantedMotion) -> Reached | None:
        found = self.rest.reached(X)
        if found is None or self.first is isinstance(self.rest, SeenFromTip):
            return None
        screws, c, point = found  # the joint that may stand anywhere is the first of them
        return (self.screw, *screws), c, point

    def reached_at(self, X: WantedMotion, x: Scalar) -> Reached | None:
        """The same with the joint at x."""
        held = (turn_by(line(self.screw), x),)
        return self.rest.reached(X.without(first=held) if self.first else X.without(last=held))

    def at(self, X: WantedMotion, x: Scalar) -> list[Way]:
        """The branches with the joint at x (rad, m)."""
        held = (turn_by(line(self.screw), x),)
        if self.first:
            return [((*held, *p), clear) for p, clear in self.rest.ways(X.without(first=held))]
        return [((*p, *held), clear) for p, clear in self.rest.ways(X.without(last=held))]

    def ways(self, X: WantedMotion) -> list[Way]:
        """At zero."""
        return self.at(X, 0.0)
