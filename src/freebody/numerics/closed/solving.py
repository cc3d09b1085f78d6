"""Lagrange's equations of the first kind (5.29) solved where equations depend on one another, or lose rank.

    M q̈ + Φ_qᵀ λ = n,   Φ_q q̈ = c

With M + Φ_qᵀ Φ_q = L Lᵀ (which changes nothing on the constraints, and lets links without mass be) and y = Lᵀ q̈ this is
the smallest change of y that satisfies (Φ_q L⁻ᵀ) y = c: Gauss's principle. Singular values tell the rank.

Where Φ_q has lost rank and the mechanism moves, Φ's third derivative must vanish too; what that asks of q̈ is solved
besides, so that a motion through a singular position stays on its branch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array

RANK = 1e-9
"""Singular values, relative to the largest, that count as zero."""
_BRANCH = 1e-7  # the same for the conditions at a singular position, relative to the speed
_DETERMINED = 1e-7  # part of a component in the null space from which it is not determined


@dataclass(frozen=True)
class Solution:
    """One state's solution."""

    qdd: Array
    """(nv,)."""
    multipliers: Array
    """(m,): of those that are not determined, the smallest."""
    determined: Array
    """(m,) bool."""
    loose: Array
    """(m, k): combinations of multipliers that change nothing."""


Jerk = Callable[[Array], Array]
"""x (k, nv) -> Φ's third derivative at q̈ = x (k, m), unscaled."""


def solve(
    M: Array, n: Array, phi: Array, c: Array, rows: Array, rates: Array, jerk: Jerk, speed: float
) -> Solution:
    """q̈ and λ of one state.

    M (nv, nv), n (nv,), Φ_q (m, nv), c (m,); rows (m,), rates (nv,): the scales of `equations`; speed: of the fastest
    scaled rate. The multipliers are those of the equations as given.
    """
    A, right = rows[:, None] * phi * rates, rows * c
    mass, force = rates[:, None] * M * rates, rates * n
    weight = max(float(np.trace(mass)), 1e-300) / max(float(np.sum(A * A)), 1e-300)
    L = np.linalg.cholesky(mass + weight * A.T @ A)
    inverse: Array = np.linalg.inv(L).astype(float, copy=False)
    B = A @ inverse.T
    free = inverse @ (force + weight * A.T @ right)
    U, s, Vt = np.linalg.svd(B)
    rank = int((s > RANK * s.max(initial=1e-300)).sum())
    y = Vt[:rank].T @ ((U[:, :rank].T @ right) / s[:rank])
    null = Vt[rank:].T
    y = y + null @ (null.T @ free)
    loose = U[:, rank:]
    if loose.shape[1] and null.shape[1] and speed > 0.0:
        y = y + null @ _onto_branch(y, inverse.T @ null, loose.T, rows, rates, inverse, jerk, speed)
    multipliers = U[:, :rank] @ ((Vt[:rank] @ (free - y)) / s[:rank])
    determined = np.linalg.norm(loose, axis=1) < _DETERMINED
    q = rates * (inverse.T @ y)
    return Solution(q, multipliers * rows, determined, loose * rows[:, None])


def _onto_branch(
    y: Array,
    directions: Array,
    loose: Array,
    rows: Array,
    rates: Array,
    inverse: Array,
    jerk: Jerk,
    speed: float,
) -> Array:
    """Weights (k,) of the null directions (nv, k) that must be added so that Φ's third derivative can vanish."""
    start = rates * (inverse.T @ y)
    states = np.concatenate([start[None], start + rates * directions.T])
    values = jerk(states) * rows
    at, slopes = loose @ values[0], loose @ (values[1:] - values[0]).T
    U, s, Vt = np.linalg.svd(slopes, full_matrices=False)
    # directions are as long as M makes them; compare with the largest turn they make
    kept = s > _BRANCH * speed * max(float(np.abs(directions).max(initial=0.0)), 1e-300)
    return -Vt[kept].T @ ((U[:, kept].T @ at) / s[kept])
