"""Predictions of a model beside what logs have, sample by sample: the curves behind the numbers of
an identification."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.identification.log_equations import LogEquations


@dataclass(frozen=True, eq=False)
class LogFit:
    """A log beside what the identified model predicts, filtered alike, NaN where a joint rests.

    source: the log's name. unseen: whether the model was not made from it. time: (m,) s. rate:
    (m, n) rad/s (m/s). measured, predicted: (m, n) torques, N m (N). friction: (m, n) of them what
    the model has of friction; measured - predicted + friction is what the log has of it."""

    source: str
    unseen: bool
    time: Array
    rate: Array
    measured: Array
    predicted: Array
    friction: Array


def log_fits(found: LogEquations, values: Array, gains: Array, unseen: bool) -> tuple[LogFit, ...]:
    """The logs of equations beside the sums of their columns with these unknowns; gains: (n,) by
    which their right sides become torques."""
    counts = [len(p.places) for p in found.prepared]
    empty = np.full((sum(counts), len(found.rows)), np.nan)
    rate, measured, predicted, friction = (empty.copy() for _ in range(4))
    end = found.columns.base
    for j, (rows, total) in enumerate(zip(found.rows, found.sums(values), strict=True)):
        lost = (rows.unknowns >= end) & (rows.unknowns < found.size)
        rate[rows.places, j] = rows.rate
        measured[rows.places, j] = gains[j] * rows.y
        predicted[rows.places, j] = total
        friction[rows.places, j] = rows.x[:, lost] @ values[rows.unknowns[lost]]
    made, start = [], 0
    for p, count in zip(found.prepared, counts, strict=True):
        part = slice(start, start + count)
        arrays = (x[part] for x in (rate, measured, predicted, friction))
        made.append(LogFit(p.log.source or "log", unseen, p.log.time[p.places], *arrays))
        start += count
    return tuple(made)
