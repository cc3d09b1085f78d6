"""The distance by which a target is out of reach: steps towards the nearest point that screws bring
to it, over scalars."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.algorithms.closed_form_inverse.joint_places import AxisLine, JointPlace, turn_by
from freebody.elementary import Scalar, absolute, less, maximum, minimum, where
from freebody.spatial import Vector, dot, scale, space, sub

_FLAT = 1e-10
"""The least curvature of a step."""
_LONGEST = 0.5
"""The longest step (rad, lengths)."""


def closer(
    lines: Sequence[AxisLine], c: Vector, x: Vector, damping: Scalar, goal: Vector
) -> tuple[Vector, Scalar, Scalar]:
    """(x, damping, square of the distance left) after one damped Newton step of the joint positions
    x that brings the point c nearer to the goal; x as it was where the step does not. Lengths are
    relative to the arm's."""
    steps = _newton(lines, c, x, damping, goal)
    trial = tuple(a + b for a, b in zip(x, steps, strict=True))
    before, after = (_square(lines, c, y, goal) for y in (x, trial))
    better = less(after, before)
    kept = tuple(where(better, a, b) for a, b in zip(trial, x, strict=True))
    return kept, where(better, 0.1 * damping, 4.0 * damping), minimum(after, before)


def _square(lines: Sequence[AxisLine], c: Vector, x: Vector, goal: Vector) -> Scalar:
    for l, value in zip(reversed(lines), reversed(x), strict=True):
        c = turn_by(l, value).point(c)
    way = sub(c, goal)
    return dot(way, way)


def _newton(
    lines: Sequence[AxisLine], c: Vector, x: Vector, damping: Scalar, goal: Vector
) -> Vector:
    """The damped Newton step of the joint positions, from the second derivatives of half the
    squared distance to the goal."""
    places = [turn_by(l, value) for l, value in zip(lines, x, strict=True)]
    stages, point = _speeds(places, c)
    n, error = len(lines), sub(point, goal)
    gradient: list[Scalar] = []
    hessian: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    for i, (place, speeds) in enumerate(zip(places, stages, strict=True)):
        gradient.append(dot(error, speeds[0]))
        for j, speed in enumerate(speeds, start=i):
            curved: Scalar = 0.0
            if place.line.turning:  # joint i turns the speeds of what it carries
                curved = dot(error, space.cross(place.line.w, speed))
            hessian[j][i] = dot(speeds[0], speed) + curved
        hessian[i][i] = hessian[i][i] + damping
        error = place.back().direction(error)
    step = _solved(hessian, [-g for g in gradient])
    size: Scalar = 0.0
    for s in step:
        size = maximum(size, absolute(s))
    return scale(_LONGEST / maximum(size, _LONGEST), step)


def _speeds(places: Sequence[JointPlace], c: Vector) -> tuple[list[list[Vector]], Vector]:
    """For each joint the velocities of the point c per unit rate of that joint and of those beyond
    it, in the axes of the body that carries the joint; and the point's position."""
    stages: list[list[Vector]] = []
    carried: list[Vector] = []
    for place in reversed(places):
        l = place.line
        c = place.point(c)
        own = space.cross(l.w, sub(c, l.p)) if l.turning else l.w
        carried = [own, *(place.direction(v) for v in carried)]
        stages.insert(0, carried)
    return stages, c


def _solved(A: list[list[Scalar]], b: list[Scalar]) -> Vector:
    """x of A x = b by the factors L D Lᵀ of the lower triangle, D no less than `_FLAT`: where A is
    not positive a step downhill nevertheless."""
    n = len(b)
    L: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    D: list[Scalar] = []
    y: list[Scalar] = []
    for i in range(n):
        for j in range(i):
            known = sum((L[i][k] * D[k] * L[j][k] for k in range(j)), start=0.0)
            L[i][j] = (A[i][j] - known) / D[j]
        known = sum((L[i][k] * L[i][k] * D[k] for k in range(i)), start=0.0)
        D.append(maximum(A[i][i] - known, _FLAT))
        y.append(b[i] - sum((L[i][k] * y[k] for k in range(i)), start=0.0))
    x: list[Scalar] = [0.0] * n
    for i in reversed(range(n)):
        x[i] = y[i] / D[i] - sum((L[k][i] * x[k] for k in range(i + 1, n)), start=0.0)
    return tuple(x)
