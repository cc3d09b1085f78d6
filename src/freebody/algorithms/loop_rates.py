"""Rates and accelerations that keep the loops closed: x with Φ_q x = c, nearest to others or with
some given.

With Φ_q = [A B] over dependent and independent rates, x_dependent = A⁻¹ (c - B x_independent)
(`loop_forces`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

from freebody.algorithms.loop_checks import largest
from freebody.algorithms.loop_constraints import solved
from freebody.algorithms.loop_forces import Orthogonal, Partition, orthogonal, scaled_jacobian
from freebody.algorithms.loop_scales import no_finer, scales
from freebody.elementary import Scalar, absolute, maximum
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot, sub, transposed

ALLOWED = 1e-8
"""The residual of a scaled equation, relative to the largest angular rate, above which the values
given contradict it."""
_ROUNDINGS = 4096.0
"""The residual in units of rounding, for numbers of 32 bits: a thousand for columns that may be
nearly dependent, and a few for sums."""


def nearest(
    tree: Tree, q: Vector, given: Vector, right: Vector, partition: Partition
) -> tuple[Vector, list[Scalar]]:
    """(x (nv,) with Φ_q x = right (m,) that is nearest to the rates given, all taken as angular;
    margins that are positive where this is it)."""
    rows, rates = scales(tree)
    phi = scaled_jacobian(tree, q)
    wanted = tuple(s * c for s, c in zip(rows, right, strict=True))
    columns = transposed(tuple(phi[k] for k in partition.rows))
    factors = orthogonal([columns[k] for k in partition.dependent])
    independent = [k for k in range(tree.nv) if k not in partition.dependent]
    start = tuple(value / r for value, r in zip(given, rates, strict=True))
    at_rest = factors.solve(
        tuple(wanted[k] for k in partition.rows)
    )  # x_dependent where the others are 0
    slopes = [factors.solve(columns[k]) for k in independent]
    missing = sub(tuple(start[k] for k in partition.dependent), at_rest)
    normal = [
        [dot(a, b) + (1.0 if i == j else 0.0) for j, b in enumerate(slopes)]
        for i, a in enumerate(slopes)
    ]
    free, _ = solved(
        normal,
        tuple(start[k] - dot(slope, missing) for k, slope in zip(independent, slopes, strict=True)),
    )
    led = sub(at_rest, tuple(dot(row, free) for row in transposed(tuple(slopes))))
    found = dict(zip((*independent, *partition.dependent), (*free, *led), strict=True))
    return _checked(phi, wanted, rates, tuple(found[k] for k in range(tree.nv)), factors)


def led(
    tree: Tree,
    q: Vector,
    given: Vector,
    right: Vector,
    held: Sequence[int],
    equations: Sequence[int],
) -> tuple[Vector, list[Scalar]]:
    """(x (nv,) with Φ_q x = right (m,) that has the rates of the coordinates `held` as they are
    given; margins that are positive where this is it); by equations that tell all."""
    rows, rates = scales(tree)
    phi = scaled_jacobian(tree, q)
    wanted = tuple(s * c for s, c in zip(rows, right, strict=True))
    fixed = tuple(
        value / r if k in held else 0.0
        for k, (value, r) in enumerate(zip(given, rates, strict=True))
    )
    columns = transposed(tuple(phi[k] for k in equations))
    moving = [k for k in range(tree.nv) if k not in held]
    moving.sort(key=lambda k: sum(not _vanishes(x) for x in columns[k]))  # which fill little
    factors = orthogonal([columns[k] for k in moving])
    missing = tuple(wanted[k] - dot(phi[k], fixed) for k in equations)
    found = dict(zip(moving, factors.solve(missing), strict=True))
    return _checked(
        phi, wanted, rates, tuple(found.get(k, value) for k, value in enumerate(fixed)), factors
    )


def _vanishes(x: Scalar) -> bool:
    return isinstance(x, int | float) and x == 0.0


def _checked(
    phi: Matrix, wanted: Vector, rates: Vector, x: Vector, factors: Orthogonal
) -> tuple[Vector, list[Scalar]]:
    """The angular rates x converted to the coordinates' own units, and margins that are positive
    where they satisfy every loop equation."""
    left = [absolute(c - dot(row, x)) for c, row in zip(wanted, phi, strict=True)]
    result = tuple(r * value for r, value in zip(rates, x, strict=True))
    most = 1.0 + largest(result, rates)
    allowed = no_finer(ALLOWED, most, _ROUNDINGS) * most - reduce(maximum, left, 0.0)
    return result, [allowed, *factors.margins]
