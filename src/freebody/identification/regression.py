"""Regression of logs: columns and torques filtered alike, weighted joint by joint, robust against
single samples, and repeated for the friction that depends on the load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import WIDTHS, Columns
from freebody.identification.decimation import Decimation, decimation
from freebody.identification.first_gains import first_gains
from freebody.identification.logs.log import Log, LogStates

REST = 0.02
"""Rate (rad/s, m/s) up to which a joint counts as resting, where dry friction is any torque that
holds: such rows are left out."""
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


class Prepared(NamedTuple):
    """A log with the states of which its columns are made, and the samples that are kept."""

    log: Log
    states: LogStates
    filter: Decimation
    places: NDArray[np.intp]


@dataclass(frozen=True)
class JointEquations:
    """The equations of one joint. x: (m, c) filtered columns, last, where there are such, those of
    load-dependent friction, and then one for the gain of the drive. unknowns: (c,) that they
    multiply. y: (m,) what they add up to. places: (m,) of the kept samples that they are of. rate:
    (m,) of the joint. load: the places of load-dependent friction."""

    x: Array
    unknowns: NDArray[np.intp]
    y: Array
    places: NDArray[np.intp]
    rate: Array
    load: slice


@dataclass(frozen=True)
class LogEquations:
    """The equations of logs of one robot, filtered once, a record of rows for each joint."""

    columns: Columns
    prepared: tuple[Prepared, ...]
    rows: tuple[JointEquations, ...]
    currents: bool
    """Whether they add up to currents with unknown gains, so that y is in A."""

    @property
    def size(self) -> int:
        """The number of unknowns without gains."""
        return len(self.columns.names)

    @property
    def inflation(self) -> float:
        """The factor by which the variance of estimates exceeds that from as many independent
        samples, the noise being white before it was filtered."""
        return max(p.filter.inflation for p in self.prepared)

    @property
    def spacing(self) -> float:
        """Time between kept samples, s."""
        return max(p.filter.step / p.log.rate for p in self.prepared)

    def put_loads(self, values: Array) -> None:
        """Puts into the columns of load-dependent friction what joints transmit with these
        unknowns: of T = Y base - J q̈, without rotors, a part is lost, a |T| sign(q̇)."""
        (base, rotors), n, found = self.columns.of_bodies(values), len(self.rows), []
        for p in self.prepared:
            torque = self.columns.transmitted(base, *p.states)
            s = self.columns.sign(p.states.qd) * np.sign(torque - rotors * p.states.qdd)
            both = np.concatenate([s * torque, -s * p.states.qdd], axis=1)
            filtered = np.empty((len(p.places), 2 * n))
            for where, x in p.filter.filtered(p.places, both.__getitem__):
                filtered[where] = x
            found.append(filtered)
        loads = np.concatenate(found)
        for j, rows in enumerate(self.rows):
            both = loads[rows.places][:, [j, n + j]]
            rows.x[:, rows.load] = both[:, : rows.load.stop - rows.load.start]

    def sums(self, values: Array) -> list[Array]:
        """The sums of each joint's columns, torques or currents."""
        return [
            rows.x[:, rows.unknowns < self.size] @ values[rows.unknowns[rows.unknowns < self.size]]
            for rows in self.rows
        ]


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


def equations(
    function: str,
    columns: Columns,
    logs: Sequence[Log],
    given: Sequence[Array] | None,
    cutoff: float,
) -> LogEquations:
    """The filtered equations of logs.

    given: what they add up to, torques (n, joints) of each log, or None for the logs' currents.
    Raises FreebodyError where a joint has too few samples that move.
    """
    prepared = tuple(_prepared(log, cutoff) for log in logs)
    n, currents = len(columns.joints), given is None
    sums = [log.current for log in logs] if given is None else given
    whole = np.empty((sum(len(p.places) for p in prepared), columns.width + n))
    start = 0
    for p, right in zip(prepared, sums, strict=True):
        _filter(columns, p, np.asarray(right), whole[start : start + len(p.places)])
        start += len(p.places)
    rate = np.concatenate([p.states.qd[p.places] for p in prepared])
    rows = []
    for j, row in enumerate(columns.rows):
        moving = np.flatnonzero(np.abs(rate[:, j]) > REST)
        extra = row.by_load + ([len(columns.names) + j] if currents else [])
        unknowns = np.array([*row.unknowns, *extra], dtype=np.intp)
        if len(moving) < 2 * len(unknowns):
            raise FreebodyError(
                f"{function}: joint {columns.joints[j]!r} moves faster than {REST:g} rad/s (m/s) "
                f"in {len(moving)} of {len(whole)} samples, too few to tell its friction; take "
                f"logs in which every joint moves."
            )
        x = np.zeros((len(moving), len(unknowns)))
        x[:, : len(row.unknowns)] = whole[moving, row.results]
        y, first = whole[moving, columns.width + j], len(row.unknowns)
        load = slice(first, first + len(row.by_load))
        rows.append(JointEquations(x, unknowns, y, moving, rate[moving, j], load))
    return LogEquations(columns, prepared, tuple(rows), currents)


def _prepared(log: Log, cutoff: float) -> Prepared:
    low_pass = decimation(log.rate, cutoff)
    return Prepared(log, log.states(), low_pass, low_pass.kept(log.settled()))


def _filter(columns: Columns, p: Prepared, given: Array, out: Array) -> None:
    """Writes filtered columns, and what they add up to, of a log's kept samples."""
    buffer = np.empty((0, columns.width + len(columns.joints)))

    def samples(part: slice) -> Array:
        nonlocal buffer
        size = part.stop - part.start
        if size > len(buffer):
            buffer = np.empty((size, buffer.shape[1]))
        x = buffer[:size]
        q, qd, qdd = (state[part] for state in p.states)
        columns.kernel(q, qd, qdd, columns.sign(qd), out=x[:, : columns.width])
        x[:, columns.width :] = given[part]
        return x

    for where, x in p.filter.filtered(p.places, samples):
        out[where] = x


def regressed(
    found: LogEquations, held: Array | None = None, start: Array | None = None
) -> Regressed:
    """The weighted least squares of the equations, of currents with the gains of the drives.

    Gains are found by Gauss's and Newton's method, as factors of the currents that change from
    round to round until none does. held: base parameters by which gains are scaled at first.
    start: unknowns of which transmitted torques are near the right ones, so that fewer rounds do.
    """
    gains = np.ones(len(found.rows)) if held is None else first_gains(found.rows, held)
    first = gains
    weights = [np.ones(len(rows.y)) for rows in found.rows]
    spread = np.array([_size(k * rows.y, 1.0) for rows, k in zip(found.rows, gains, strict=True)])
    values, residuals = np.zeros(found.size) if start is None else start, []
    more = _OF_CURRENTS * found.currents
    for k in range(0 if start is None else _LOADED - 1, _ROUNDS + more):
        if 0 < k <= _LOADED + more and found.columns.by_load:
            found.put_loads(values)
        normal, moment = _normal(found, weights, spread**-2, gains, first)
        solution, _, _ = solved(normal, moment)
        values = solution[: found.size]
        sums = found.sums(values)
        if found.currents:
            changed = gains * np.exp(np.clip(solution[found.size :], -1.0, 1.0))
            spread, gains = spread * changed / gains, changed
            for rows, total in zip(found.rows, sums, strict=True):
                rows.x[:, -1] = -total
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
    tried = []
    for width in WIDTHS:
        own = replace(columns, smooth=width)
        try:
            found = equations(function, own, short, taken, cutoff)
        except FreebodyError:  # a joint rests in the parts; it may move elsewhere
            found = equations(function, own, logs, given, cutoff)
        tried.append((regressed(found, held), own))
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
        weighted = rows.x * (weight * factor)[:, None]
        normal[np.ix_(rows.unknowns, rows.unknowns)] += rows.x.T @ weighted
        moment[rows.unknowns] += weighted.T @ (gain * rows.y)
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
