"""The choice of independent loop equations and coordinates for compiled kernels: made once for each
geometry, near its home.

A kernel is straight-line arithmetic and cannot choose at a position. Where the choice does not hold
it returns NaN, or says by its pivots how good it is, and the functions of closed chains take those
samples with care.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.loop_constraints import Counting
from freebody.algorithms.loop_forces import Partition
from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.loops.equations import closing, is_closed, scaled_jacobian
from freebody.loops.redundancy import EXACT, redundancy
from freebody.loops.scaled_equations import explored, mechanism, null_space
from freebody.model.geometry import first_member, geometric_fact
from freebody.model.model import Model
from freebody.trees.states import generic_state, home_guess

RANK_WHERE_FOUND = 1e-8
"""Singular values of the scaled Φ_q, relative to the largest, that count as zero at positions
found."""
_SEEDS = 8  # starts from which a closed position is sought where home leads to none
_REGULAR = 1e-2  # the smallest part, relative to the largest, that a coordinate has of its own
_NOTHING = 1e-12  # an entry of a scaled Φ_q that is rounding


@geometric_fact
def independent_rows(model: Model) -> tuple[int, ...]:
    """The indices of loop equations that are independent near the model's home; found once for each
    geometry.

    Where the loops cannot be closed from home, near the first of some fixed starts from which they
    can; all, where there is none.
    """
    known = redundancy(model)
    if known.rank is not None:
        return known.rows
    regular = _regular(model)
    dropped = () if regular is None else dependent_rows(regular)
    return tuple(k for k in range(mechanism(model).constraints) if k not in dropped)


def counting_equations(model: Model) -> Counting:
    """The independent loop equations, with the residual that rounding of the model's numbers leaves
    in the others."""
    return Counting(independent_rows(model), redundancy(model).slack)


@geometric_fact
def _regular(model: Model) -> Array | None:
    """The scaled Φ_q (m, nv) at a regular position near home; None where no closed position was
    found."""
    at = _anywhere(model)
    if at is None:
        return None
    here = scaled_jacobian(model, at)  # more than all equations cannot be independent anywhere
    return here if rank(here) == len(here) else regular_jacobian(model, at)[0]


def _anywhere(model: Model) -> Array | None:
    """A closed position (nq,) that does not depend on earlier calls: the one at home, else the
    first one found from fixed starts; None where none was found."""
    starts = np.stack([home_guess(model), *generic_state(model, seed=5, batch=_SEEDS)[0]])
    for some in (starts[:1], starts[1:]):
        closed, left = closing(model, some, range(model.nv))
        good = closed[is_closed(model, closed, left)]
        if len(good):
            return good[0]
    return None


def regular_jacobian(model: Model, q: Array) -> tuple[Array, bool]:
    """(the scaled Φ_q (m, nv) of largest rank at q (nq,) and at positions reached from it, whether
    any position was reached)."""
    J = scaled_jacobian(model, q)

    def close(start: Array) -> tuple[Array, NDArray[np.bool_]]:
        found, left = closing(model, start, range(model.nv))
        return found, left < EXACT

    reached = explored(model, q, null_space(J, RANK_WHERE_FOUND)[0].T, close)
    return max([J, *(scaled_jacobian(model, p) for p in reached)], key=rank), len(reached) > 0


def rank(J: Array) -> int:
    """Rank of a scaled Φ_q (m, nv)."""
    s = np.linalg.svd(J, compute_uv=False)
    return int((s > RANK_WHERE_FOUND * s.max(initial=1e-300)).sum())


def dependent_rows(J: Array) -> tuple[int, ...]:
    """Rows of J (m, n) that are combinations of rows before them."""
    basis = np.zeros((0, J.shape[1]))
    found = []
    for k, row in enumerate(J):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        size = float(np.linalg.norm(rest))
        if size <= 1e-7 * max(float(np.linalg.norm(row)), 1e-300):
            found.append(k)
        else:
            basis = np.vstack([basis, rest / size])
    return tuple(found)


@geometric_fact
def idle_coordinates(model: Model) -> tuple[int, ...]:
    """Indices of the coordinates that no loop equation depends on."""
    regular = _regular(model)
    return () if regular is None else tuple(np.flatnonzero(~regular.any(axis=0)).tolist())


def partition(model: Model, driven: Sequence[int] | None = None) -> Partition | None:
    """The partition for drives in the coordinates `driven` (default: the model's own).

    None where no fixed choice does: too few drives, numbers that are rounded (`redundancy`), no
    closed position near home, or nothing that moves.
    """
    return _partitions(model, model.driven if driven is None else tuple(driven))


def partition_of_loops(model: Model) -> Partition | None:
    """A partition for forces of the loops, which does not depend on the drives; None where there is
    none."""
    return partition(model) or partition(model, range(model.nv))


def require_partition(model: Model, function: str, by_drives: bool) -> Partition:
    """A partition for the model's own drives or for the loops alone; SingularError where there is
    none."""
    found = partition(model) if by_drives else partition_of_loops(model)
    if found is None:
        drives = "the drives do not force every motion, or " if by_drives else "nothing moves, or "
        raise SingularError(
            f"{function}: no choice of equations and coordinates of {model.name!r} holds near its "
            f"home, which a compiled kernel needs: {drives}redundant equations are rounded. Use "
            f"the functions of closed chains, fb.inverse_dynamics or fb.reactions, which choose at "
            f"each position."
        )
    return found


def _partitions(model: Model, driven: tuple[int, ...]) -> Partition | None:
    """The partition for a choice of drives, found once and kept with the geometry; None where there
    is none."""
    facts = model.geometry.facts
    key = f"{__name__}.partition {driven}"
    if key not in facts:
        facts.setdefault(key, _chosen(first_member(model), driven))
    return facts[key]


def _chosen(model: Model, driven: tuple[int, ...]) -> Partition | None:
    regular = None if redundancy(model).rank is not None else _regular(model)
    if regular is None:
        return None
    rows = independent_rows(model)
    columns = regular[list(rows)].T
    undriven = [k for k in range(model.nv) if k not in driven]
    dependent = _pivoted(columns, undriven, len(undriven))
    if dependent is None or len(rows) == model.nv:
        return None
    more = _pivoted(columns - _along(columns, dependent), list(driven), len(rows) - len(undriven))
    if more is None:
        return None
    few = np.count_nonzero(
        np.abs(columns) > _NOTHING, axis=1
    )  # columns with few entries first: they fill little
    return Partition(rows, tuple(sorted([*dependent, *more], key=lambda k: (few[k], k))), driven)


def _along(columns: Array, chosen: list[int]) -> Array:
    """The part of each column (n, m) in the span of the chosen columns."""
    if not chosen:
        return np.zeros_like(columns)
    units = np.linalg.svd(columns[chosen], full_matrices=False)[2]
    return columns @ units.T @ units


def _pivoted(columns: Array, among: list[int], count: int) -> list[int] | None:
    """Indices of `count` clearly independent columns (n, m), the largest first and the first of
    equal ones; None where there are fewer."""
    if count < 0:
        return None
    left, chosen = columns.copy(), []
    largest = float(np.linalg.norm(columns, axis=1).max(initial=1e-300))
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=1)
        free = [k for k in among if k not in chosen]
        k = max(free, key=lambda k: (sizes[k].round(9), -k), default=-1)
        if k < 0 or sizes[k] <= _REGULAR * largest:
            return None
        chosen.append(k)
        unit = left[k] / sizes[k]
        left = left - np.outer(left @ unit, unit)
    return chosen
