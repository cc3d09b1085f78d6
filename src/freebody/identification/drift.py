"""Friction that changes while a robot works: by how much, from log to log and block to block of
time, since drives warm up and their grease grows thin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from freebody.arrays import Array
from freebody.identification.columns import Columns
from freebody.identification.first_gains import inverse_products
from freebody.identification.log_equations import JointEquations, LogEquations
from freebody.identification.regression import Regressed
from freebody.identification.verdict import QUANTILE

_BLOCK, _MOST = 10.0, 8
"""Least length of a block of time, s, and most blocks of a log."""
_UNLIKELY = 1e-4
"""Probability below which differences of friction are no accident."""
_LARGE = 0.05
"""Part of friction below which a change is not told: no use of a model feels it."""
_LEAST = 0.02
"""Part of a joint's torque below which it has no friction whose changes count."""
_FEWEST = 20
"""Samples that a block needs, while the joint moves."""


@dataclass(frozen=True)
class FrictionChange:
    """How the friction of a joint changed from some logs to others. factor: the later over the
    earlier, over the rates of the later, with half the width of its interval of 95 %."""

    joint: str
    factor: float
    half: float
    significant: bool

    def text(self) -> str:
        """The change in percent, with its interval."""
        return f"{self.joint} by {100.0 * (self.factor - 1.0):+.0f} ± {100.0 * self.half:.0f} %"


@dataclass(frozen=True)
class FrictionDrift:
    """Friction of a joint over the time of logs, block by block: `factor` of the identified
    friction, whose mean over the blocks is 1, `half` the widths of their intervals of 95 %. log:
    the number of each block's log. time: of its middle, s. temperature: its mean, °C, or NaN."""

    joint: str
    log: Array
    time: Array
    factor: Array
    half: Array
    temperature: Array
    significant: bool

    @property
    def change(self) -> float:
        """Change from the first block to the last, as part of the friction."""
        return float(self.factor[-1] - self.factor[0])

    def text(self) -> str:
        """A sentence on what happened, with numbers."""
        low, high = int(np.argmin(self.factor)), int(np.argmax(self.factor))
        half = float(np.hypot(self.half[low], self.half[high]))
        said = (
            f"{self.joint} between {self.factor[low]:.2f} (log {self.log[low] + 1:.0f}, "
            f"{self.time[low]:.3g} s) and {self.factor[high]:.2f} (log {self.log[high] + 1:.0f}, "
            f"{self.time[high]:.3g} s) times its mean, ± {half:.2f}"
        )
        span = np.ptp(self.temperature)
        if np.isfinite(span) and span >= 1.0:
            slope = 100.0 * np.polyfit(self.temperature, self.factor, 1)[0]
            said += f", {slope:+.2g} % for each °C"
        return said


def friction_change(
    before: LogEquations, earlier: Regressed, after: LogEquations, later: Regressed
) -> tuple[FrictionChange, ...]:
    """How much the friction of each joint with notable friction changed between two regressions."""
    found = []
    for j, (a, b) in enumerate(zip(before.rows, after.rows, strict=True)):
        own, others = of_friction(before.columns, a), of_friction(after.columns, b)
        first = b.x[:, others] @ earlier.values[a.unknowns[own]]
        size = float(first @ first)
        if size < _LEAST**2 * float(b.y @ b.y):
            continue
        at = b.unknowns[others]
        factor = float(first @ (b.x[:, others] @ later.values[at])) / size
        slopes = b.x[:, others].T @ first / size
        both = later.covariance[np.ix_(at, at)] + earlier.covariance[np.ix_(at, at)]
        half = QUANTILE * float(np.sqrt(slopes @ both @ slopes))
        changed = abs(factor - 1.0) > max(_LARGE, half)
        found.append(FrictionChange(after.columns.joints[j], factor, half, changed))
    return tuple(found)


def friction_drift(found: LogEquations, x: Regressed) -> tuple[FrictionDrift, ...]:
    """Friction of each joint over time, where it is a notable part of the torque.

    A factor of friction in each block of time is added to the joint's own regression, so that what
    masses explain as well is not told as drift.
    """
    blocks, log, time = _blocks(found)
    made = []
    for j, rows in enumerate(found.rows):
        own = of_friction(found.columns, rows)
        friction = rows.x[:, own] @ x.values[rows.unknowns[own]]
        if float(friction @ friction) < _LEAST**2 * float(np.sum((x.gains[j] * rows.y) ** 2)):
            continue
        at = blocks[rows.places]
        present = [k for k in range(len(log)) if (at == k).sum() >= _FEWEST]
        if len(present) < 2:
            continue
        columns = np.stack([np.where(at == k, friction, 0.0) for k in present], axis=1)
        told = np.flatnonzero(rows.unknowns < found.size)
        across = (rows.x.T @ columns)[told]
        shared = inverse_products(rows.squares[np.ix_(told, told)]) @ across
        noise = x.inflation[j] * x.spread[j] ** 2
        own = columns.T @ columns - across.T @ shared
        inverse = np.linalg.pinv(own, rcond=1e-6, hermitian=True)
        moment = columns.T @ x.residuals[j] - shared.T @ (rows.x.T @ x.residuals[j])[told]
        change = inverse @ moment
        half = QUANTILE * np.sqrt(noise * np.diag(inverse))
        accident = chi2.sf(change @ moment / noise, len(present) - 1)
        made.append(
            FrictionDrift(
                found.columns.joints[j],
                log[present],
                time[present],
                1.0 + change - change.mean(),
                half,
                _temperatures(found, j, blocks)[present],
                bool(accident < _UNLIKELY and np.ptp(change) > _LARGE),
            )
        )
    return tuple(made)


def drift_notices(drifts: Sequence[FrictionDrift]) -> list[str]:
    """The sentence on friction that drifts, where it does so by more than an accident."""
    told = [x.text() for x in drifts if x.significant]
    if not told:
        return []
    return [
        f"Friction drifts: {'; '.join(told)}. The model has its mean; drives warm up: take logs "
        f"of the robot as warm as it works."
    ]


def of_friction(columns: Columns, rows: JointEquations) -> NDArray[np.bool_]:
    """Flags of a joint's columns that are friction: neither bodies nor constant torques, which
    have other causes, nor gains."""
    end = columns.base + columns.friction_size
    of_friction = (rows.unknowns >= columns.base) & (rows.unknowns < end)
    law = (rows.unknowns - columns.base) % max(len(columns.friction), 1)
    constant = np.isin(law, [k for k, x in enumerate(columns.friction) if x.law.is_constant])
    return np.asarray(of_friction & ~constant)


def _blocks(found: LogEquations) -> tuple[NDArray[np.intp], Array, Array]:
    """The block of each kept sample, and each block's log and time."""
    numbers, logs, times, count = [], [], [], 0
    for k, p in enumerate(found.prepared):
        t = p.log.time[p.places]
        if not len(t):
            continue
        whole = float(t[-1] - t[0])
        parts = min(_MOST, max(1, int(whole / _BLOCK)))
        edges = np.linspace(t[0], t[-1], parts + 1)
        numbers.append(count + np.clip(np.searchsorted(edges, t, "right") - 1, 0, parts - 1))
        logs += [float(k)] * parts
        times += list(0.5 * (edges[1:] + edges[:-1]))
        count += parts
    return np.concatenate(numbers), np.array(logs), np.array(times)


def _temperatures(found: LogEquations, j: int, blocks: NDArray[np.intp]) -> Array:
    """The mean temperature of a joint in each block, °C, NaN where no log tells it."""
    parts = [
        np.full(len(p.places), np.nan)
        if p.log.temperature is None
        else p.log.temperature[p.places, j]
        for p in found.prepared
    ]
    given = np.concatenate(parts)
    return np.asarray(
        [np.mean(given[blocks == k]) for k in range(int(blocks.max()) + 1)], dtype=float
    )
