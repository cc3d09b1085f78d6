"""Three joints of which two leave neither a height nor a distance alone: the third by a polynomial
of degree four (Pieper 1968).

With y = e1⁻¹ p = e2 e3 c, three conditions are linear in y, and one is left that says how joint 3
stands: a polynomial of degree two in its sine and cosine. So these are where a conic meets the unit
circle; of the conics through the same points one falls apart into two lines, each of which meets
the circle twice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from freebody.algorithms.closed_form_inverse.joint_places import (
    JointBranch,
    JointPlace,
    JointPlaces,
    PlacedBranch,
    bent,
    least,
    line,
    numbers,
    onto,
    turn_by,
)
from freebody.algorithms.joint_lines import nearest_points
from freebody.algorithms.screws import Screw
from freebody.elementary import Scalar, absolute, less, less_equal, maximum, minimum, sqrt, where
from freebody.spatial import Vector, add, dot, scale, sub, times

_NODES = tuple(2.0 * math.pi * k / 5 for k in range(5))
_HALVINGS = 30
_REFINED = 3
_POLISHED = 4
_FLAT = 1e-9
"""The least part of second degree (relative)."""


@dataclass(frozen=True, eq=False)
class QuarticArm:
    """Three joints with e1 e2 e3 c = p, of which the first two are not parallel."""

    s1: Screw
    s2: Screw
    s3: Screw
    length: float
    by_quartic: ClassVar[bool] = True

    def ways(self, c: Vector, p: Vector) -> list[PlacedBranch]:
        """Branches of three joints that bring the point c to p, each with the places of all
        three."""
        l1, l2 = line(self.s1), line(self.s2)
        found = []
        for third, clear in self._third(c, p):
            carried = third.point(c)
            y, _ = self._between(carried, p)
            second, free2 = onto(l2, carried, y, self.length)
            first, free1 = onto(l1, y, p, self.length)
            places: JointPlaces = (first, second, third)
            found.append((places, least(clear, free1, free2)))
        return found

    def _third(self, c: Vector, p: Vector) -> list[JointBranch]:
        l3, turning = line(self.s3), self.s3.turning
        values: list[Scalar] = []
        for x in _NODES:  # a slide by length tan(x / 2) is one of sines and cosines too
            place = turn_by(l3, x if turning else self.length * math.tan(x / 2))
            _, gap = self._between(place.point(c), p)
            values.append(gap if turning else gap * math.cos(x / 2) ** 4)
        found = []
        for sine, cosine, clear in zeros(tuple(values)):
            place = JointPlace(l3, sine, cosine)
            if not turning:
                place = JointPlace(l3, shift=self.length * sine / maximum(1.0 + cosine, 1e-12))
            found.append((place, clear))
        return found

    def _between(self, c3: Vector, p: Vector) -> tuple[Vector, Scalar]:
        """The point y between joints 2 and 3 that solves the linear conditions, and by how much the
        square of its distance from joint 1 exceeds the required one."""
        s1, s2 = self.s1, self.s2
        if s1.turning and s2.turning:
            o1, o2 = nearest_points(s1, s2)
            inverse = np.linalg.inv(np.stack([s1.w, s2.w, o2 - o1]))
            first = sub(p, numbers(o1))
            squares = _square(first) - _square(sub(c3, numbers(o2))) + float(o2 @ o2 - o1 @ o1)
            known = (dot(p, numbers(s1.w)), dot(c3, numbers(s2.w)), 0.5 * squares)
            y = times(tuple(map(numbers, inverse)), known)
            return y, _square(sub(y, numbers(o1))) - _square(first)
        turning, sliding = (s1, s2) if s1.turning else (s2, s1)
        on_circle, on_line = (p, c3) if s1.turning else (c3, p)
        far = dot(sub(on_circle, on_line), numbers(turning.w)) * (1.0 / float(s1.w @ s2.w))
        y = add(on_line, scale(far, numbers(sliding.w)))
        foot = numbers(turning.p)
        return y, _square(sub(y, foot)) - _square(sub(on_circle, foot))


def _square(v: Vector) -> Scalar:
    return dot(v, v)


def zeros(values: Vector) -> list[tuple[Scalar, Scalar, Scalar]]:
    """(sine, cosine, how clear) of the four angles at which a polynomial of degree two in sine and
    cosine is zero, given at five even angles from 0 on."""
    a0 = 0.2 * sum(values[1:], start=values[0])
    (a1, b1), (a2, b2) = (
        tuple(
            0.4 * dot(values, tuple(part(k * x) for x in _NODES)) for part in (math.cos, math.sin)
        )
        for k in (1, 2)
    )
    most = absolute(a0) + absolute(a1) + absolute(b1)
    size = maximum(sqrt(a2 * a2 + b2 * b2), maximum(_FLAT * most, 1e-300))
    s, c = _half(b2 / size, a2 / size)
    # turned by that angle, and divided: cos 2x + p cos x + q sin x + a
    p, q, a = (a1 * c + b1 * s) / size, (b1 * c - a1 * s) / size, a0 / size
    found = []
    for base, sine, cosine, clear in _on_lines(p, q, a):
        line_s, line_c = base
        for sign in (1.0, -1.0):
            y = line_s * cosine + sign * line_c * sine, line_c * cosine - sign * line_s * sine
            x = y[0] * c + y[1] * s, y[1] * c - y[0] * s
            sine_x, cosine_x, apart = _polished(*x, clear, (a0, a1, b1, a2, b2))
            # two zeros that are about to merge may lie on different lines
            found.append((sine_x, cosine_x, where(less(0.0, clear), minimum(clear, apart), clear)))
    return found


def _half(sine: Scalar, cosine: Scalar) -> tuple[Scalar, Scalar]:
    """Sine and cosine of half an angle that is given by its sine and cosine; the cosine is not
    negative."""
    larger = sqrt(0.5 * (1.0 + absolute(cosine)))
    smaller = 0.5 * absolute(sine) / larger
    acute = less_equal(0.0, cosine)
    sign = where(less(sine, 0.0), -1.0, 1.0)
    return sign * where(acute, smaller, larger), where(acute, larger, smaller)


def _on_lines(
    p: Scalar, q: Scalar, a: Scalar
) -> list[tuple[tuple[Scalar, Scalar], Scalar, Scalar, Scalar]]:
    """For each of two lines (sine and cosine of the direction of its foot, and sine, cosine and
    clearance of the angle to either side) where cos 2x + p cos x + q sin x + a is zero.

    c² - s² + p c + q s + a + λ (c² + s² - 1) falls apart into real lines at a root of a cubic
    between -1, where that is -2 p², and 1, where it is 2 q².
    """

    def cubic(x: Scalar) -> Scalar:
        return p * p * (x - 1.0) + q * q * (x + 1.0) + 4.0 * (x - a) * (x * x - 1.0)

    low: Scalar = -1.0 + 0.0 * a
    high: Scalar = 1.0 + 0.0 * a
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = less(0.0, cubic(middle))
        low, high = where(above, low, middle), where(above, middle, high)
    x = 0.5 * (low + high)
    for _ in range(_REFINED):
        slope = p * p + q * q + 4.0 * (x * x - 1.0) + 8.0 * x * (x - a)
        step = cubic(x) * slope / maximum(slope * slope, 1e-300)
        x = minimum(maximum(x - step, low), high)
    u, v = sqrt(maximum(1.0 + x, 0.0)), sqrt(maximum(1.0 - x, 0.0))
    half_p, half_q = _over(p, u), _over(q, v)
    from_p = sqrt(maximum(half_p * half_p + x - a, 0.0))
    from_q = sqrt(maximum(half_q * half_q + a - x, 0.0))
    narrow = 0.1
    P = where(less(u, narrow), where(less(p, 0.0), -from_q, from_q), half_p)
    Q = where(less(v, narrow), where(less(q, 0.0), -from_p, from_p), half_q)
    unit = math.sqrt(0.5)
    found = []
    for sign in (1.0, -1.0):
        cosine = unit * (-P - sign * Q)
        found.append(((-sign * unit * v, unit * u), *bent(1.0 - cosine, 1.0 + cosine, cosine)))
    return found


def _over(x: Scalar, y: Scalar) -> Scalar:
    return 0.5 * x / maximum(y, 1e-30)


def _polished(
    s: Scalar, c: Scalar, clear: Scalar, coefficients: tuple[Scalar, ...]
) -> tuple[Scalar, Scalar, Scalar]:
    """A zero of the polynomial improved by a few short Newton steps, none where no zero exists
    since they would lead to another one; and roughly the squared distance to the next zero, by
    slope and curvature."""
    a0, a1, b1, a2, b2 = coefficients
    slope: Scalar = 0.0
    double_c, double_s = 1.0, 0.0
    for _ in range(_POLISHED):
        double_c, double_s = c * c - s * s, 2.0 * s * c
        value = a0 + a1 * c + b1 * s + a2 * double_c + b2 * double_s
        slope = b1 * c - a1 * s + 2.0 * (b2 * double_c - a2 * double_s)
        step = where(less(0.0, clear), -value * slope / maximum(slope * slope, 1e-300), 0.0)
        step = minimum(maximum(step, -0.2), 0.2)
        c, s = c - step * s, s + step * c
        size = 1.0 / sqrt(c * c + s * s)
        c, s = c * size, s * size
    curved = a1 * c + b1 * s + 4.0 * (a2 * double_c + b2 * double_s)
    return s, c, slope * slope / maximum(slope * slope + curved * curved, 1e-300)
