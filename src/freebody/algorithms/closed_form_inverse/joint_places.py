"""The place of a joint over scalars: the turn as a sine and a cosine, or the shift.

So that no angle is taken before the end, where it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

from freebody.algorithms.screws import Screw
from freebody.arrays import Array
from freebody.elementary import Scalar, atan2, cos, equal, less, maximum, minimum, sin, sqrt, where
from freebody.spatial import Matrix, Vector, add, dot, scale, space, sub, times

_ROUNDING = 1e-15
_ON_AXIS = 1e-11
"""A point as near to an axis as this (relative to the arm's length) is on it."""


@dataclass(frozen=True)
class AxisLine:
    """A screw's numbers: unit axis w through the point p, turning or sliding."""

    turning: bool
    w: tuple[float, ...]
    p: tuple[float, ...]
    rest: Scalar
    """The angle taken where any would do."""
    along: Matrix
    """Matrix of the part of a vector along the axis: w wᵀ."""
    across: Matrix
    """Matrix of the part of a vector across the axis: 1 - w wᵀ."""
    around: Matrix
    """Matrix of the cross product w × r."""


def line(screw: Screw) -> AxisLine:
    """A screw in numbers that fold: what is 0 or 1 but for rounding is so exactly."""
    w = tuple(_clean(float(x), 1.0) for x in screw.w)
    p = tuple(_clean(float(x), max(map(abs, screw.p))) for x in screw.p)
    along = tuple(tuple(a * b for b in w) for a in w)
    unit = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    across = tuple(sub(e, row) for e, row in zip(unit, along, strict=True))
    return AxisLine(screw.turning, w, p, screw.rest, along, across, space.skew(w))


def _clean(x: float, size: float) -> float:
    near = float(round(x))
    return near if abs(x - near) <= _ROUNDING * size else x


def level(l: AxisLine, point: Vector) -> Vector:
    """The part at right angles to the axis of the way from it to a point; of a slide, of the
    point."""
    return times(l.across, sub(point, l.p))


@dataclass(frozen=True)
class JointPlace:
    """A joint at a sine and a cosine, or at a shift (the sine is 0 and the cosine 1 there)."""

    line: AxisLine
    sine: Scalar = 0.0
    cosine: Scalar = 1.0
    shift: Scalar = 0.0
    free: Scalar = 0.0
    """1 where any angle would do."""

    def direction(self, v: Vector) -> Vector:
        """A vector, turned by the joint's rotation."""
        l = self.line
        if not l.turning:
            return v
        turned = add(scale(self.cosine, times(l.across, v)), scale(self.sine, times(l.around, v)))
        return add(times(l.along, v), turned)

    def point(self, x: Vector) -> Vector:
        """The point to which the joint takes a point."""
        l = self.line
        if not l.turning:
            return add(x, scale(self.shift, l.w))
        return add(l.p, self.direction(sub(x, l.p)))

    def back(self) -> JointPlace:
        """The motion undone: the same joint on the other side."""
        return JointPlace(self.line, -self.sine, self.cosine, -self.shift, self.free)

    def value(self) -> Scalar:
        """The angle (rad, -π to π) or the shift (m)."""
        return atan2(self.sine, self.cosine) if self.line.turning else self.shift


JointBranch = tuple[JointPlace, Scalar]
"""A place, and how clear it is that it exists: the least, in relative terms, by which what it was
found from lies within its bounds; 0 where two places merge or any would do, negative where there is
none."""


JointPlaces = tuple[JointPlace, ...]
PlacedBranch = tuple[JointPlaces, Scalar]
"""Joints' places, in the chain's order, and how clear it is that they exist."""


def numbers(v: Array) -> tuple[float, ...]:
    """A constant vector as scalars."""
    return tuple(map(float, v))


def at_pair(l: AxisLine, y: Scalar, x: Scalar) -> tuple[JointPlace, Scalar]:
    """The turn whose sine and cosine are to each other as y to x, 0 where both are 0; and their
    size."""
    square = x * x + y * y
    none = equal(square, 0.0)
    size = sqrt(where(none, 1.0, square))
    return JointPlace(l, y / size, where(none, 1.0, x / size)), where(none, 0.0, size)


def _aimed(l: AxisLine, u: Vector, v: Vector, length: float) -> JointBranch:
    """The turn about axis l that brings u (at right angles to the axis) nearest to v; the angle at
    rest where u or v is nearly along the axis."""
    y, x, beside = dot(times(l.around, u), v), dot(u, v), times(l.across, v)
    shorter = minimum(dot(u, u), dot(beside, beside))
    free = less(shorter, (_ON_AXIS * length) ** 2)
    size = sqrt(where(free, 1.0, x * x + y * y))
    sine, cosine = where(free, sin(l.rest), y / size), where(free, cos(l.rest), x / size)
    return JointPlace(l, sine, cosine, free=free), where(free, 0.0, size * (1.0 / length**2))


def either(
    l: AxisLine, base: JointPlace, sine: Scalar, cosine: Scalar, clear: Scalar
) -> list[JointBranch]:
    """Two branches of a joint: the base's turn and a further angle (given by sine and cosine), in
    either direction."""
    s, c = base.sine, base.cosine
    ss, sc, cs, cc = s * sine, s * cosine, c * sine, c * cosine
    return [(JointPlace(l, sc + cs, cc - ss), clear), (JointPlace(l, sc - cs, cc + ss), clear)]


def bent(above: Scalar, below: Scalar, cosine: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(sine, cosine, margin of existence) of the angle with 1 - cosine = above and 1 + cosine =
    below, both given free of cancellation; the nearest angle where above or below is negative."""
    square = above * below
    return sqrt(maximum(square, 0.0)), minimum(maximum(cosine, -1.0), 1.0), square


def onto(l: AxisLine, a: Vector, b: Vector, length: float) -> JointBranch:
    """The place that brings a point a as near to b as the joint can."""
    if not l.turning:
        return JointPlace(l, shift=dot(sub(b, a), l.w)), 1.0
    return _aimed(l, level(l, a), sub(b, l.p), length)


def turning(l: AxisLine, a: Vector, b: Vector) -> JointBranch:
    """The turn that brings the direction a as near to b as it can."""
    return _aimed(l, times(l.across, a), b, 1.0)


def known_turn(l: AxisLine, of_mark: Vector, mark: Vector) -> JointPlace:
    """The turn of a rotation about the axis, from what it makes of a unit vector across it."""
    return JointPlace(l, dot(times(l.around, mark), of_mark), dot(mark, of_mark))


def mark(l: AxisLine) -> Vector:
    """A unit vector across an axis, along a coordinate axis where it can be."""
    least = min(range(3), key=lambda k: abs(l.w[k]))
    v = l.across[least]
    size = float(sum(x * x for x in v)) ** 0.5
    return tuple(x / size for x in v)


def turn_by(l: AxisLine, x: Scalar) -> JointPlace:
    """The joint at an angle or shift that is given."""
    return JointPlace(l, sin(x), cos(x)) if l.turning else JointPlace(l, shift=x)


def least(*clear: Scalar) -> Scalar:
    """The smallest of several margins of existence, which is that of the whole branch."""
    found = clear[0]
    for x in clear[1:]:
        found = minimum(found, x)
    return found
