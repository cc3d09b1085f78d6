"""The steps of time-optimal motion along a path as straight-line arithmetic: what limits the speed
in one interval of the path, and how the speeds at its two ends depend on each other.

Bobrow, Dubowsky and Gibson 1985: along a path q(s), with x = ṡ² and u = s̈, every limit on torque
or acceleration is linear, lo <= a u + b x <= hi. Over an interval of length Δ with constant u, x
is linear in s and u = (y - x) / (2 Δ), where y is x at the interval's end. With limits at both
ends (Pham and Pham 2018, "interpolation scheme"), what is allowed is a polygon of pairs (x, y).
The pass backward finds the range of x at the interval's start from which the range of y at its
end can be reached, and the pass forward the largest y from a given x. Both take one evaluation of
lines, because the corners of the polygon with the largest and smallest x are found beforehand.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import comb, factorial, perm
from sys import float_info
from typing import Any, NamedTuple

from freebody.algorithms.crba import mass_product, only_inertia
from freebody.algorithms.rnea import External, rnea
from freebody.elementary import Scalar, absolute, less, less_equal, maximum, minimum, sqrt, where
from freebody.model.tree import Tree
from freebody.spatial import Vector

Scalars = Sequence[Scalar]
Sloped = tuple[Scalar, Scalar]
"""A value of a line, and its slope."""

LARGEST_ROUNDS, SMALLEST_ROUNDS = 3, 1
"""Steps of Newton's method that one call makes; it ends after finitely many, seldom more. The
smallest x is 0 wherever a robot can stand still."""
_SETTLED = 1e-9
"""The step, relative to the largest x, that is of no account."""

FAR = 1e100
"""A number in place of an infinite bound."""
_MOVING = 1e-3
"""The least y, relative to x, lest a motion brake to rest on the way; not before the end."""
_CLOSE = 1e-9
"""The part of the largest x by which it may be below the smallest."""
_TINY = float_info.min
"""A speed beside which none is lost, and by which one can divide."""
_ASTRAY = 0.5
"""The part of a parabola's bend by which the curve that it stands for may differ from it."""
_NEGLIGIBLE = 1e-12
"""A coefficient beside the other one of its row, whose line is then parallel to an axis."""


class RowsAtEnd(NamedTuple):
    """lo <= a u + b x <= hi at one end of an interval, vectors of one entry a limit."""

    a: Scalars
    b: Scalars
    lo: Scalars
    hi: Scalars


class LimitLines(NamedTuple):
    """One coordinate between low + slope * other and high + slope * other, for each of some
    rows."""

    low: Scalars
    high: Scalars
    slope: Scalars


def polygon(
    start: RowsAtEnd,
    end: RowsAtEnd,
    most_next: Scalar,
    h: Scalar,
    least: Scalar,
    most: Scalar,
) -> tuple[Scalar, ...]:
    """The polygon of pairs (x, y) that are allowed in one interval: (lines of x over y, (high,
    slope) of those of y over x, corners, whether a search has not ended).

    most_next: largest y. h: twice the interval's length in s. least, most: between which the
    largest and the smallest x are looked for. Corners: (largest x, a y that goes with it; the same
    of the smallest x), where the largest is below the smallest if nothing is allowed.
    """
    scale = 1.0 / maximum(most, most_next)
    inside = less(0.0, most_next)
    over_y = [(-FAR, where(inside, 0.0, FAR), where(inside, 1.0 / _MOVING, 0.0))]
    over_x = [(0.0, FAR, where(inside, _MOVING, 0.0))]
    rows = [
        *((h * b - a, a, h * lo, h * hi) for a, b, lo, hi in zip(*start, strict=True)),
        *((-a, h * b + a, h * lo, h * hi) for a, b, lo, hi in zip(*end, strict=True)),
    ]
    for alpha, beta, lo, hi in rows:
        none = _NEGLIGIBLE * _NEGLIGIBLE * scale * (hi - lo)
        x_line = _line(alpha, beta, lo, hi, none)
        y_line = _line(beta, alpha, lo, hi, none)
        over_y.append(x_line)
        over_x.append(y_line)
        only_x = less_equal(absolute(beta), _NEGLIGIBLE * absolute(alpha) + none)
        most = minimum(most, where(only_x, x_line[1], FAR))
        least = maximum(least, where(only_x, x_line[0], -FAR))
        idle = less_equal(absolute(alpha) + absolute(beta), none)
        broken = maximum(less(hi, 0.0), less(0.0, lo))
        most = where(maximum(idle * broken, less(hi, lo)), -FAR, most)  # whatever the speed
    of_x, of_y = (LimitLines(*zip(*lines, strict=True)) for lines in (over_y, over_x))
    *largest, step = _corner(of_y, most, most_next, 1.0)
    *smallest, other = _corner(of_y, least, most_next, -1.0)
    step = maximum(absolute(step), absolute(other))
    goes_on = less(_SETTLED * absolute(largest[0]), step) * less(step, FAR)
    return of_x, of_y[1:], (*largest, *smallest), goes_on


def _line(
    own: Scalar, other: Scalar, lo: Scalar, hi: Scalar, none: Scalar
) -> tuple[Scalar, Scalar, Scalar]:
    """(low, high, slope) that a limit row sets to the coordinate whose coefficient is `own`; no
    bound where the coordinate does not appear in the row."""
    absent = less_equal(absolute(own), _NEGLIGIBLE * absolute(other) + none)
    inverse = 1.0 / where(absent, 1.0, own)
    one, two = lo * inverse, hi * inverse
    return (
        where(absent, -FAR, minimum(one, two)),
        where(absent, FAR, maximum(one, two)),
        where(absent, 0.0, -other * inverse),
    )


def _corner(
    lines: LimitLines, x: Scalar, most_y: Scalar, way: float
) -> tuple[Scalar, Scalar, Scalar]:
    """(x, y, last step): the largest x (way 1), or the smallest (way -1), at which some y is
    allowed, by Newton's method from the outside; the room for y is concave in x. A long step may
    miss by its rounding, and is followed by one back."""
    step: Scalar = 0.0
    for _ in range(LARGEST_ROUNDS if way > 0.0 else SMALLEST_ROUNDS):
        high, high_slope, low, low_slope = _room(lines, x, most_y)
        shut = less(high, low)
        slope = high_slope - low_slope
        opens = less(way * slope, 0.0)  # else there is no room at all
        found = (low - high) / where(opens, slope, -1.0)
        back = where(less(0.0, absolute(step)) * opens, found, 0.0)
        step = where(shut, where(opens, found, -way * FAR), back)
        x = x + step
    high, _, low, _ = _room(lines, x, most_y)
    return x, 0.5 * (high + low) if way > 0.0 else low, step  # there is often no highest y


def _room(lines: LimitLines, x: Scalar, most_y: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """(highest y, its slope, lowest y, its slope) that the limit lines allow at x."""
    zero = 0.0 * x
    tops, bottoms = [(most_y, zero)], [(zero, zero)]
    for least, most, slope in zip(*lines, strict=True):
        tops.append((most + slope * x, slope))
        bottoms.append((least + slope * x, slope))
    return (*balanced(_lower, tops), *balanced(_higher, bottoms))


def _lower(a: Sloped, b: Sloped) -> Sloped:
    return _either(less(b[0], a[0]), b, a)


def _higher(a: Sloped, b: Sloped) -> Sloped:
    return _either(less(a[0], b[0]), b, a)


def _either(truth: Scalar, a: Sloped, b: Sloped) -> Sloped:
    return where(truth, a[0], b[0]), where(truth, a[1], b[1])


def balanced(function: Callable[[Any, Any], Any], values: Sequence[Any]) -> Any:
    """A function of two, such as the minimum, over all values, as a tree of few levels, since a
    processor computes its branches at once."""
    while len(values) > 1:
        pairs = zip(values[::2], values[1::2], strict=False)
        values = [*(function(a, b) for a, b in pairs), *values[len(values) // 2 * 2 :]]
    return values[0]


def backward(after: Scalars, lines: LimitLines, corners: Scalars) -> tuple[Scalar, Scalar]:
    """(smallest, largest) x at the interval's start from which the range `after` of y can be
    reached; NaN if none."""
    top, y_top, bottom, y_bottom = corners
    tolerance = _CLOSE * maximum(top, 0.0)
    y_top, y_bottom = (minimum(maximum(y, after[0]), after[1]) for y in (y_top, y_bottom))
    rows = list(zip(*lines, strict=True))
    top = balanced(minimum, [top, *(most + slope * y_top for _, most, slope in rows)])
    bottom = balanced(maximum, [bottom, *(least + slope * y_bottom for least, _, slope in rows)])
    nothing = less(top + tolerance, bottom)
    gap = 0.0 * top / where(nothing, 0.0, 1.0)  # NaN where nothing
    return minimum(bottom, maximum(top, 0.0)) + gap, maximum(top, 0.0) + gap


def forward(x: Scalar, high: Scalars, slope: Scalars, most: Scalar) -> Scalar:
    """The largest y from x that the lines of y over x and its own limit `most` allow."""
    bounds = [top + rise * x for top, rise in zip(high, slope, strict=True)]
    return maximum(balanced(minimum, [most, *bounds]), 0.0)


def halfway(
    first: Scalars, second: Scalars, x: Scalar, y: Scalar, h: Scalar
) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
    """(q̇, q̈) halfway in an interval; first, second: q' and q'' there."""
    middle, u = 0.5 * (x + y), (y - x) / h
    speed = sqrt(middle)
    return tuple(a * speed for a in first), tuple(
        b * middle + a * u for a, b in zip(first, second, strict=True)
    )


def excess(
    start: RowsAtEnd,
    end: RowsAtEnd,
    middle: Scalars,
    size: Scalars,
    x: Scalar,
    y: Scalar,
    h: Scalar,
) -> tuple[list[Scalar], Scalar, Scalar]:
    """The excess of each row over its limit `size` within an interval (negative below -size), the
    largest of them as a fraction of its limit, and the share of its limit that one row might still
    come to.

    middle: the values halfway; between them and those at the ends a parabola over time: viscous
    friction grows with the square root of the way.
    """
    found, near = [], []
    at_start, at_half, at_end = (sqrt(z) + _TINY for z in (x, 0.5 * (x + y), y))
    passed = 0.5 * (at_start + at_end) / (at_half + at_start)  # of the time
    u = (y - x) / h
    for a, b, lo, hi, c, d, low, high, half, most in zip(*start, *end, middle, size, strict=True):
        first = a * u + b * x - 0.5 * (lo + hi)
        last = c * u + d * y - 0.5 * (low + high)
        peak = _vertex(first, half, last, passed)
        top, bottom = maximum(half, peak), minimum(half, peak)
        found.append(maximum(top - most, 0.0) + minimum(bottom + most, 0.0))
        bend = absolute(half - first - (last - first) * passed)
        values = (absolute(value) for value in (first, last, top, bottom))
        near.append((balanced(maximum, [*values]) + _ASTRAY * bend) / most)
    shares = [absolute(by) / most for by, most in zip(found, size, strict=True)]
    return found, balanced(maximum, [0.0 * x, *shares]), balanced(maximum, [0.0 * x, *near])


def _vertex(first: Scalar, half: Scalar, last: Scalar, passed: Scalar) -> Scalar:
    """The extreme value of the parabola through the values at both ends and at the part `passed` of
    the way, or the value there where the extreme lies outside."""
    lean = last - first
    bend = (half - first - lean * passed) / (passed * passed - passed)
    inside = less(absolute(lean), absolute(bend))
    slope = lean - bend
    return where(inside, first - slope * slope / (4.0 * where(inside, bend, 1.0)), half)


def speed_limit(first: Scalars, velocity: Scalars) -> Scalar:
    """The largest x by the limits of speed; first: q'."""
    shares = (a / most for a, most in zip(first, velocity, strict=True))
    return 1.0 / balanced(maximum, [_TINY, *(share * share for share in shares)])


def top_speed(
    start: Scalars, middle: Scalars, end: Scalars, velocity: Scalars, x: Scalar, y: Scalar
) -> Scalar:
    """The square of the largest joint speed in an interval, as a fraction of its limit; start,
    middle, end: q' at these places, between which it is taken for a parabola, as it is on a cubic
    path."""
    found = []
    rise = y - x
    for a, b, c, most in zip(start, middle, end, velocity, strict=True):
        p0, p1, p2 = a / most, (4.0 * b - 3.0 * a - c) / most, (2.0 * (a + c) - 4.0 * b) / most

        def square(
            u: Scalar, p0: Scalar = p0, p1: Scalar = p1, p2: Scalar = p2
        ) -> Scalar:  # of q̇, u of the way
            rate = p0 + u * (p1 + u * p2)
            return rate * rate * (x + u * rise)

        # its derivative over the rate: a quadratic, whose roots are taken without cancellation
        g0, g1, g2 = 2.0 * p1 * x + p0 * rise, 4.0 * p2 * x + 3.0 * p1 * rise, 5.0 * p2 * rise
        root = sqrt(maximum(g1 * g1 - 4.0 * g0 * g2, 0.0))
        w = -0.5 * where(less(g1, 0.0), g1 - root, g1 + root)
        found += [square(0.0), square(1.0), square(_part(w, g2)), square(_part(g0, w))]
    return balanced(maximum, found)


def _part(above: Scalar, below: Scalar) -> Scalar:
    """The quotient of two numbers, limited to the range from 0 to 1."""
    divides = less(_TINY, absolute(below))
    return minimum(maximum(above / where(divides, below, 1.0), 0.0), 1.0)


def curve_values(powers: Sequence[Scalars], beyond: Scalar) -> list[Scalars]:
    """The value and all derivatives that are not 0 (at least two) of a polynomial at `beyond`;
    powers: its coefficients, highest power first."""
    degree = len(powers) - 1
    found: list[Scalars] = []
    for order in range(max(degree, 2) + 1):
        value: list[Scalar] = [0.0 * beyond] * len(powers[0])
        for k in range(degree, order - 1, -1):
            weight = float(perm(k, order))
            value = [
                v * beyond + weight * c for v, c in zip(value, powers[degree - k], strict=True)
            ]
        found.append(value)
    return found


def timed(derivatives: Sequence[Scalars], speed: Scalar, half: Scalar) -> list[Scalars]:
    """Coefficients of powers of t, lowest first, of q(s(t)), s = speed t + half t² from where the
    derivatives by s are taken."""
    degree, n = len(derivatives) - 1, len(derivatives[0])
    found: list[Scalars] = [[0.0] * n for _ in range(2 * degree + 1)]
    for j, derivative in enumerate(derivatives):
        for k in range(j + 1):
            weight: Scalar = comb(j, k) / factorial(j)
            for factor in [speed] * (j - k) + [half] * k:
                weight = weight * factor
            found[j + k] = [c + weight * d for c, d in zip(found[j + k], derivative, strict=True)]
    return found


def torques_along(
    tree: Tree, q: Vector, first: Vector, second: Vector, external: Sequence[External]
) -> tuple[Vector, Vector, Vector]:
    """(M q', M q'' + C q', what holds the robot still), without friction, along a path q(s): with
    q̇ = q' ṡ and q̈ = q' s̈ + q'' ṡ² the torque is the first times s̈, plus the second times ṡ²,
    plus the third (Bobrow, Dubowsky and Gibson 1985). first, second: q' and q''."""
    weightless = replace(only_inertia(tree), gravity=tree.space.zero)
    still = (0.0,) * tree.nv
    return (
        mass_product(tree, q, first),
        rnea(weightless, q, first, second).tau,
        rnea(tree, q, still, still, external).tau,
    )
