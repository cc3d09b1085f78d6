"""Whether parts of logs agree on the base parameters within the covariance that is stated: halves
by where and how fast each joint is, by time, and each log beside the others.

What is wrong with the structure shifts base parameters in another way in every motion. So the logs
are cut into pieces of a second, each piece goes to one of two parts, and Wald's test compares the
base parameters of both, each with friction of its own (any odd function of the rate). The variance
is that of the intervals, with the same inflation for what is left being no white noise: where the
test fails, the intervals do not hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.first_gains import inverse_products
from freebody.identification.log_equations import LogEquations
from freebody.identification.regression import Regressed
from freebody.identification.structure import Disagreement

_PIECE, _MOST = 1.0, 120
"""Least length of a piece of a log, s, and most pieces of all logs together."""
_UNLIKELY = 1e-3
"""Probability, over all ways to cut the logs in two, below which a difference is no accident."""
_SHARED = 0.02
"""Product of the parts of the information on a direction that both parts of the logs have, from
which on they are compared in it."""
_RANK = 1e-9
"""Part of the largest eigenvalue of the scaled information below which a direction is not told."""


class _HalvedLogs(NamedTuple):
    """A way to cut logs in two: in words, and flags of the pieces of the first part."""

    words: str
    first: NDArray[np.bool_]


def disagreement(found: LogEquations, first: Regressed, base: BaseEstimate) -> Disagreement | None:
    """The two parts of the logs that differ the most in their base parameters, or None where all
    agree within the stated covariance."""
    pieces = _pieces(found)
    cuts = _cuts(found, pieces)
    information, moments = _informed(found, first, base, cuts, pieces)
    told = []
    for cut, halves, products in zip(cuts, information, moments, strict=True):
        size, count = _difference(halves[0], products[0], halves.sum(axis=0), products.sum(axis=0))
        if count:
            factor = float(np.sqrt(size / count))
            told.append(Disagreement(cut.words, factor, float(chi2.sf(size, count))))
    unlikely = [x for x in told if x.accident * len(told) < _UNLIKELY]
    return max(unlikely, key=lambda x: x.factor, default=None)


def _pieces(found: LogEquations) -> NDArray[np.intp]:
    """The piece (m,) of each kept sample, pieces being numbered through the logs."""
    times = [p.log.time[p.places] for p in found.prepared]
    whole = sum(float(t[-1] - t[0]) for t in times if len(t))
    length, numbers, count = max(_PIECE, whole / _MOST), [], 0
    for t in times:
        own = ((t - t[0]) / length).astype(np.intp) if len(t) else np.zeros(0, dtype=np.intp)
        numbers.append(own + count)
        count += int(own.max(initial=-1)) + 1
    return np.concatenate(numbers)


def _cuts(found: LogEquations, pieces: NDArray[np.intp]) -> list[_HalvedLogs]:
    """The ways to cut the logs in two."""
    count = int(pieces.max()) + 1
    sizes = np.maximum(np.bincount(pieces, minlength=count), 1)

    def means(x: Array) -> Array:
        return np.bincount(pieces, x, count) / sizes

    q = np.concatenate([p.states.q[p.places] for p in found.prepared])
    qd = np.concatenate([p.states.qd[p.places] for p in found.prepared])
    log = np.repeat(np.arange(len(found.prepared)), [len(p.places) for p in found.prepared])
    cuts = []
    for j, joint in enumerate(found.columns.joints):
        for what, x in (("positions", q), ("rates", qd), ("speeds", np.abs(qd))):
            own = means(x[:, j])
            cuts.append(_HalvedLogs(f"{what} of {joint} above and below their median", _above(own)))
    for k, p in enumerate(found.prepared if len(found.prepared) > 1 else ()):
        words = f"the log {p.log.source or k + 1} and the others"
        cuts.append(_HalvedLogs(words, means(1.0 * (log == k)) > 0.5))
    cuts.append(_HalvedLogs("the first and the second half", _above(np.arange(count, dtype=float))))
    return cuts


def _above(x: Array) -> NDArray[np.bool_]:
    return np.asarray(x > np.median(x))


def _informed(
    found: LogEquations,
    first: Regressed,
    base: BaseEstimate,
    cuts: Sequence[_HalvedLogs],
    pieces: NDArray[np.intp],
) -> tuple[Array, Array]:
    """Information (cuts, 2, b, b) on base parameters and products (cuts, 2, b) with what is left,
    of both parts."""
    b = found.columns.base
    information, moments = np.zeros((len(cuts), 2, b, b)), np.zeros((len(cuts), 2, b))
    flags = np.array([[cut.first, ~cut.first] for cut in cuts], dtype=float)
    for j, (rows, spline) in enumerate(zip(found.rows, base.splines, strict=True)):
        laws = (rows.unknowns >= b) & (rows.unknowns < found.size)
        at, k = rows.unknowns[rows.unknowns < b], int((rows.unknowns < b).sum())
        columns = (rows.x[:, : k + int(laws.sum())], spline, first.residuals[j][:, None])
        products = _products(columns, first.weights[j], pieces[rows.places])
        present = np.unique(pieces[rows.places])
        x = np.tensordot(flags[:, :, present], products, axes=1)
        of_friction = inverse_products(x[..., k:-1, k:-1]) @ x[..., k:-1, :]
        own = (x[..., :k, :] - x[..., :k, k:-1] @ of_friction) / base.noise[j]
        information[..., at[:, None], at] += own[..., :k]
        moments[..., at] += own[..., -1]
    return information, moments


def _products(columns: Sequence[Array], weights: Array, pieces: NDArray[np.intp]) -> Array:
    """Weighted products (pieces, c, c) of columns with each other, piece by piece of those that
    there are."""
    starts = np.flatnonzero(np.diff(pieces, prepend=-1))
    found = []
    for a, z in zip(starts, [*starts[1:], len(pieces)], strict=True):
        x = np.concatenate([part[a:z] for part in columns], axis=1)
        found.append(x.T @ (x * weights[a:z, None]))
    return np.stack(found)


def _difference(own: Array, own_moment: Array, whole: Array, moment: Array) -> tuple[float, int]:
    """chi2 of the difference of base parameters between a part and the rest, in the directions that
    both tell, and their number.

    In coordinates in which the whole information is 1, that of the part is diagonal, λ; the
    difference has the information λ (1 - λ).
    """
    size = np.sqrt(np.diag(whole))
    size[size == 0.0] = 1.0
    eigenvalues, vectors = np.linalg.eigh(whole / np.outer(size, size))
    told = eigenvalues > _RANK * eigenvalues[-1]
    whitening = vectors[:, told] / np.sqrt(eigenvalues[told]) / size[:, None]
    part, turned = np.linalg.eigh(whitening.T @ own @ whitening)
    axes = whitening @ turned
    differing = axes.T @ own_moment - part * (axes.T @ moment)
    shared = part * (1.0 - part)
    both = shared > _SHARED
    return float(np.sum(differing[both] ** 2 / shared[both])), int(both.sum())
