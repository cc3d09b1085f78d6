"""Checks of closed chains as margins: whether a state satisfies the loops, and whether results
computed for it can be trusted.

A margin is positive where all is well, and NaN or not positive elsewhere. Gaps, rates and
accelerations are compared as angles, lengths over the mechanism's own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce

from freebody.algorithms.crba import Factors
from freebody.algorithms.loop_constraints import (
    Constrained,
    Counting,
    constraint,
    constraint_bias,
    constraint_jacobian,
    constraint_rate,
    kept,
    loop_ends,
    one_if_positive,
)
from freebody.algorithms.loop_scales import no_finer, scales
from freebody.elementary import Scalar, absolute, maximum, minimum
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot, times

CLOSED = 1e-6
"""Gap, relative to the mechanism's length, from which a loop counts as open."""
LEFT = 1e-6
"""The residual of an equation of accelerations, relative to its terms, above which it is no
rounding."""
PIVOT = 1e-4
"""The smallest pivot of the quick solution relative to the largest, below which another takes over.
Rounding there is 1e-16 over the pivot, and motions through singular positions carry it on: a double
four-bar that passes ten of them is right to 1e-9 with this, with a hundredth of it to 1e-7."""
LIGHT = 1e10
"""The mechanism's inertia over that which resists a loop; rad/s²: more than that comes of a
division by rounding."""
_FOLLOWS = 1e-8
"""The residual, relative to its terms, of an equation that was left out: near singular positions
one that does not follow from the others leaves hardly more."""
_ROUNDINGS = 4096.0
"""The residual in units of rounding, for numbers of 32 bits."""
_IDLE = 1e-12  # a pivot of M, relative to its entry on the diagonal, that may be rounding
# cosine between axes that a loop holds together, below which it is closed the wrong way round
_FORWARD = 0.5


def sure(values: Vector, margins: Iterable[Scalar]) -> Vector:
    """The values where all margins are positive, else NaN; NaN is added to them, since a value may
    be the constant 0."""
    nothing = one_if_positive(*margins) - 1.0
    return tuple(x + nothing for x in values)


def closure_margins(tree: Tree, q: Vector, qd: Vector | None = None) -> list[Scalar]:
    """Margins of loops that are closed, the right way round, and stay closed at the rates."""
    rows, rates = scales(tree)
    margins = [CLOSED**2 - x for x in _by_loop(tree, rows, constraint(tree, q))]
    for loop, (a, b) in zip(tree.loops, loop_ends(tree, q), strict=True):
        for n, u in loop.closure.facing:
            n_world, u_world = times(a[0], n), times(b[0], u)
            expected = tree.space.turn(a[0], tree.space.moment(u, n))
            margins.append(dot(expected, tree.space.moment(u_world, n_world)) - _FORWARD)
    if qd is not None:
        least = CLOSED * (1.0 + largest(qd, rates))
        margins += [least * least - x for x in _by_loop(tree, rows, constraint_rate(tree, q, qd))]
    return margins


def consistent_margin(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Scalar:
    """The margin, positive where accelerations keep the loops closed."""
    terms, left = _left_by(tree, q, qd, qdd, range(tree.constraints))
    return LEFT * terms - left


def following_margins(
    tree: Tree, q: Vector, qd: Vector, qdd: Vector, counting: Counting | None
) -> list[Scalar]:
    """Margins, positive where accelerations also satisfy the loop equations that were left out as
    dependent."""
    others = counting.left_out(tree) if counting else ()
    if not counting or not others:
        return []
    terms, left = _left_by(tree, q, qd, qdd, others)
    return [no_finer(max(_FOLLOWS, counting.slack), terms, _ROUNDINGS) * terms - left]


def _left_by(
    tree: Tree, q: Vector, qd: Vector, qdd: Vector, equations: Sequence[int]
) -> tuple[Scalar, Scalar]:
    """(size of the terms of the scaled loop equations, largest residual that accelerations leave in
    one of them)."""
    rows, rates = scales(tree)
    c, phi = constraint_bias(tree, q, qd), constraint_jacobian(tree, q)
    left = [rows[k] * (dot(phi[k], qdd) - c[k]) for k in equations]
    terms = 1.0 + largest(qdd, rates) + _largest(s * x for s, x in zip(rows, c, strict=True))
    return terms, _largest(left)


def solution_margins(
    tree: Tree, M: Matrix, factors: Factors, found: Constrained, counting: Counting | None
) -> list[Scalar]:
    """Margins of accelerations that were found with equations that are independent and an inertia
    that resists every motion.

    M and its factors; counting: the equations that were taken, None is all.
    """
    rows, rates = scales(tree)
    taken = kept(rows, counting)
    pivots = [s * s * pivot for s, pivot in zip(taken, found.pivots, strict=True)]
    diagonal = [M[k][k] for k in range(tree.nv)]
    inverse = [factors[1][k] for k in range(tree.nv)]
    share = reduce(maximum, [m * x for m, x in zip(diagonal, inverse, strict=True)])
    margins = [reduce(minimum, inverse), 1.0 / _IDLE - share]
    if pivots:
        most = reduce(maximum, pivots)
        # over rates in m/s, M is a mass: all is made an inertia
        inertia = reduce(maximum, [r * r * m for r, m in zip(rates, diagonal, strict=True)])
        margins += [reduce(minimum, pivots) - PIVOT * most, LIGHT - inertia * most]
    return [*margins, LIGHT - largest(found.qdd, rates)]


def largest(values: Vector, rates: Vector) -> Scalar:
    """Largest of the rates, or of their derivatives, in angular measure: each divided by its
    scale."""
    return _largest(x / r for x, r in zip(values, rates, strict=True))


def _largest(values: Iterable[Scalar]) -> Scalar:
    return reduce(maximum, map(absolute, values), 0.0)


def _by_loop(tree: Tree, rows: Vector, values: Vector) -> list[Scalar]:
    """Sum of squares of the scaled equations of each loop."""
    scaled = iter([s * x for s, x in zip(rows, values, strict=True)])
    sizes = [loop.closure.size(tree.space) for loop in tree.loops]
    return [dot(part, part) for part in (tuple(next(scaled) for _ in range(n)) for n in sizes)]
