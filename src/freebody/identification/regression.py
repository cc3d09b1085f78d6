"""Regression of logs: least squares of their equations, weighted joint by joint, robust against
single samples, and repeated for the friction that depends on the load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import WIDTHS, Columns
from freebody.identification.first_gains import first_gains
from freebody.identification.log_equations import LogEquations, equations
from freebody.identification.logs.log import Log

_OUTLYING = 3.0
"""Residuals above so many standard deviations count less (Huber's weights)."""
_ROUNDS, _LOADED = 5, 3
"""Solutions one after the other, each with the weights of the last, and of those how many have its
transmitted torques; load-dependent friction settles within four."""
_OF_CURRENTS = 4
"""Further solutions of currents, whose gains change from one to the next."""
_RANK = 1e-11
"""Part of the largest eigenvalue of the scaled normal equations below which a combination of
unknowns is told by nothing."""
_PART = 1e-6
"""Part of an unknown (squared) in such a combination above which it is not told either."""
_LONGEST = 2.0
"""Time (s) up to which residuals are taken to be alike."""
_OF_GAINS = 40.0
"""Weight, in equations of the noise's size, of the gains that were held at first: it counts where
bodies hardly load a joint, so that its friction alone tells no gain."""
_LEAST_NOISE = 1e-6
"""Part of a joint's torque that its noise is at least: no sensor is better."""
_TRIED = 30.0
"""Time (s) of each log by which the width of the sign of rates is chosen."""


class Regressed(NamedTuple):
    """A weighted regression.

    values: of the unknowns. information: XᵀWX in units of the noise, with the samples' dependence
    counted. covariance: (unknowns, unknowns) of the values. spread: (n,) standard deviation of each
    joint's residual. inflation: (n,) by which its samples' dependence raises variances. residuals:
    of each joint's rows, with the weights that make it robust. untold: which unknowns no equation
    tells. gains: (n,) of currents, up to a common factor, or 1; first_gains: those held at first;
    of_gains: (n, n) covariance of their logarithms, whose sum is held, (0, 0) of torques.
    """

    values: Array
    information: Array
    covariance: Array
    spread: Array
    inflation: Array
    residuals: list[Array]
    weights: list[Array]
    untold: NDArray[np.bool_]
    gains: Array
    first_gains: Array
    of_gains: Array


def regressed(
    found: LogEquations, held: Array | None = None, start: Array | None = None
) -> Regressed:
    """The weighted least squares of the equations, of currents with the gains of the drives.

    Gains are found by Gauss's and Newton's method, as factors of the currents that change from
    round to round until none does. held: base parameters by which gains are scaled at first.
    start: unknowns near the right ones by which the equations' transmitted torques were made, so
    that fewer rounds do.
    """
    gains = np.ones(len(found.rows)) if held is None else first_gains(found.rows, held)
    first = gains
    weights = [np.ones(len(rows.y)) for rows in found.rows]
    spread = np.array([_size(k * rows.y, 1.0) for rows, k in zip(found.rows, gains, strict=True)])
    values, residuals = np.zeros(found.size) if start is None else start, []
    more = _OF_CURRENTS * found.currents
    skipped = 0 if start is None else _LOADED - 1
    for k in range(skipped, _ROUNDS + more):
        if skipped < k <= _LOADED + more and found.columns.by_load:
            found.put_loads(values)
        normal, moment = _normal(found, weights, spread**-2, gains, first)
        solution, _, _ = solved(normal, moment)
        values = solution[: found.size]
        sums = found.sums(values)
        if found.currents:
            changed = gains * np.exp(np.clip(solution[found.size :], -1.0, 1.0))
            spread, gains = spread * changed / gains, changed
            for rows, total in zip(found.rows, sums, strict=True):
                last = rows.x.shape[1] - 1
                rows.put(slice(last, last + 1), -total[:, None])
        residuals = [k * r.y - x for r, x, k in zip(found.rows, sums, gains, strict=True)]
        spread = np.array([_size(e, w) for e, w in zip(residuals, weights, strict=True)])
        weights = [
            np.minimum(1.0, _OUTLYING * s / np.maximum(np.abs(e), 1e-300))
            for e, s in zip(residuals, spread, strict=True)
        ]
    spread, inflation, noise = noise_of(found, residuals, weights, gains, found.size)
    normal, moment = _normal(found, weights, 1.0 / noise, gains, first)
    _, covariance, untold = solved(normal, moment)
    size = found.size
    information = normal[:size, :size]
    if found.currents:  # what is left once the gains are free
        across, own = normal[:size, size:], normal[size:, size:]
        information = information - across @ np.linalg.pinv(own, hermitian=True) @ across.T
    return Regressed(
        values,
        information,
        covariance[:size, :size],
        spread,
        inflation,
        residuals,
        weights,
        untold[:size],
        gains,
        first,
        covariance[size:, size:],
    )


def noise_of(
    found: LogEquations,
    residuals: Sequence[Array],
    weights: Sequence[Array],
    gains: Array,
    unknowns: int,
) -> tuple[Array, Array, Array]:
    """The standard deviation of each joint's residual (n,), the factor by which its samples'
    dependence raises variances, and the variance of an independent sample, where `unknowns` numbers
    are fitted."""
    inflation = np.array(
        [
            max(found.inflation, _dependence(e, rows.places, found.spacing))
            for e, rows in zip(residuals, found.rows, strict=True)
        ]
    )
    samples = np.array([w.sum() for w in weights]) / inflation
    spread = np.array([_size(e, w) for e, w in zip(residuals, weights, strict=True)])
    spread = spread / np.sqrt(max(1.0 - unknowns / samples.sum(), 0.1))
    least = [_LEAST_NOISE * k * np.std(r.y) for r, k in zip(found.rows, gains, strict=True)]
    return spread, inflation, inflation * np.maximum(spread, least) ** 2


def suited(
    function: str,
    columns: Columns,
    logs: Sequence[Log],
    given: Sequence[Array] | None,
    cutoff: float,
    held: Array | None,
) -> tuple[Columns, Array]:
    """The columns with that width of the sign of rates, among `WIDTHS`, which leaves least of a
    part of the logs, and the unknowns there."""
    parts = [_middle(log) for log in logs]
    taken = None if given is None else [x[part] for x, part in zip(given, parts, strict=True)]
    short = [_cut(log, part) for log, part in zip(logs, parts, strict=True)]
    tried, start = [], None
    for width in WIDTHS:
        own = replace(columns, smooth=width)
        try:
            found = equations(function, own, short, taken, cutoff, start)
        except FreebodyError:  # a joint rests in the parts; it may move elsewhere
            found = equations(function, own, logs, given, cutoff, start)
        tried.append((regressed(found, held, start), own))
        start = None if found.currents else tried[0][0].values
    best, own = min(tried, key=lambda x: _left(x[0]))
    return own, best.values


def _left(x: Regressed) -> float:
    return float(np.log(x.spread / x.gains).sum())


def _middle(log: Log) -> slice:
    """The samples of a log about its middle, no more than suffice for a trial."""
    middle, half = len(log.time) // 2, int(0.5 * _TRIED * log.rate)
    return slice(max(middle - half, 0), middle + half)


def _cut(log: Log, part: slice) -> Log:
    """A part of a log."""
    arrays = ("time", "position", "velocity", "torque", "current", "measured", "temperature")
    found = {name: getattr(log, name) for name in arrays}
    return replace(log, **{name: x[part] for name, x in found.items() if x is not None})


def _size(residual: Array, weights: Array | float) -> float:
    """The standard deviation of a residual, above 0."""
    total = np.broadcast_to(weights, residual.shape).sum()
    return max(float(np.sqrt((weights * residual**2).sum() / total)), 1e-150)


def _normal(
    found: LogEquations, weights: Sequence[Array], scale: Array, gains: Array, first: Array
) -> tuple[Array, Array]:
    """The normal equations XᵀWX, XᵀWy of all joints; changes of gains, which are told up to a
    common factor, have sum 0."""
    size = found.size + len(found.rows) * found.currents
    normal, moment = np.zeros((size, size)), np.zeros(size)
    for rows, weight, factor, gain in zip(found.rows, weights, scale, gains, strict=True):
        squares, moments = rows.weighted(weight)
        normal[np.ix_(rows.unknowns, rows.unknowns)] += factor * squares
        moment[rows.unknowns] += factor * gain * moments
    if found.currents:
        hold_gains(normal, moment, found.size, gains, first)
    return normal, moment


def hold_gains(normal: Array, moment: Array, start: int, gains: Array, first: Array) -> None:
    """Adds what is held of changes of gains, the last unknowns from `start` on, to normal
    equations: their sum is 0, and the gains are near the first ones."""
    of_gains, places = slice(start, len(normal)), np.arange(start, len(normal))
    normal[of_gains, of_gains] += max(np.trace(normal[of_gains, of_gains]), 1.0)
    normal[places, places] += _OF_GAINS
    moment[places] += _OF_GAINS * np.log(first / gains)


def solved(
    normal: Array, moment: Array, scale: Array | None = None
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The solution of normal equations, the inverse of their matrix, both without the combinations
    of unknowns that are not told, and which unknowns are part of such. scale: the diagonal that the
    equations are compared with, by default their own."""
    size = np.sqrt(np.diag(normal) if scale is None else scale)
    size[size == 0.0] = 1.0
    eigenvalues, vectors = np.linalg.eigh(normal / np.outer(size, size))
    told = eigenvalues > _RANK * eigenvalues[-1]
    kept = vectors[:, told] / size[:, None]
    inverse = (kept / eigenvalues[told]) @ kept.T
    hidden = (vectors[:, ~told] ** 2).sum(axis=1) > _PART
    return inverse @ moment, inverse, hidden


def _dependence(residual: Array, places: NDArray[np.intp], spacing: float) -> float:
    """The factor by which the variance of the residual's mean exceeds that of independent samples,
    from its autocorrelation up to where it first vanishes."""
    series = np.zeros(places[-1] - places[0] + 1)
    present = np.zeros(len(series))
    series[places - places[0]] = residual
    present[places - places[0]] = 1.0
    variance, total = max(float(np.mean(residual**2)), 1e-300), 1.0
    for lag in range(1, min(len(series) // 4, int(_LONGEST / spacing) + 1)):
        pairs = present[lag:] @ present[:-lag]
        likeness = (series[lag:] @ series[:-lag]) / max(pairs, 1.0) / variance
        if likeness <= 0.0:
            break
        total += 2.0 * likeness
    return float(total)
