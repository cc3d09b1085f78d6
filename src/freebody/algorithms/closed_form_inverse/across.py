"""The recipe of arms whose turning axes are all parallel: planar arms and SCARA robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import (
    JointPlace,
    PlacedBranch,
    known_turn,
    line,
    mark,
    numbers,
    onto,
    turn_by,
)
from freebody.algorithms.closed_form_inverse.recipe import ReachCondition, Recipe, WantedMotion
from freebody.algorithms.closed_form_inverse.two_and_three_joints import JointPair
from freebody.algorithms.joint_lines import off_axis
from freebody.algorithms.screws import SAME, Screw
from freebody.arrays import Array
from freebody.spatial import dot, scale, sub


@dataclass(frozen=True, eq=False)
class Across(Recipe):
    """A recipe of one to three joints across `normal` at places `across` of the chain, and perhaps
    a lift along it: planar arms and SCARA robots; c: the frame's origin at zero."""

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
        source = ", notes (2.14), (2.15)" if word.startswith("RR") else ""
        return f"planar {word}{lifted}{source}"

    def reached(self, X: WantedMotion) -> ReachCondition:
        if len(self.across) == 3:
            first, last = self.screws[self.across[0]], self.screws[self.across[-1]]
            if last.turning:
                rest = [s for s in self.screws if s is not last]
                return rest, last.p, X.point(numbers(last.p))
            if first.turning:
                rest = [s for s in self.screws[::-1] if s is not first]
                return rest, first.p, X.inverse().point(numbers(first.p))
        return self.screws, self.c, X.point(numbers(self.c))

    def ways(self, X: WantedMotion) -> list[PlacedBranch]:
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

    def _level(self, s: Sequence[Screw], X: WantedMotion) -> list[PlacedBranch]:
        c = numbers(self.c)
        if len(s) == 1:
            return [self._one(s[0], X)]
        if len(s) == 2:
            return JointPair(s[0], s[1], self.length).ways(c, X.point(c))
        if s[2].turning:
            return self._last_turns(s, X)
        if s[0].turning:
            back = self._last_turns([x.undone() for x in s[::-1]], X.inverse())
            return [(tuple(x.back() for x in places[::-1]), clear) for places, clear in back]
        return [self._turn_between_slides(s, X)]

    def _one(self, s: Screw, X: WantedMotion) -> PlacedBranch:
        l, c = line(s), numbers(self.c)
        if s.turning and off_axis(s, self.c) <= SAME * self.length:  # the frame is on the axis
            return (known_turn(l, X.direction(mark(l)), mark(l)),), 1.0
        place, clear = onto(l, c, X.point(c), self.length)
        return (place,), clear

    def _last_turns(self, s: Sequence[Screw], X: WantedMotion) -> list[PlacedBranch]:
        """Branches of three turning joints: the first two bring a point of the third joint's axis
        to its place, the third turns the rest."""
        l3 = line(s[2])
        seen, home = X.direction(mark(l3)), numbers(s[2].p)
        found = []
        for (x1, x2), clear in JointPair(s[0], s[1], self.length).ways(home, X.point(home)):
            left = x2.back().direction(x1.back().direction(seen))
            found.append(((x1, x2, known_turn(l3, left, mark(l3))), clear))
        return found

    def _turn_between_slides(self, s: Sequence[Screw], X: WantedMotion) -> PlacedBranch:
        """The branch of a turning joint between two slides: the turn follows from the wanted
        rotation, the two shifts from linear equations."""
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
