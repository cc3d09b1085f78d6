"""Solutions as they are returned: angles next to a reference and within limits where that can be,
those that exist first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, pi

from freebody.algorithms.closed_form_inverse.joint_places import JointPlace
from freebody.algorithms.closed_form_inverse.solve import REACHED, Branches
from freebody.elementary import (
    Scalar,
    absolute,
    atan2,
    cos,
    equal,
    less,
    less_equal,
    maximum,
    sin,
    sqrt,
    where,
)
from freebody.spatial import Matrix, Vector, dot, identity, plus, product, scale, space, transposed

CLEAR = 1e-9
"""Relative margin by which a branch must clear its bounds, to be a solution for sure or none."""

ORTHOGONAL = 1e-6
"""How far a target's rotation may be from orthogonal."""

LOOSE = 1e-9
"""How far (rad, m) a position within the limits may be from them, by rounding."""


@dataclass(frozen=True)
class JointRanges:
    """The ranges of q: lower and upper limits (nq), infinite where there are none, and which
    entries are angles that repeat."""

    low: Sequence[float]
    high: Sequence[float]
    repeats: Sequence[bool]

    def inside(self, k: int, x: Scalar) -> Scalar:
        """1 where the joint position x is within the limits of entry k of q, else 0; always 1 for
        an angle whose limits are a turn or more apart, since it is `wrapped` into them."""
        low, high = self.low[k], self.high[k]
        flag: Scalar = 1.0
        if self.repeats[k] and high - low >= 2 * pi:
            return flag
        if isfinite(low):
            flag = flag * less_equal(low - LOOSE, x)
        if isfinite(high):
            flag = flag * less_equal(x, high + LOOSE)
        return flag

    def wrapped(self, k: int, x: Scalar) -> Scalar:
        """The angle x, or x a whole turn farther where that leads into the limits of entry k of q;
        x is within half a turn of a position inside them."""
        low, high = self.low[k], self.high[k]
        narrow = high - low < 2 * pi
        if isfinite(low):
            beyond, turned = less(x, low - LOOSE), x + 2 * pi
            fits = less_equal(turned, high + LOOSE) if narrow else 1.0
            x = where(beyond * fits, turned, x)
        if isfinite(high):
            beyond, turned = less(high + LOOSE, x), x - 2 * pi
            fits = less_equal(low - LOOSE, turned) if narrow else 1.0
            x = where(beyond * fits, turned, x)
        return x


def solutions(
    arm: Branches,
    known: JointRanges,
    R: Matrix,
    p: Vector,
    reference: Vector,
    rest: Vector,
    held: Scalar | None = None,
    in_front: bool = True,
) -> tuple[list[Vector], Vector, Vector, Scalar]:
    """(q of each branch, residuals, 1 for each branch within the joints' limits, the number of
    solutions, -1 where that number is not sure).

    R, p: in space; reference: q next to which angles are wrapped; rest: q of the joints that do
    not move the frame. in_front: whether solutions stand before the branches there are none of.
    """
    R, sure = orthogonal(R)
    for k, x in enumerate(reference):
        if known.repeats[k]:
            sure = sure * _between(known.low[k], x, known.high[k])
    found: list[tuple[Vector, Scalar]] = []
    for places, clear in arm.ways(R, p, held):
        square = arm.miss(places, R, p)
        valid = less_equal(square, REACHED**2)
        sure = sure * where(valid, less(CLEAR, clear), less(clear, -CLEAR))
        q = list(rest)
        for k, place in zip(map(int, arm.chain.index), places, strict=True):
            q[k] = _coordinate(arm, known, k, place, reference[k], held)
        within: Scalar = 1.0
        for k, x in enumerate(q):
            within = within * known.inside(k, x)
        found.append(((*q, sqrt(square), within), valid))
    rows, count = (_in_front if in_front else _in_place)(found)
    q = [row[:-2] for row in rows]
    residual = tuple(row[-2] for row in rows)
    within = tuple(row[-1] for row in rows)
    return q, residual, within, where(sure, count, -1.0)


def orthogonal(R: Matrix) -> tuple[Matrix, Scalar]:
    """The rotation next to R, by two steps of Newton; 1 where R is one but for `ORTHOGONAL`, else
    0."""
    off: Scalar = 0.0
    three = tuple(scale(3.0, row) for row in identity(3))
    turned = R
    for step in range(2):
        gram = product(transposed(turned), turned)
        if step == 0:
            for row, one in zip(gram, identity(3), strict=True):
                for a, b in zip(row, one, strict=True):
                    off = maximum(off, absolute(a - b))
        half = plus(three, tuple(scale(-1.0, row) for row in gram))
        turned = tuple(scale(0.5, row) for row in product(turned, half))
    x, y, z = transposed(R)
    right = less(0.0, dot(space.cross(x, y), z))
    return turned, less(off, 0.5 * ORTHOGONAL) * right


def _between(low: float, x: Scalar, high: float) -> Scalar:
    flag: Scalar = less_equal(low, x) if isfinite(low) else 1.0
    return flag * (less_equal(x, high) if isfinite(high) else 1.0)


def _coordinate(
    arm: Branches,
    known: JointRanges,
    k: int,
    place: JointPlace,
    reference: Scalar,
    held: Scalar | None,
) -> Scalar:
    """Entry k of q that puts its joint at a given place; an angle is taken next to the reference
    and within the limits where that is possible."""
    (at,) = (i for i, index in enumerate(arm.chain.index) if index == k)
    if not known.repeats[k] or (held is not None and arm.held == k):
        return arm.coordinate(at, place.value(), held)
    ratio, offset = float(arm.chain.ratio[at]), float(arm.chain.offset[at])
    joint = ratio * reference + offset
    s, c = sin(joint), cos(joint)
    way = atan2(place.sine * c - place.cosine * s, place.cosine * c + place.sine * s)
    return known.wrapped(k, reference + way / ratio)


def _in_front(found: Sequence[tuple[Vector, Scalar]]) -> tuple[list[Vector], Scalar]:
    """Rows with the valid ones moved to the front in their order, the others NaN; and the number of
    valid rows."""
    size = len(found[0][0])
    rows: list[list[Scalar]] = [[0.0] * size for _ in found]
    count: Scalar = 0.0
    for i, (row, valid) in enumerate(found):
        for j in range(i + 1):
            here = valid * equal(count, float(j))
            rows[j] = [where(here, x, y) for x, y in zip(row, rows[j], strict=True)]
        count = count + valid
    return _in_place([(tuple(row), less(float(j), count)) for j, row in enumerate(rows)])


def _in_place(found: Sequence[tuple[Vector, Scalar]]) -> tuple[list[Vector], Scalar]:
    """Rows in their places, those that are not valid replaced by NaN; and the number of valid
    rows."""
    rows, count = [], 0.0
    for row, valid in found:
        none = sqrt(valid - 0.5)  # NaN, which is no constant of a program
        rows.append(tuple(where(valid, x, none) for x in row))
        count = count + valid
    return rows, count
