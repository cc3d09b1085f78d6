"""Forces of closed chains: the torques of the drives, and the forces of the loops.

Loops let the coordinates move with x_dependent = X x_independent: Φ_q = [A B] over dependent and
independent rates, X = -A⁻¹ B. So torques n of the tree have the power n_independent + Xᵀ
n_dependent, and multipliers with Aᵀ λ = n_dependent stand for them. A is taken apart by orthogonal
columns, A = Q R (modified Gram-Schmidt), which needs no choice of pivots: the diagonal of R
vanishes only where A is singular. There, and where an equation that was left out does not follow
from the others, what is not zero anyway is NaN. Everything is scaled so that lengths and angles
compare.

Which equations and coordinates to take is structure, chosen beforehand (`Partition`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

from freebody.algorithms.crba import only_inertia
from freebody.algorithms.loop_constraints import (
    constraint_jacobian,
    loop_loads,
    one_if_positive,
    solved,
)
from freebody.algorithms.loop_scales import no_finer, scales
from freebody.algorithms.rnea import Recursion, rnea
from freebody.elementary import Scalar, maximum, minimum, sqrt
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, add, dot, scale, sub, times, transposed

_PIVOT = 1e-3
"""The smallest entry of R's diagonal relative to the largest, from which columns are regular enough
to divide by."""
_LEFT = 1e-9
"""The residual of a scaled equation that rounding leaves where it follows from others."""
_ROUNDINGS = 4096.0
"""The residual in units of rounding, for numbers of 32 bits."""


class Partition(NamedTuple):
    """A choice of independent loop equations, and of the coordinates that they determine."""

    rows: tuple[int, ...]
    """Equations that determine all that the loops determine."""
    dependent: tuple[int, ...]
    """The coordinates that these equations determine, as many as there are equations; the undriven
    ones are among them."""
    driven: tuple[int, ...]
    """Coordinates that are not dependent, and maybe more."""


@dataclass(frozen=True)
class Orthogonal:
    """Columns as Q R, Q of orthonormal columns, R triangular."""

    units: tuple[Vector, ...]
    """Columns of the orthogonal factor Q."""
    triangle: tuple[Vector, ...]
    """Entries of R down to the diagonal, column by column."""

    @property
    def margins(self) -> list[Scalar]:
        """Margins that are positive where the columns are independent enough to divide by."""
        sizes = [column[-1] for column in self.triangle]
        return [reduce(minimum, sizes) - _PIVOT * reduce(maximum, sizes)] if sizes else []

    def solve(self, right: Vector) -> Vector:
        """x with Σ x[k] columns[k] = right."""
        x: list[Scalar] = []
        for unit in self.units:
            x.append(dot(unit, right))
            right = sub(right, scale(x[-1], unit))
        for k in reversed(range(len(x))):
            x[k] = x[k] / self.triangle[k][k]
            for j in range(k):
                x[j] = x[j] - self.triangle[k][j] * x[k]
        return tuple(x)

    def solve_transposed(self, right: Vector) -> Vector:
        """The smallest x with columns[k] · x = right[k]."""
        z: list[Scalar] = []
        for column, value in zip(self.triangle, right, strict=True):
            for entry, known in zip(column, z, strict=False):
                value = value - entry * known
            z.append(value / column[-1])
        x: Vector = (0.0,) * len(self.units[0] if self.units else right)
        for unit, value in reversed(tuple(zip(self.units, z, strict=True))):
            x = add(x, scale(value - dot(unit, x), unit))  # Björck 1967: less rounding than Q z
        return x


def orthogonal(columns: Sequence[Vector]) -> Orthogonal:
    """Q and R of columns, by modified Gram-Schmidt in their order; zeros of the columns before are
    kept."""
    units: list[Vector] = []
    triangle: list[Vector] = []
    for column in columns:
        entries: list[Scalar] = []
        for unit in units:
            entries.append(dot(unit, column))
            column = sub(column, scale(entries[-1], unit))
        size = sqrt(dot(column, column))
        units.append(scale(1.0 / size, column))
        triangle.append((*entries, size))
    return Orthogonal(tuple(units), tuple(triangle))


@dataclass(frozen=True)
class _Split:
    """The constraint Jacobian Φ_q at one position, scaled to angles and split into dependent and
    independent coordinates."""

    factors: Orthogonal
    """Factors of A, the columns of the dependent coordinates."""
    independent: tuple[int, ...]
    columns: Matrix
    """Columns of Φ_q, of the partition's equations alone."""
    phi: Matrix
    """All rows of Φ_q."""
    row_scale: Vector
    """Factors (m,) that make angles of the residuals of all equations."""
    rate_scale: Vector
    """Rates divided by it are angular."""


def drive_torques(tree: Tree, q: Vector, needed: Vector, partition: Partition) -> Vector:
    """Torques of the driven joints that have the power of `needed` (nv,) in every motion that the
    loops allow.

    The smallest of them, where more drive than need be: y of the independent coordinates and X_d y
    of the driven ones among the dependent have the power of n for (1 + X_dᵀ X_d) y = n_independent
    + Xᵀ n_dependent.
    """
    split = _split(tree, q, partition)
    angular = tuple(s * n for s, n in zip(split.rate_scale, needed, strict=True))
    loads = split.factors.solve_transposed(tuple(angular[k] for k in partition.dependent))
    power = tuple(angular[k] - dot(split.columns[k], loads) for k in split.independent)
    also = [i for i, k in enumerate(partition.dependent) if k in partition.driven]
    found: list[Scalar] = [0.0] * tree.nv
    if also:
        moved = [split.factors.solve(split.columns[k]) for k in split.independent]  # -X, by columns
        moved = [tuple(column[i] for i in also) for column in moved]
        square = [
            [dot(a, b) + (1.0 if i == j else 0.0) for j, b in enumerate(moved)]
            for i, a in enumerate(moved)
        ]
        power, _ = solved(square, power)
        for i, value in zip(also, times(transposed(tuple(moved)), power), strict=True):
            found[partition.dependent[i]] = -value
    for k, value in zip(split.independent, power, strict=True):
        found[k] = value
    here = _where_it_holds(split, _loose(split, partition)[1])
    return tuple(here * x / s for x, s in zip(found, split.rate_scale, strict=True))


def loop_multipliers(tree: Tree, q: Vector, forces: Vector, partition: Partition) -> Vector:
    """λ (m,) with Φ_qᵀ λ = forces (nv,), which have no power in any motion that the loops allow;
    where equations depend on one another the smallest λ, as forces of scaled equations."""
    split = _split(tree, q, partition)
    wanted = tuple(split.rate_scale[k] * forces[k] for k in partition.dependent)
    known = dict(zip(partition.rows, split.factors.solve_transposed(wanted), strict=True))
    weights = tuple(known.get(k, 0.0) for k in range(tree.constraints))
    loose, left = _loose(split, partition)
    for unit in orthogonal(loose).units:
        weights = sub(weights, scale(dot(unit, weights), unit))
    here = _where_it_holds(split, left)
    return tuple(here * s * x for s, x in zip(split.row_scale, weights, strict=True))


def loose_recursions(tree: Tree, q: Vector, partition: Partition) -> list[tuple[Vector, Recursion]]:
    """For each combination of multipliers that no motion feels: its multipliers (m,), and what they
    alone do to the bodies. The combinations are orthonormal as forces of scaled equations."""
    split = _split(tree, q, partition)
    still, light = (0.0,) * tree.nv, replace(only_inertia(tree), gravity=tree.space.zero)
    found: list[tuple[Vector, Recursion]] = []
    for unit in orthogonal(_loose(split, partition)[0]).units:
        multipliers = tuple(s * x for s, x in zip(split.row_scale, unit, strict=True))
        found.append((multipliers, rnea(light, q, still, still, loop_loads(tree, q, multipliers))))
    return found


def _where_it_holds(split: _Split, left: Scalar) -> Scalar:
    """1 where the partition fits the position, NaN elsewhere; left: the sum of squares that
    `_loose` returns."""
    margins, least = split.factors.margins, no_finer(_LEFT, left, _ROUNDINGS)
    return one_if_positive(*margins, least * least - left) if margins else 1.0


def scaled_jacobian(tree: Tree, q: Vector) -> Matrix:
    """The constraint Jacobian Φ_q with residuals of the equations and rates both as angles."""
    rows, rates = scales(tree)
    return tuple(
        tuple(s * x * r for x, r in zip(row, rates, strict=True))
        for s, row in zip(rows, constraint_jacobian(tree, q), strict=True)
    )


def _split(tree: Tree, q: Vector, partition: Partition) -> _Split:
    rows, rates = scales(tree)
    phi = scaled_jacobian(tree, q)
    columns = transposed(tuple(phi[k] for k in partition.rows))
    independent = tuple(k for k in range(tree.nv) if k not in partition.dependent)
    return _Split(
        orthogonal([columns[k] for k in partition.dependent]),
        independent,
        columns,
        phi,
        rows,
        rates,
    )


def _loose(split: _Split, partition: Partition) -> tuple[list[Vector], Scalar]:
    """(combinations (m,) of the scaled equations that vanish, each equation left out less those
    that it follows from; the sum of squares of what they leave of Φ_q)."""
    found: list[Vector] = []
    left: Scalar = 0.0
    for k, row in enumerate(split.phi):
        if k in partition.rows:
            continue
        follows = split.factors.solve_transposed(tuple(row[i] for i in partition.dependent))
        weights = dict(zip(partition.rows, follows, strict=True))
        found.append(tuple(1.0 if i == k else -weights.get(i, 0.0) for i in range(len(split.phi))))
        for i in split.independent:
            rest = row[i] - dot(follows, split.columns[i])
            left = left + rest * rest
    return found, left
