"""The common factor of gains, masses and frictions that currents leave open: what it is, how surely
it is known, and how a load of known mass tells it.

With gains of any scale, logs with the load and without it give its mass in the same scale; the true
mass over this one is the factor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import Columns
from freebody.identification.load_estimates import (
    between,
    evidence_of,
    load_estimate,
    load_regression,
    on_frame,
)
from freebody.identification.log_equations import LogEquations
from freebody.identification.logs.log import Log
from freebody.identification.regression import Regressed
from freebody.model.model import Model

_LEAST = 3.0
"""Standard deviations that the load's mass must be above 0."""


class TorqueScale(NamedTuple):
    """A factor of torques, and the standard deviation of its logarithm, which is infinite where
    nothing tells the factor."""

    factor: float
    unsure: float

    def interval(self, quantile: float) -> tuple[float, float]:
        """Factors by which what has this scale may truly be smaller and larger."""
        if not np.isfinite(self.unsure):
            return 0.0, np.inf
        return float(np.exp(-quantile * self.unsure)), float(np.exp(quantile * self.unsure))


def scale_by_load(
    model: Model,
    columns: Columns,
    empty: Sequence[Log],
    loaded: Sequence[Log],
    mass: float,
    first: Regressed,
    cutoff: float,
) -> TorqueScale:
    """The scale of gains that were found up to a factor, from logs of currents with a load of known
    mass (kg) at the tip and without it. Raises FreebodyError where they do not show the load."""
    kinds = [
        load_regression(
            "identify",
            model,
            columns,
            [replace(x, torque=_torque(x, first.gains)) for x in logs],
            cutoff,
        )
        for logs in (empty, loaded)
    ]
    difference, information = between(*(evidence_of(*kind) for kind in kinds))
    combine = columns.matrix @ on_frame("identify", model, None, columns)
    load = load_estimate(combine, difference, information)
    found, variance = float(load.estimate[0]), float(load.covariance[0, 0])
    variance *= max(load.chi2 / load.freedom, 1.0)
    if load.untold[0] or found < _LEAST * np.sqrt(variance):
        raise FreebodyError(
            f"identify: the logs of loaded= do not show the load of {mass:g} kg; give motions "
            f"against gravity, a heavier load, or look whether the logs are with the load, and "
            f"those of logs= without it."
        )
    of_base = (load.covariance @ combine.T @ information)[0]
    without, with_load = (_by_gains(*kind) for kind in kinds)
    by_gains = of_base @ (with_load - without)
    variance += float(by_gains @ first.of_gains @ by_gains)
    return TorqueScale(mass / found, float(np.sqrt(variance)) / found)


def _torque(log: Log, gains: Array) -> Array:
    if log.current is None:
        raise FreebodyError(
            f"identify: the log {log.source!r} of loaded= has torques, and those of logs= currents "
            f"whose gains are looked for; give its currents."
        )
    return log.current * gains


def _by_gains(found: LogEquations, x: Regressed) -> Array:
    """(b, n): changes of base parameters with the logarithm of each joint's gain."""
    slopes = []
    for j, (rows, weight) in enumerate(zip(found.rows, x.weights, strict=True)):
        moment = np.zeros(found.size)
        moment[rows.unknowns] = rows.x.T @ (weight * rows.y) / (x.inflation[j] * x.spread[j] ** 2)
        slopes.append((x.covariance @ moment)[: found.columns.base])
    return np.array(slopes).T
