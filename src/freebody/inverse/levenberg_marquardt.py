"""Least squares by Levenberg and Marquardt, many starts side by side (Levenberg 1944; Marquardt
1963)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.arrays import Array

Residual = Callable[[Array, np.ndarray], tuple[Array, Array]]
"""(x (k, n), rows (k,)) -> (e (k, m), E (k, m, nv)): residuals of problems, and what a step takes
off them."""

Move = Callable[[Array, Array], Array]
"""(x, step) -> the moved x."""


def descend(
    residual: Residual,
    x: Array,
    move: Move = np.add,
    *,
    goal: float = 0.0,
    iterations: int = 60,
    rest: float = 1e-14,
) -> tuple[Array, Array]:
    """(x, |e|) after descending from each start x (N, n).

    A problem stops where |e| ≤ goal or where its steps fall below `rest`. Each has a damping of its
    own, a third of the last after a step that helped, three times after one that did not.
    """
    x = x.copy()
    everyone = np.arange(len(x))
    e, E = residual(x, everyone)
    cost, damping = np.linalg.norm(e, axis=-1), np.full(len(x), 1e-2)
    active = everyone[cost > goal]
    for _ in range(iterations):
        if not len(active):
            break
        step = _step(e[active], E[active], damping[active])
        trial = move(x[active], step)
        e_trial, E_trial = residual(trial, active)
        cost_trial = np.linalg.norm(e_trial, axis=-1)
        better = cost_trial < cost[active]
        kept = active[better]
        x[kept] = trial[better]
        e[kept] = e_trial[better]
        E[kept] = E_trial[better]
        cost[kept] = cost_trial[better]
        damping[kept] = np.maximum(damping[kept] * 0.2, 1e-14)
        damping[active[~better]] *= 4.0
        moving = np.abs(step).max(axis=-1) > rest
        active = active[moving & (cost[active] > goal) & (damping[active] < 1e12)]
    return x, cost


def _step(e: Array, E: Array, damping: Array) -> Array:
    transposed = np.swapaxes(E, -1, -2)
    n = E.shape[-1]
    normal = transposed @ E
    normal[:, range(n), range(n)] += damping[:, None]
    return np.linalg.solve(normal, transposed @ e[..., None])[..., 0].astype(float, copy=False)
