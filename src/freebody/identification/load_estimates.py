"""Estimates of a load from logs with it and without it, before a body is sought that can be it.

A load on a link adds to the base parameters β what its own mass, first moment and inertia π add,
β + K π. The logs of each kind give β with friction of their own, so that a drive that has warmed up
in between does not pass for a mass; their difference gives π (Khalil, Gautier, Lemoine 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import Columns
from freebody.identification.given_logs import torques_of
from freebody.identification.log_equations import LogEquations, equations
from freebody.identification.logs.log import Log
from freebody.identification.priors import of_moments
from freebody.identification.regression import Regressed, regressed, suited
from freebody.model.inertial_parameters import body_parameters
from freebody.model.model import Model
from freebody.spatial import of_dimension
from freebody.trees.regressors import inertial_parameters

_NOTHING = 1e-7
"""Part of the largest sensitivity (per kg, kg m, kg m²) below which a parameter has no effect."""
_RANK, _PART = 1e-10, 1e-6
"""Part of the largest eigenvalue below which a combination of the load's parameters is told by
nothing, and part of a parameter (squared) in one, above which it is not told either."""


class Evidence(NamedTuple):
    """Evidence of logs on base parameters, whatever friction was: an estimate (b,) and its
    information (b, b), the inverse of its covariance."""

    base: Array
    information: Array


class LoadEstimate(NamedTuple):
    """An unconstrained estimate of a load's parameters π (k,), its information and covariance,
    which of them are untold, and how far the data are from it: chi2 with its degrees of freedom."""

    estimate: Array
    information: Array
    covariance: Array
    untold: NDArray[np.bool_]
    chi2: float
    freedom: int


def load_regression(
    function: str, model: Model, columns: Columns, logs: Sequence[Log], cutoff: float
) -> tuple[LogEquations, Regressed]:
    """The equations of logs that have torques, and their regression."""
    torques = [x for x in (torques_of(model, log) for log in logs) if x is not None]
    columns, start = suited(function, columns, logs, torques, cutoff, None)
    found = equations(function, columns, logs, torques, cutoff)
    return found, regressed(found, None, start)


def evidence_of(found: LogEquations, x: Regressed) -> Evidence:
    """Evidence of a regression on base parameters once friction is free."""
    b, information = found.columns.base, x.information
    across = information[:b, b:]
    left = across @ np.linalg.pinv(information[b:, b:], hermitian=True) @ across.T
    return Evidence(x.values[:b], information[:b, :b] - left)


def on_frame(function: str, model: Model, frame: str | None, columns: Columns) -> Array:
    """(p, k): by how much a load's parameters, in the axes of a frame, change those of the arm;
    from particles, whose own parameters are known."""
    at, size = model.frame(frame), len(body_parameters(of_dimension(model.dim)))
    if at.body < 0:
        raise FreebodyError(
            f"{function}: no joint moves the frame {at.name!r}; name one of a link that "
            f"carries the load, frame=."
        )
    bare = model.without("friction", "rotors", "springs")
    before: dict[str, Any] = dict(inertial_parameters(bare))
    places = np.random.default_rng(0).uniform(-1.0, 1.0, (size, model.dim))
    own = np.array([of_moments(1.0, c, np.outer(c, c)) for c in places])
    added = []
    for c in places:
        carrying = bare.with_payload(1.0, com=c, frame=at.name)
        after: dict[str, Any] = dict(inertial_parameters(carrying))
        added.append(
            [float(after.get(x, 0.0) - before.get(x, 0.0)) for x in columns.inertial_names]
        )
    return np.asarray(np.linalg.solve(own, np.array(added)).T, dtype=float)


def between(empty: Evidence, loaded: Evidence) -> tuple[Array, Array]:
    """The difference (b,) of base parameters that a load made, and its information (b, b)."""
    both = np.linalg.pinv(empty.information + loaded.information, hermitian=True)
    shared = empty.information @ both @ loaded.information
    return loaded.base - empty.base, 0.5 * (shared + shared.T)


def load_estimate(combine: Array, difference: Array, information: Array) -> LoadEstimate:
    """The load that explains a difference of base parameters best."""
    M = combine.T @ information @ combine
    size = np.sqrt(np.maximum(np.diag(M), 0.0))
    size = np.where(size > _NOTHING * size.max(), size, np.inf)
    eigenvalues, vectors = np.linalg.eigh(M / np.outer(size, size))
    told = eigenvalues > _RANK * eigenvalues[-1]
    ways = vectors[:, told] / size[:, None]
    covariance = (ways / eigenvalues[told]) @ ways.T
    estimate = covariance @ (combine.T @ information @ difference)
    gap = combine @ estimate - difference
    untold = (vectors[:, ~told] ** 2).sum(axis=1) > _PART
    return LoadEstimate(
        estimate,
        M,
        covariance,
        untold,
        float(gap @ information @ gap),
        max(len(combine) - int(told.sum()), 1),
    )
