"""Torques that were logged later or earlier than the positions: by how much, from their residual,
and logs in which that is put right.

Torques that are late by d leave d times the rate at which the torque changes. Regressions hand part
of that to friction and masses; a column with that rate beside them tells d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from freebody.arrays import Array
from freebody.identification.any_friction import BaseEstimate
from freebody.identification.further_columns import middles, standing_out
from freebody.identification.log_equations import LogEquations
from freebody.identification.logs.log import Log
from freebody.identification.regression import Regressed
from freebody.identification.structure import Delay

_LONGEST = 0.25
"""Delay (s) either way beyond which a log is not put right."""


def delay_of(
    found: LogEquations, first: Regressed, base: BaseEstimate, before: float
) -> Delay | None:
    """The time by which torques come later than positions, or None where, beyond what was put right
    before (s), that is no more than noise, or no base parameter feels it. It can be corrected
    unless it is longer than any clock's or filter's."""
    looked_at, residuals, own = middles(found, first, base)
    columns = [-_slopes(looked_at, first, j)[:, None] for j in range(len(found.rows))]
    told = standing_out(looked_at, residuals, own, columns)
    if told is None:
        return None
    seconds = before + told.value
    return Delay(seconds, told.half, abs(seconds) <= _LONGEST)


def _slopes(found: LogEquations, first: Regressed, j: int) -> Array:
    """The rate (m,) at which the predicted torque of a joint changes, 0 where it is not known."""
    rows = found.rows[j]
    own = np.append(first.values, np.zeros(len(found.rows)))[rows.unknowns]
    of_gain = rows.unknowns >= found.size
    torque = rows.x[:, ~of_gain] @ own[~of_gain]
    times = np.concatenate([p.log.time[p.places] for p in found.prepared])[rows.places]
    slopes = np.zeros(len(torque))
    apart = times[2:] - times[:-2]
    near = (rows.places[2:] - rows.places[:-2] == 2) & (apart > 0.0) & (apart < 3.0 * found.spacing)
    slopes[1:-1][near] = (torque[2:] - torque[:-2])[near] / apart[near]
    return slopes


def earlier(logs: Sequence[Log], delay: float) -> list[Log]:
    """The logs with torques and currents taken `delay` (s) later, so that they are in time."""
    if not delay:
        return list(logs)
    return [
        replace(log, torque=_taken(log, log.torque, delay), current=_taken(log, log.current, delay))
        for log in logs
    ]


def _taken(log: Log, x: Array | None, delay: float) -> Array | None:
    if x is None:
        return None
    at = np.clip(log.time + delay, log.time[0], log.time[-1])
    return np.asarray(CubicSpline(log.time, x)(at))
