"""Further columns of a regression and what they explain: by how much one stands out of the rest,
and by how much base parameters would move with it, so that a wrong assumption which shifts them is
told.

Such a column is the change of torques with something that the regression takes as known, such as a
joint's place or the time at which torques were logged. Friction is any odd function of the rate
beside it, as for base parameters. What a wrong assumption leaves goes with the motion and looks
like coloured noise; so the column is judged by the noise that is left with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.first_gains import inverse_products
from freebody.identification.log_equations import JointEquations, LogEquations
from freebody.identification.regression import Regressed, noise_of
from freebody.identification.verdict import QUANTILE

_UNLIKELY = 2e-5
"""Probability below which a column, one of some dozens that are tried, is no accident."""
_MOVED = 0.5
"""Change of a base parameter over half of its interval from which on the interval is doubted."""
_ALIKE = 0.9
"""Part of the best column's evidence above which another explains as much."""
_ABSORBED = 1e-4
"""Part of a column (squared) above which it differs from those of bodies and friction."""
_LOOKED_AT = 60.0
"""Time (s) about the middles of the logs, of all together, by which columns are judged."""


class Further(NamedTuple):
    """A further column that stands out: its place among those tried, its coefficient with half its
    interval of 95 %, the places and coefficients of others that explain as much, and the largest
    change of a base parameter that goes with it, over half of its interval."""

    place: int
    value: float
    half: float
    others: tuple[tuple[int, float], ...]
    moved: float


class _JointProducts(NamedTuple):
    """Weighted products of a joint's columns, friction being eliminated. at: places of its columns
    among all unknowns; kept, local: columns of bodies and further ones, and of friction (and gain);
    inverse, across, of_local: by which the local ones follow; normal, moment, before: of those that
    are kept, and their diagonal with friction held."""

    at: NDArray[np.intp]
    kept: Array
    local: Array
    inverse: Array
    across: Array
    of_local: Array
    normal: Array
    moment: Array
    before: Array


def standing_out(
    found: LogEquations, first: Regressed, base: BaseEstimate, columns: Sequence[Array]
) -> Further | None:
    """The further column, of those of each joint (rows, count), that stands out the most of what
    the regression leaves, or None where none does or base parameters stay in their intervals."""
    b, count = found.columns.base, columns[0].shape[1]
    joints = [
        _products(found, spline, x, residual, weights, j)
        for j, (spline, x, residual, weights) in enumerate(
            zip(base.splines, columns, first.residuals, first.weights, strict=True)
        )
    ]
    unknowns = b + sum(x.local.shape[1] for x in joints)
    noise = base.noise
    evidence, values = _evidence(joints, noise, b, count)
    best = int(np.argmax(evidence))
    if not evidence[best]:
        return None
    alone = np.append(np.arange(b), b + best)
    for _ in range(2):
        normal, moment = _normal(joints, noise, b + count)
        inverse = inverse_products(normal[np.ix_(alone, alone)])
        solution = np.zeros(b + count)
        solution[alone] = inverse @ moment[alone]
        left = [
            residual - _explained(x, solution)
            for x, residual in zip(joints, first.residuals, strict=True)
        ]
        noise = np.minimum(noise, _noise(found, first, left, unknowns + 1))
    value, variance = float(solution[b + best]), float(inverse[-1, -1])
    without = inverse_products(normal[:b, :b]) @ moment[:b]
    change = np.abs(solution[:b] - without)
    deviations = np.sqrt(np.maximum(np.diag(base.covariance), 1e-300))
    moved = float((change / deviations)[~base.untold].max(initial=0.0)) / QUANTILE
    if moved < _MOVED or chi2.sf(value**2 / variance, 1) > _UNLIKELY:
        return None
    alike = [k for k in range(count) if k != best and evidence[k] > _ALIKE * evidence[best]]
    others = tuple((k, float(values[k])) for k in alike)
    return Further(best, value, QUANTILE * float(np.sqrt(variance)), others, moved)


def middles(
    found: LogEquations, first: Regressed, base: BaseEstimate
) -> tuple[LogEquations, Regressed, BaseEstimate]:
    """The equations of the middles of the logs, what is left of them, and the base parameters of
    the whole with friction's columns there."""
    most = max(int(_LOOKED_AT / found.spacing / len(found.prepared)), 1)
    parts, taken = [], []
    for p in found.prepared:
        start = max((len(p.places) - most) // 2, 0)
        part = slice(start, start + most)
        parts.append(p._replace(places=p.places[part]))
        taken.append(np.isin(np.arange(len(p.places)), np.arange(start, start + most)))
    kept = np.concatenate(taken)
    place = np.cumsum(kept) - 1
    used = [kept[rows.places] for rows in found.rows]
    rows = tuple(_some(x, own, place) for x, own in zip(found.rows, used, strict=True))
    residuals, weights, splines = (
        [x[own] for x, own in zip(each, used, strict=True)]
        for each in (first.residuals, first.weights, base.splines)
    )
    return (
        replace(found, prepared=tuple(parts), rows=rows),
        first._replace(residuals=residuals, weights=weights),
        base._replace(splines=splines),
    )


def _some(rows: JointEquations, own: NDArray[np.bool_], place: NDArray[np.intp]) -> JointEquations:
    return JointEquations.of(
        rows.x[own], rows.unknowns, rows.y[own], place[rows.places[own]], rows.rate[own], rows.load
    )


def _products(
    found: LogEquations, spline: Array, further: Array, residual: Array, weights: Array, j: int
) -> _JointProducts:
    rows, b = found.rows[j], found.columns.base
    of_bodies = rows.unknowns < b
    kept = np.concatenate([rows.x[:, of_bodies], further], axis=1)
    local = np.concatenate([rows.x[:, ~of_bodies], spline], axis=1)
    at = np.concatenate([rows.unknowns[of_bodies], b + np.arange(further.shape[1])])
    weighted = local * weights[:, None]
    inverse, across = inverse_products(weighted.T @ local), weighted.T @ kept
    of_local = weighted.T @ residual
    own = kept * weights[:, None]
    whole = own.T @ kept
    normal = whole - across.T @ inverse @ across
    moment = own.T @ residual - across.T @ inverse @ of_local
    return _JointProducts(
        at, kept, local, inverse, across, of_local, normal, moment, np.diag(whole)
    )


def _normal(joints: Sequence[_JointProducts], noise: Array, size: int) -> tuple[Array, Array]:
    """The normal equations of base parameters and further columns, joints weighted by noise."""
    normal, moment = np.zeros((size, size)), np.zeros(size)
    for x, variance in zip(joints, noise, strict=True):
        normal[np.ix_(x.at, x.at)] += x.normal / variance
        moment[x.at] += x.moment / variance
    return normal, moment


def _noise(found: LogEquations, first: Regressed, left: Sequence[Array], unknowns: int) -> Array:
    """The variance (n,) of an independent sample of what is left of each joint, the dependence of
    samples being that of the joint with the largest: single joints look white by accident."""
    _, inflation, noise = noise_of(found, left, first.weights, first.gains, unknowns)
    return noise * inflation.max() / inflation


def _evidence(
    joints: Sequence[_JointProducts], noise: Array, b: int, count: int
) -> tuple[Array, Array]:
    """chi2 by which each further column alone lessens what is left, and its coefficient; 0 of those
    that bodies and friction absorb."""
    normal, moment = _normal(joints, noise, b + count)
    before = np.zeros(b + count)
    for x, variance in zip(joints, noise, strict=True):
        before[x.at] += x.before / variance
    of_base = normal[b:, :b] @ inverse_products(normal[:b, :b])
    size = np.diag(normal)[b:] - np.sum(of_base * normal[b:, :b], axis=1)
    left = moment[b:] - of_base @ moment[:b]
    distinct = size > _ABSORBED * before[b:]
    size = np.where(distinct, size, np.inf)
    return left**2 / size, left / size


def _explained(x: _JointProducts, solution: Array) -> Array:
    """The sums of a joint's columns, friction following those that are kept."""
    own = solution[x.at]
    return x.kept @ own + x.local @ (x.inverse @ (x.of_local - x.across @ own))
