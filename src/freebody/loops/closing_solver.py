"""The way onto the loops: Levenberg-Marquardt on the loop equations, or on combinations of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.loops.scaled_equations import every_jacobian, every_residual, rate_scale
from freebody.model.model import Model
from freebody.trees.states import difference, integrate

Telling = Callable[[Array], Array]
"""Φ_q (N, m, nv) -> P (N, m, m): the combinations of the equations that count, see
`scaled_equations.telling`."""

Closing = Callable[[Array], tuple[Array, NDArray[np.bool_]]]
"""q (N, nq) -> (positions near q (N, nq), whether they are closed (N,))."""

_WAYS = (0.05, 0.13, 0.31)  # rad: how far a neighbourhood is explored
_MOST = 48  # directions, among many at random
_STEP = 0.6  # rad: the longest step towards closure
_ITERATIONS = 60


def closed_from(
    model: Model, q: Array, moving: Sequence[int], projector: Telling | None
) -> tuple[Array, Array]:
    """(positions (N, nq) as closed as they get from q (N, nq), largest scaled equation left
    (N,))."""

    def at(q: Array) -> tuple[Array, Array]:
        phi, J = every_residual(model, q), every_jacobian(model, q)
        if projector is not None:
            P = projector(J)
            phi, J = np.einsum("nij,nj->ni", P, phi), P @ J
        return phi, J[..., list(moving)]

    stretch = rate_scale(model)
    q = np.array(q)
    phi, J = at(q)
    damping = np.full(len(q), 1e-2)
    for _ in range(_ITERATIONS):
        size = np.abs(phi).max(axis=-1, initial=0.0)
        active = np.flatnonzero((size > 1e-15) & (damping < 1e6))
        if not len(active):
            break
        step = _levenberg(
            J[active], phi[active], damping[active] * np.linalg.norm(phi[active], axis=-1)
        )
        full = np.zeros((len(active), model.nv))
        full[:, list(moving)] = step
        trial = integrate(model, q[active], full * stretch)
        left, slope = at(trial)
        better = np.linalg.norm(left, axis=-1) < np.linalg.norm(phi[active], axis=-1)
        at_better = active[better]
        q[at_better], phi[at_better], J[at_better] = trial[better], left[better], slope[better]
        damping[active] = np.where(
            better, np.maximum(damping[active] * 0.1, 1e-12), damping[active] * 10.0
        )
    return q, np.abs(phi).max(axis=-1, initial=0.0)


def explored(model: Model, q: Array, directions: Array, close: Closing) -> Array:
    """Closed positions (k, nq) to which finite motions lead from q (nq,): steps along directions
    (n, nv), scaled, and mixtures of them, that closing does not undo."""
    n = len(directions)
    if not n:
        return np.empty((0, model.nq))
    ways = np.concatenate([np.eye(n), np.random.default_rng(2).normal(size=(4 * n, n))])[:_MOST]
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    ways = np.concatenate([size * sign * ways for size in _WAYS for sign in (1.0, -1.0)])
    start = np.broadcast_to(q, (len(ways), model.nq))
    found, good = close(integrate(model, start, ways @ directions * rate_scale(model)))
    moved = np.linalg.norm(difference(model, start, found) / rate_scale(model), axis=-1)
    return found[good & (moved > 0.3 * np.linalg.norm(ways, axis=-1))]


def _levenberg(J: Array, phi: Array, damping: Array) -> Array:
    """The step -Jᵀ (J Jᵀ + μ)⁻¹ φ (N, k), no longer than a sensible turn."""
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    floor = 1e-10 * s.max(axis=-1, keepdims=True, initial=1e-300)
    gain = np.where(s > floor, s / (s * s + damping[:, None]), 0.0)
    step = -np.einsum("nkj,nk->nj", Vt, gain * np.einsum("nmk,nm->nk", U, phi))
    longest = np.abs(step).max(axis=-1, initial=0.0)
    return step * np.minimum(1.0, _STEP / np.maximum(longest, 1e-300))[:, None]
