"""The physical robot nearest to base values, whatever was held of it beforehand, by semidefinite
programming: bodies exist where their pseudo-inertias are positive definite, which are linear matrix
inequalities of the unknowns (Sousa, Cortesão 2014; Wensing, Kim, Slotine 2018). Clarabel, an
interior-point solver, comes with the extra `lmi`."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from freebody.arrays import Array
from freebody.errors import FreebodyError, MissingPackageError
from freebody.identification.consistency import Fitted, Physical

_MARGIN = 1e-4
"""Part of the prior's pseudo-inertia that is left of each: a body at the very edge is none."""
_BELOW = 1e-3
"""Part of an upper bound that scalars stay below it."""
_HELD = 1e-7
"""Weight of the prior, which only chooses among robots that are equally near."""
_SUREST = 1e10
"""Information on a part of the prior's size beyond which the solver's digits end."""
_ROUNDED = 1e-10
"""Part of the largest singular value below which base parameters tell nothing."""


def nearest_by_lmi(
    estimate: Array, information: Array, combine: Array, physical: Physical
) -> Fitted:
    """Physical unknowns with the least chi2, those nearest to the prior among them.

    estimate: (b,) of regression, with information (b, b). combine: (b, x), of which physical
    unknowns the estimated are made. Raises MissingPackageError without Clarabel, and FreebodyError
    where it finds no solution.
    """
    try:
        import clarabel as compiled  # type: ignore[import-not-found]  # an extra
    except ImportError:
        raise MissingPackageError("identify: lmi=True", "clarabel", "lmi") from None
    clarabel: Any = compiled  # which tells no types
    free, units = _ellipsoid(estimate, information, combine, physical)
    rows, bounds, cones = _conditions(clarabel, physical)
    settings: Any = clarabel.DefaultSettings()
    settings.verbose = False
    count = units.shape[1]
    found = clarabel.DefaultSolver(
        csc_matrix(np.eye(count)), np.zeros(count), csc_matrix(rows @ units),
        bounds - rows @ free, cones, settings,
    ).solve()  # fmt: skip
    x = free + units @ np.array(found.x)
    if not np.isfinite(x).all() or str(found.status) not in ("Solved", "AlmostSolved"):
        raise FreebodyError(
            f"identify: no physical robot was found near the logs by lmi=True (Clarabel: "
            f"{found.status}); leave it out, for the one near the prior."
        )
    gap = combine @ x - estimate
    return Fitted(x, 0.0, float(gap @ information @ gap))


def _ellipsoid(
    estimate: Array, information: Array, combine: Array, physical: Physical
) -> tuple[Array, Array]:
    """The unknowns (x,) that fit the data best, nearest to the prior where these tell nothing, and
    steps (x, x) from there, of which each costs 1 (half a squared standard deviation is 1/2)."""
    start = physical.start()
    _, near = physical.slopes(start, _HELD)
    scalars = np.arange(physical.bodies.size, len(start))
    sizes = np.nan_to_num(np.abs(physical.scalars), nan=1.0)
    near[scalars, scalars] = _HELD / np.where(sizes > 0.0, sizes, 1.0) ** 2
    size = np.sqrt(_HELD / np.diag(near))
    columns, free = combine * size, start / size
    _, told, ways = np.linalg.svd(columns, full_matrices=True)
    rank = int((told > _ROUNDED * told[0]).sum())
    shown, hidden = ways[:rank].T, ways[rank:].T
    to_base = columns @ shown
    known = to_base.T @ information @ to_base
    moment = to_base.T @ information @ (estimate - columns @ free)
    free = free + shown @ np.linalg.solve(known + _HELD * np.eye(rank), moment)
    near = near * np.outer(size, size)
    steps = []
    for own, of_data in ((shown, known), (hidden, 0.0)):
        eigenvalues, vectors = np.linalg.eigh(own.T @ near @ own + of_data)
        steps.append(own @ vectors / np.sqrt(np.clip(eigenvalues, _HELD, _SUREST)))
    return size * free, size[:, None] * np.concatenate(steps, axis=1)


def _conditions(clarabel: Any, physical: Physical) -> tuple[Array, Array, list[Any]]:
    """(A, b, cones) of A x + s = b with s in the cones: pseudo-inertias, in units of the prior's,
    above a margin; scalars not negative, and below their bounds."""
    bodies, k = physical.bodies.shape
    d, count = len(physical.basis[0]), bodies * k + len(physical.scalars)
    rows, bounds, cones = [], [], []
    for b, P in enumerate(physical.pseudo_inertias(physical.start())):
        inverse = np.linalg.inv(np.linalg.cholesky(P))
        own = np.zeros((d * (d + 1) // 2, count))
        own[:, b * k : (b + 1) * k] = -_entries(inverse @ physical.basis @ inverse.T).T
        rows.append(own)
        bounds.append(-_MARGIN * _entries(np.eye(d)))
        cones.append(clarabel.PSDTriangleConeT(d))
    positive = np.flatnonzero(~np.isnan(physical.scalars))
    bounded = np.flatnonzero(np.isfinite(physical.below))
    each = np.eye(count)[bodies * k :]
    rows += [-each[positive], each[bounded]]
    bounds += [np.zeros(len(positive)), (1.0 - _BELOW) * physical.below[bounded]]
    cones.append(clarabel.NonnegativeConeT(len(positive) + len(bounded)))
    return np.concatenate(rows), np.concatenate(bounds), cones


def _entries(matrices: Array) -> Array:
    """The entries (..., d (d + 1) / 2) of symmetric matrices, column by column to the diagonal,
    with norms as the matrices have them."""
    columns, rows = np.tril_indices(matrices.shape[-1])
    return matrices[..., rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))
