"""Two and three joints that bring a point to a point, three that turn: e1 e2 c = p, e1 e2 e3 c = p
and R4 R5 R6 = R (Pieper 1968).

With y = e2 e3 c = e1⁻¹ p, the point y lies on the circle (or line) of p about joint 1 and on that
of c about joint 2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import (
    AxisLine,
    JointBranch,
    PlacedBranch,
    known_turn,
    least,
    level,
    line,
    mark,
    numbers,
    onto,
    turning,
)
from freebody.algorithms.closed_form_inverse.one_joint import (
    at_angle,
    at_chord,
    at_distance,
    at_height,
)
from freebody.algorithms.closed_form_inverse.quartic import QuarticArm
from freebody.algorithms.joint_lines import (
    can_meet,
    changes_distance,
    changes_height,
    kept_centre,
    kept_height,
    parallel,
    perpendicular,
)
from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.elementary import Scalar, less, maximum, sqrt, where
from freebody.spatial import Vector, add, dot, scale, sub


@dataclass(frozen=True, eq=False)
class JointPair:
    """Solves for the rotations or shifts e1, e2 of two joints that take the point c to p: e1 e2 c =
    p."""

    s1: Screw
    s2: Screw
    length: float

    def ways(self, c: Vector, p: Vector) -> list[PlacedBranch]:
        """Branches of a pair of joints, each with the places of both."""
        l1, l2 = line(self.s1), line(self.s2)
        if self.s1.turning and self.s2.turning and parallel(self.s1.w, self.s2.w):
            chord = level(l1, p)
            second = at_chord(l2, c, l1.p, dot(chord, chord), self.length)
            return [self._closed(l1, x2, x2[0].point(c), p) for x2 in second]
        ways = []
        for y, clear in self._meeting_points(l1, l2, c, p):
            place, free = onto(l2, c, y, self.length)
            ways.append(self._closed(l1, (place, least(clear, free)), y, p))
        return ways

    def _closed(self, l1: AxisLine, x2: JointBranch, y: Vector, p: Vector) -> PlacedBranch:
        place, free = onto(l1, y, p, self.length)
        return (place, x2[0]), least(x2[1], free)

    def _meeting_points(
        self, l1: AxisLine, l2: AxisLine, c: Vector, p: Vector
    ) -> list[tuple[Vector, Scalar]]:
        s1, s2 = self.s1, self.s2
        if s1.turning and s2.turning:
            return self._on_both_circles(c, p)
        if s1.turning != s2.turning:
            turn, slide = (s1, s2) if s1.turning else (s2, s1)
            on_circle, on_line = (p, c) if s1.turning else (c, p)
            lt = line(turn)
            if perpendicular(s1.w, s2.w):
                n = np.cross(turn.w, slide.w)
                return self._on_circle(turn, lt, on_circle, n, dot(sub(on_line, lt.p), numbers(n)))
            far = dot(sub(on_circle, on_line), lt.w) / float(s1.w @ s2.w)
            return [(add(on_line, scale(far, line(slide).w)), 1.0)]
        m = s2.w - (s2.w @ s1.w) * s1.w
        far = dot(sub(p, c), numbers(m / (m @ m)))
        return [(add(c, scale(far, l2.w)), 1.0)]

    def _on_both_circles(self, c: Vector, p: Vector) -> list[tuple[Vector, Scalar]]:
        """The points where the circles of p and c meet, taken on the smaller of them: the radius of
        the other would be the root of a difference of squares."""
        l1, l2 = line(self.s1), line(self.s2)
        first = self._on_circle(self.s1, l1, p, self.s2.w, dot(sub(c, l1.p), l2.w))
        second = self._on_circle(self.s2, l2, c, self.s1.w, dot(sub(p, l2.p), l1.w))[::-1]
        arms = level(l1, p), level(l2, c)
        smaller = less(dot(arms[1], arms[1]), dot(arms[0], arms[0]))
        return [
            (tuple(where(smaller, b, a) for a, b in zip(ya, yb, strict=True)), clear)
            for (ya, clear), (yb, _) in zip(first, second, strict=True)
        ]

    def _on_circle(
        self, s: Screw, l: AxisLine, point: Vector, n: Array, height: Scalar
    ) -> list[tuple[Vector, Scalar]]:
        """The points where the circle of a point about a screw meets the plane n · (y - screw.p) =
        height."""
        across = n - (n @ s.w) * s.w
        sine = float(np.sqrt(across @ across))
        m, side = numbers(across / sine), numbers(np.cross(s.w, across / sine))
        lift = dot(sub(point, l.p), l.w)
        far = (height - lift * float(s.w @ n)) * (1.0 / sine)
        arm = level(l, point)
        left = dot(arm, arm) - far * far
        middle = add(l.p, scale(lift, l.w), scale(far, m))
        step = scale(sqrt(maximum(left, 0.0)), side)
        clear = left * (1.0 / self.length**2)
        return [(add(middle, step), clear), (sub(middle, step), clear)]


@dataclass(frozen=True, eq=False)
class ThreeJointArm:
    """Three joints with e1 e2 e3 c = p; `third` gives the places of joint 3 for p, from conditions
    that joints 1 and 2 cannot change."""

    third: Callable[[Vector, Vector], list[JointBranch]]
    pair: JointPair
    reverse: bool = False
    """Whether the joints are those of the arm seen from its point, where c and p change places."""
    by_quartic: ClassVar[bool] = False

    def ways(self, c: Vector, p: Vector) -> list[PlacedBranch]:
        """Branches of three joints that bring the point c to p, each with the places of all
        three."""
        if self.reverse:
            c, p = p, c
        ways = []
        for third, clear in self.third(c, p):
            for places, also in self.pair.ways(third.point(c), p):
                whole = (*places, third)
                if self.reverse:
                    whole = tuple(x.back() for x in whole[::-1])
                ways.append((whole, least(clear, also)))
        return ways


def arm(screws: Sequence[Screw], c: Array, length: float) -> ThreeJointArm | QuarticArm | None:
    """The three joints that bring c (3,) to a point; None where they are no arm."""
    s1, s2, s3 = screws
    if not can_meet(s1, s2, length) or not can_meet(s2, s3, length):
        return None
    if not changes_distance(s3, c, length):
        return None
    l1, l3 = line(s1), line(s3)
    normal = kept_height(s2, s3)
    if normal is not None and changes_height(s1, _moved_point(s1, length), normal, length):
        n, height = numbers(normal), float(c @ normal)

        def first(p: Vector, c: Vector) -> list[JointBranch]:
            return at_height(l1, p, n, height, length)

        return ThreeJointArm(first, JointPair(s3.undone(), s2.undone(), length), reverse=True)
    normal = kept_height(s1, s2)
    if normal is not None:
        n = numbers(normal)
        fits = changes_height(s3, c, normal, length)
        return (
            ThreeJointArm(
                lambda c, p: at_height(l3, c, n, dot(p, n), length), JointPair(s1, s2, length)
            )
            if fits
            else None
        )
    centre = shoulder = kept_centre(s1, s2, length)
    if centre is not None and changes_distance(s3, centre, length):
        o = numbers(centre)

        def by_distance(c: Vector, p: Vector) -> list[JointBranch]:
            way = sub(p, o)
            return at_distance(l3, c, o, dot(way, way), length)

        return ThreeJointArm(by_distance, JointPair(s1, s2, length))
    centre = kept_centre(s2, s3, length)
    if centre is not None and changes_distance(s1, centre, length):
        o = numbers(centre)
        away = float((c - centre) @ (c - centre))
        return ThreeJointArm(
            lambda p, c: at_distance(l1, p, o, away, length),
            JointPair(s3.undone(), s2.undone(), length),
            reverse=True,
        )
    if shoulder is not None:  # all three axes meet
        return None
    return QuarticArm(s1, s2, s3, length)


def _moved_point(s: Screw, length: float) -> Array:
    """A point off the axis of joint s, which the joint moves as it would move a target."""
    other = np.eye(3)[int(np.argmin(np.abs(s.w)))]
    return s.p + length * np.asarray(np.cross(s.w, other), dtype=float)


@dataclass(frozen=True, eq=False)
class Wrist:
    """Three turning joints with R4 R5 R6 = R."""

    screws: Sequence[Screw]

    def ways(self, turned: Callable[[Vector], Vector]) -> list[PlacedBranch]:
        """Branches of a wrist's three joints, each with the places of all three; turned: the
        function that applies R to a vector."""
        l4, l5, l6 = map(line, self.screws)
        aim, across = turned(l6.w), mark(l6)
        seen = turned(across)
        ways = []
        for x5, clear in at_angle(l5, l6.w, l4.w, aim):
            x4, free = turning(l4, x5.direction(l6.w), aim)
            rest = x5.back().direction(x4.back().direction(seen))
            ways.append(((x4, x5, known_turn(l6, rest, across)), least(clear, free)))
        return ways
