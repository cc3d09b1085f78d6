"""Base parameters whatever the friction: what logs tell of bodies and rotors where a joint's
friction may be any function of its rate that is odd but for its slope.

Friction that the laws do not describe is no noise: it goes with the motion, and a regression with
these laws hands part of it to masses, in the same way in every period. No residual shows that, as
it is orthogonal to the columns. So beside the laws each joint gets columns that add up to any odd
function of its rate, a spline with knots where the joint moves, and to a slope of its own in each
direction; what bodies have in common with these is taken from the bodies (a partially linear
regression: Robinson 1988). Where a law fits, the intervals become a few per cent wider; where none
does, they hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from freebody.arrays import Array
from freebody.identification.first_gains import inverse_products
from freebody.identification.log_equations import JointEquations, LogEquations, Prepared
from freebody.identification.regression import Regressed, hold_gains, noise_of, solved

_KNOTS = (0.08, 0.2, 0.4, 0.7, 1.0)
"""Parts of a joint's samples that are slower than each knot of the spline, denser where friction
changes most."""
_ROUNDS = 2
"""Solutions one after the other, each with the noise of the last."""
_TOLD = 1e-6
"""Part of a column of the spline (squared) that the laws must lack for it to count against them."""


class BaseEstimate(NamedTuple):
    """Base parameters (b,), their covariance, which of them the logs do not tell, and of each joint
    the probability that noise alone makes its friction differ from the laws as much as it does.
    noise: (n,) variance of an independent sample of each joint. splines: columns of joints' rows
    that make its friction any function."""

    values: Array
    covariance: Array
    untold: NDArray[np.bool_]
    accident: Array
    noise: Array
    splines: list[Array]


class _FrictionlessRows(NamedTuple):
    """A joint's equations without its friction. kept: places of the columns of bodies and of the
    gain, with the unknowns that they multiply; laws: those of friction's, beside which its spline
    stands: both together are local. own, across: weighted products of the local columns with
    themselves and with the kept ones; inverse: of the first. of_local, of_kept: those of the
    columns with the residual. normal: the kept unknowns' normal equations, friction being
    eliminated; before: their diagonal without that."""

    rows: JointEquations
    spline: Array
    kept: NDArray[np.intp]
    unknowns: NDArray[np.intp]
    laws: NDArray[np.intp]
    own: Array
    across: Array
    inverse: Array
    of_local: Array
    of_kept: Array
    normal: Array
    before: Array

    def of_changed(self, change: Array) -> Array:
        """Products of the local columns with the residual after a change of what is kept."""
        return self.of_local - self.across @ change[self.unknowns]


def with_any_friction(found: LogEquations, first: Regressed) -> BaseEstimate:
    """The base parameters of the equations, friction being any function of each joint's rate that
    is odd but for its slope, besides what the laws make of it; from the regression with the laws
    alone."""
    b, n = found.columns.base, len(found.rows)
    splines = _splines(found)
    joints = [
        _without_friction(found, *each)
        for each in zip(found.rows, splines, first.weights, first.residuals, strict=True)
    ]
    size = b + n * found.currents
    fitted = size + sum(len(x.own) for x in joints)
    residuals = first.residuals
    _, _, noise = noise_of(found, residuals, first.weights, first.gains, fitted)
    for _ in range(_ROUNDS):
        change, _, _ = _change(joints, first, 1.0 / noise, found)
        pairs = zip(joints, first.residuals, strict=True)
        residuals = [_left(x, residual, change) for x, residual in pairs]
        _, _, noise = noise_of(found, residuals, first.weights, first.gains, fitted)
    change, covariance, untold = _change(joints, first, 1.0 / noise, found)
    accident = [
        _accident(x, change, covariance, variance)
        for x, variance in zip(joints, noise, strict=True)
    ]
    values = first.values[:b] + change[:b]
    return BaseEstimate(values, covariance[:b, :b], untold[:b], np.array(accident), noise, splines)


def spline_knots(rates: Sequence[Array]) -> Array:
    """Knots (knots, n) of each joint's spline, where it moves, from its rates."""
    return np.array([np.quantile(np.abs(x), _KNOTS) for x in rates]).T


def spline_columns(qd: Array, sign: Array, knots: Array) -> list[Array]:
    """Columns (samples, n), from rates and their signs, that add up to any odd function of each
    joint's rate, and to its size: the size, the sign, and this times the size up to each knot."""
    size = np.abs(qd)
    return [size, sign, *(sign * np.minimum(size, k) for k in knots)]


def _splines(found: LogEquations) -> list[Array]:
    """The filtered columns of the spline of friction, for each joint's rows."""
    n, knots = len(found.rows), spline_knots([rows.rate for rows in found.rows])
    parts = [_spline(found, p, knots) for p in found.prepared]
    whole = np.concatenate(parts)
    whole = whole.reshape(len(whole), -1, n)
    return [whole[rows.places, :, j] for j, rows in enumerate(found.rows)]


def _spline(found: LogEquations, p: Prepared, knots: Array) -> Array:
    """The filtered columns (samples, count n) of a log."""

    def samples(part: slice) -> Array:
        qd = p.states.qd[part]
        return np.concatenate(spline_columns(qd, found.columns.sign(qd), knots), axis=1)

    filtered = np.empty((len(p.places), knots.shape[1] * (2 + len(knots))))
    for where, x in p.filter.filtered(p.places, samples):
        filtered[where] = x
    return filtered


def _without_friction(
    found: LogEquations, rows: JointEquations, spline: Array, weights: Array, residual: Array
) -> _FrictionlessRows:
    b = found.columns.base
    is_kept = (rows.unknowns < b) | (rows.unknowns >= found.size)
    kept, laws = np.flatnonzero(is_kept), np.flatnonzero(~is_kept)
    squares, _ = rows.weighted(weights)
    weighted = spline * weights[:, None]
    beside, of_columns = weighted.T @ rows.x, rows.x.T @ (weights * residual)
    own = np.block(
        [[squares[np.ix_(laws, laws)], beside[:, laws].T], [beside[:, laws], weighted.T @ spline]]
    )
    across = np.concatenate([squares[np.ix_(laws, kept)], beside[:, kept]])
    inverse, whole = inverse_products(own), squares[np.ix_(kept, kept)]
    unknowns = rows.unknowns[kept]
    unknowns = np.where(unknowns < b, unknowns, unknowns - found.size + b)
    of_local = np.concatenate([of_columns[laws], weighted.T @ residual])
    normal = whole - across.T @ inverse @ across
    return _FrictionlessRows(
        rows, spline, kept, unknowns, laws, own, across, inverse,
        of_local, of_columns[kept], normal, np.diag(whole),
    )  # fmt: skip


def _change(
    joints: list[_FrictionlessRows], first: Regressed, scale: Array, found: LogEquations
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Changes of base parameters and gains, the covariance, and which are not told."""
    b = found.columns.base
    size = b + len(joints) * found.currents
    normal, moment, before = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    for x, factor in zip(joints, scale, strict=True):
        normal[np.ix_(x.unknowns, x.unknowns)] += factor * x.normal
        moment[x.unknowns] += factor * (x.of_kept - x.across.T @ (x.inverse @ x.of_local))
        before[x.unknowns] += factor * x.before
    if found.currents:
        hold_gains(normal, moment, b, first.gains, first.first_gains)
        before[b:] = np.diag(normal)[b:]
    return solved(normal, moment, before)


def _left(x: _FrictionlessRows, residual: Array, change: Array) -> Array:
    """The rest of a joint's residual after a change of what is kept, friction following."""
    friction, values = x.inverse @ x.of_changed(change), np.zeros(x.rows.x.shape[1])
    values[x.kept], values[x.laws] = change[x.unknowns], friction[: len(x.laws)]
    return residual - x.rows.x @ values - x.spline @ friction[len(x.laws) :]


def _accident(x: _FrictionlessRows, change: Array, covariance: Array, noise: float) -> float:
    """The probability that what friction is beyond the laws is due to noise as often: Wald's test
    of the coefficients of the spline's part that the laws lack."""
    k = len(x.laws)
    of_laws = x.own[k:, :k] @ inverse_products(x.own[:k, :k])
    own = x.own[k:, k:] - of_laws @ x.own[:k, k:]
    size = np.sqrt(np.diag(x.own)[k:])
    eigenvalues, vectors = np.linalg.eigh(own / np.outer(size, size))
    lacking = eigenvalues > _TOLD
    directions = (vectors[:, lacking] / np.sqrt(eigenvalues[lacking])).T / size
    beyond = directions @ np.concatenate([-of_laws, np.eye(len(own))], axis=1)
    found = beyond @ x.of_changed(change)
    across = beyond @ x.across
    spread = across @ covariance[np.ix_(x.unknowns, x.unknowns)] @ across.T
    spread[np.diag_indices(len(found))] += noise
    return float(chi2.sf(found @ np.linalg.solve(spread, found), len(found)))
