"""Lagrange's equations of the first kind (5.29) solved where equations depend on one another, or
lose rank.

    M q̈ + Φ_qᵀ λ = n,   Φ_q q̈ = c

Singular values tell the rank of Φ_q. What it leaves open is found in its null space N, where λ does
no work: Nᵀ M q̈ = Nᵀ n. Links without mass are welcome, as long as no motion that the loops allow
moves nothing but them.

Where Φ_q has lost rank and the mechanism moves, Φ's third derivative must vanish too; what that
asks of q̈ is solved besides, so that a motion through a singular position stays on its branch.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.arrays import Array

RANK = 1e-9
"""Singular values, relative to the largest, that count as zero."""
BLURRED = 1e-5
"""The same for accelerations, in which rounding is divided by the square of a singular value."""
AT_REST = 1e-6
"""The same of a mechanism at rest, where rounding in the computation may change them by 1e-4."""
_BRANCH = 1e-7  # the same for the conditions at a singular position, relative to the speed
_IDLE = 1e-13  # of the largest inertia: none


class Idle(Exception):
    """A motion that the loops allow moves no inertia; the coordinate that it moves most."""

    def __init__(self, coordinate: int):
        super().__init__(coordinate)
        self.coordinate = coordinate


Jerk = Callable[[Array], Array]
"""x (k, nv) -> Φ's third derivative at q̈ = x (k, m), scaled."""


def solve(
    M: Array,
    n: Array,
    A: Array,
    c: Array,
    rates: Array,
    jerk: Jerk,
    speed: float,
    blurred: float = BLURRED,
) -> Array:
    """q̈ (nv,) of one state. Raises Idle.

    M (nv, nv), n (nv,); A (m, nv), c (m,): scaled as in `equations`, over rates scaled by `rates`
    (nv,); speed: of the fastest scaled rate; blurred: singular values, relative to the largest,
    that count as zero.
    """
    mass, force = rates[:, None] * M * rates, rates * n
    U, s, Vt = np.linalg.svd(A)
    rank = int((s > blurred * s.max(initial=1e-300)).sum())
    loose, null = U[:, rank:], Vt[rank:].T
    x = Vt[:rank].T @ ((U[:, :rank].T @ c) / s[:rank])
    if null.shape[1]:
        ways = null @ _unit_root(null, mass)  # of unit inertia: wayᵀ M way = 1
        x = x + ways @ (ways.T @ (force - mass @ x))
        if loose.shape[1] and speed > 0.0:
            x = x + ways @ _onto_branch(x, ways, loose.T, rates, jerk, speed)
    return rates * x


def _unit_root(null: Array, mass: Array) -> Array:
    """W (k, k) with Wᵀ (Nᵀ M N) W = 1."""
    sizes, vectors = np.linalg.eigh(null.T @ mass @ null)
    if sizes[0] <= _IDLE * max(float(np.abs(np.diagonal(mass)).max()), 1e-300):
        raise Idle(int(np.argmax(np.abs(null @ vectors[:, 0]))))
    return vectors / np.sqrt(sizes)


def _onto_branch(
    x: Array, ways: Array, loose: Array, rates: Array, jerk: Jerk, speed: float
) -> Array:
    """Weights (k,) of the ways (nv, k) that must be added so that Φ's third derivative can
    vanish."""
    values = jerk(rates * np.concatenate([x[None], x + ways.T]))
    at, slopes = loose @ values[0], loose @ (values[1:] - values[0]).T
    U, s, Vt = np.linalg.svd(slopes, full_matrices=False)
    # ways are as long as M makes them; compare with the largest turn they make
    kept = s > _BRANCH * speed * max(float(np.abs(ways).max(initial=0.0)), 1e-300)
    return -Vt[kept].T @ ((U[:, kept].T @ at) / s[kept])
