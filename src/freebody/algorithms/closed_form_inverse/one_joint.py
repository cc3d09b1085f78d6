"""One joint at a time: where it brings a point to a height or a distance, a direction to an angle.

Subproblems 3 and 4 of Paden and Kahan (Murray, Li, Sastry 1994, section 3.3; Elias and Wen,
IK-Geo, 2022), by products of differences, so that little is lost where an arm is straight or
folded.
"""

from __future__ import annotations

import math

from freebody.algorithms.closed_form_inverse.joint_places import (
    AxisLine,
    JointBranch,
    JointPlace,
    at_pair,
    bent,
    either,
    least,
    level,
)
from freebody.elementary import Scalar, less, maximum, sqrt, where
from freebody.spatial import Vector, dot, scale, sub, times


def at_height(
    l: AxisLine, c: Vector, n: Vector, height: Scalar, length: float
) -> list[JointBranch]:
    """Branches of a joint after which n · c = height, n constant."""
    if not l.turning:
        return [(JointPlace(l, shift=(height - dot(c, n)) / dot(l.w, n)), 1.0)]
    arm = level(l, c)
    base, radius = at_pair(l, dot(times(l.around, arm), n), dot(arm, n))
    wanted = height - dot(sub(c, arm), n)
    radius = maximum(radius, 1e-12 * length)  # a point on the axis keeps its height
    cosine = wanted / radius
    sine, cosine, clear = bent((radius - wanted) / radius, (radius + wanted) / radius, cosine)
    return either(l, base, sine, cosine, _of_size(clear, radius * (1.0 / length)))


def _of_size(clear: Scalar, size: Scalar) -> Scalar:
    """The margin of a branch's existence where a point moves on a circle of this relative radius; 0
    where the point is on the axis, where a quotient by the radius says nothing."""
    return least(where(less(size, 1e-9), 0.0, clear), size)


def at_chord(l: AxisLine, c: Vector, o: Vector, square: Scalar, length: float) -> list[JointBranch]:
    """Branches of a joint after which c is seen from o, looking along the axis, at a distance of
    this square."""
    u, v = level(l, c), level(l, o)
    aa, bb = dot(u, u), dot(v, v)
    base, size = at_pair(l, dot(times(l.around, u), v), dot(u, v))
    size = maximum(size, 1e-24 * length**2)
    a, b = sqrt(aa), sqrt(bb)
    above = (square - (a - b) * (a - b)) / (2.0 * size)
    below = ((a + b) * (a + b) - square) / (2.0 * size)
    sine, cosine, clear = bent(above, below, (aa + bb - square) / (2.0 * size))
    return either(l, base, sine, cosine, _of_size(clear, size * (1.0 / length**2)))


def at_distance(
    l: AxisLine, c: Vector, o: Vector, square: Scalar, length: float
) -> list[JointBranch]:
    """Branches of a joint after which c is at a distance of this square from o."""
    way = sub(o, c)
    if l.turning:
        along = dot(way, l.w)
        return at_chord(l, c, o, square - along * along, length)
    across = sub(way, scale(dot(way, l.w), l.w))
    left = square - dot(across, across)
    middle, half = dot(way, l.w), sqrt(maximum(left, 0.0))
    clear = left * (1.0 / length**2)
    return [
        (JointPlace(l, shift=middle + half), clear),
        (JointPlace(l, shift=middle - half), clear),
    ]


def at_angle(l: AxisLine, v: Vector, u: Vector, aim: Vector) -> list[JointBranch]:
    """Branches of a joint after which the constant direction v makes the angle with the constant u
    that the unit vector aim makes with it."""
    cosine_u, cosine_v = dot(l.w, u), dot(l.w, v)
    sines = math.sqrt((1.0 - cosine_u**2) * (1.0 - cosine_v**2))
    alpha, beta = math.acos(cosine_u), math.acos(cosine_v)
    away, towards = sub(aim, u), tuple(a + b for a, b in zip(aim, u, strict=True))
    # cos(α - β) - cos θ and cos θ - cos(α + β), for the angle θ between aim and u
    above = 0.5 * dot(away, away) - _small(1.0 - math.cos(alpha - beta))
    below = 0.5 * dot(towards, towards) - _small(1.0 + math.cos(alpha + beta))
    cosine = (dot(aim, u) - cosine_u * cosine_v) * (1.0 / sines)
    base, _ = at_pair(l, dot(u, times(l.around, v)), dot(u, times(l.across, v)))
    return either(l, base, *bent(above * (1.0 / sines), below * (1.0 / sines), cosine))


def _small(x: float) -> float:
    return 0.0 if abs(x) < 1e-15 else x
