"""The times of a log put in order, and its samples on a uniform grid.

A logger's clock is set while it runs, packets overtake each other, rows come twice or not at all:
each is told, and what lies between samples that are far apart is marked as not measured.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.identification.logs.quantities import TIME_UNITS
from freebody.outputs.display import counted

FEWEST = 30
"""Samples that a log needs."""
_OVERTAKES = 20
"""Rows by which a row may stand in the wrong place before the clock is blamed."""
_BREAKS = 0.01  # of the rows: where more times go back, no clock was set so often
_GAP = 5.0  # steps: samples farther apart have nothing measured between them
_SEAM = 6.0
"""Steps put between two samples between which the clock was set: a gap, of unknown length."""
_LONGEST = 2.0
"""Time (s) to which longer gaps are shortened."""
_EVEN = 0.02  # of a step: samples nearer than this to the grid are taken to lie on it
_ROUND = 0.02  # of a rate: how far from a round one a jittered one may be
_RATES = (10, 20, 25, 30, 40, 50, 60, 100, 120, 125, 200, 240, 250, 400, 500, 800, 1000, 2000, 4000)
_SLOWEST_STEP = 0.5  # s
RowPlace = Callable[[int], str]
"""A function that tells where a row stands in the file: "line 12"."""
RowRefusal = Callable[[str, int | None], Exception]
"""A function that makes the error of a text and a row."""


class RowsInOrder(NamedTuple):
    """Rows of a log by time."""

    rows: NDArray[np.int64]
    """Rows (m,) that stay, in order."""
    times: Array
    """Times (m,) from 0, s, increasing; where the clock was set a gap stands between."""
    notices: tuple[str, ...]


def in_order(times: Array, unit: str | None, where: RowPlace, refuse: RowRefusal) -> RowsInOrder:
    """The rows by their times (n,), with notices on units, duplicates, disorder and clocks that
    were set. Raises what `refuse` makes where the times do not advance, or go back too often."""
    forward = np.diff(times)
    forward = forward[forward > 0.0]
    if not len(forward):
        raise refuse(
            f"the times do not advance: all rows have t = {times[0]:.6g}; name another column as "
            f"the time.",
            0,
        )
    step = float(np.median(forward))
    notices = list[str]()
    if unit is None:
        unit = next(
            name for name in ("s", "ms", "us", "ns")
            if step * TIME_UNITS[name] < _SLOWEST_STEP or name == "ns"
        )  # fmt: skip
        if unit != "s":
            notices.append(
                f"The times advance by {step:.6g} a row and are taken as {unit}; write "
                f"'t ({unit})' in the header, or another unit."
            )
    t, step = (times - times[0]) * TIME_UNITS[unit], step * TIME_UNITS[unit]
    rows = np.arange(len(t))
    back = np.flatnonzero(np.diff(t) < 0.0)
    if len(back):
        order = np.argsort(t, kind="stable")
        if np.abs(order - rows).max() <= _OVERTAKES:
            notices.append(
                f"{counted(int((order != rows).sum()), 'row')} stood in another order than their "
                f"times ({where(int(back[0]) + 1)} first) and were put in order."
            )
            rows, t = order, t[order]
        elif len(back) > max(3.0, _BREAKS * len(t)):
            k = int(back[0]) + 1
            raise refuse(
                f"the times go back at {len(back)} places, here from {times[k - 1]:.6g} to "
                f"{times[k]:.6g}; sort the rows, or give a file for each run.",
                k,
            )
        else:
            notices += [_set(times, k + 1, unit, where) for k in back.tolist()]
            changes = np.diff(t, prepend=t[0])
            changes[back + 1] = _SEAM * step
            t = np.cumsum(changes)
    return _without_twins(rows, t - t[0], step, notices, where)


def _set(times: Array, k: int, unit: str, where: RowPlace) -> str:
    """A sentence on a clock that was set back."""
    return (
        f"The clock goes back from {times[k - 1]:.6g} to {times[k]:.6g} {unit} ({where(k)}): "
        f"nothing is taken as measured around that place."
    )


def _without_twins(
    rows: NDArray[np.int64], t: Array, step: float, notices: list[str], where: RowPlace
) -> RowsInOrder:
    """The rows without those that repeat a time; gaps longer than `_LONGEST` are shortened."""
    twins = np.append(False, np.diff(t) == 0.0)
    if twins.any():
        first, count = int(np.argmax(twins)), int(twins.sum())
        text = (
            f"{counted(count, 'row')} {'repeat' if count > 1 else 'repeats'} the time of the row "
            f"before ({where(int(rows[first]))} first) and {'are' if count > 1 else 'is'} left out."
        )
        if 4 * count > len(t):
            text += " If the times are rounded, leave them out and write rate = … (rows a second)."
        notices.append(text)
        rows, t = rows[~twins], t[~twins]
    changes = np.diff(t, prepend=t[0])
    long = np.flatnonzero(changes > _LONGEST)
    if len(long) and step < _LONGEST / _GAP:
        k = int(long[0])
        notices.append(
            f"{counted(len(long), 'gap')} of up to {changes.max():.4g} s ({where(int(rows[k]))} "
            f"first) {'are' if len(long) > 1 else 'is'} shortened to {_LONGEST:g} s."
        )
        changes[long] = _LONGEST
    return RowsInOrder(rows, np.cumsum(changes), tuple(notices))


class LogGrid(NamedTuple):
    """A uniform grid of times, and where samples stand on it."""

    times: Array
    """Times (n,) of the grid, s."""
    samples: Array
    """Times (m,) of the samples, on the grid where they are as good as on it."""
    measured: NDArray[np.bool_]
    """Flags (n,): whether samples lie around a time."""
    notices: tuple[str, ...]

    def values(self, x: Array) -> Array:
        """Values (n, k) on the grid of samples x (m, k): those that lie on it as they are, else on
        straight lines between neighbours."""
        if len(self.times) == len(self.samples) and np.array_equal(self.times, self.samples):
            return x
        return np.stack([np.interp(self.times, self.samples, column) for column in x.T], axis=-1)


def grid_of(t: Array, rate: float | None, where: RowPlace) -> LogGrid:
    """The uniform grid for samples at the times t (m,); rate: Hz, by default that of the
    samples."""
    steps = np.diff(t)
    middle = float(np.median(steps))
    whole = steps <= _GAP * middle
    notices = list[str]()
    if not whole.all():
        k = int(np.argmin(whole)) + 1
        notices.append(
            f"{counted(int((~whole).sum()), 'gap')} of up to {steps.max():.4g} s ({where(k)} "
            f"first): nothing is taken as measured there."
        )
    even = _even(t, middle)
    own = even is not None and (rate is None or abs(rate * even - 1.0) < 1e-9)
    if even is not None and own:
        places = np.rint(t / even)
        samples = places * even
        times: Array = np.arange(int(places[-1]) + 1, dtype=np.float64) * even
    else:
        mean = float(steps[whole].mean())
        chosen = rate or (_round(1.0 / mean) if even is None else 1.0 / even)
        samples = t
        times = np.arange(int(np.floor(t[-1] * chosen * (1.0 + 1e-12))) + 1) / chosen
        spread = (
            ""
            if even is not None
            else f", {1e3 * steps[whole].min():.3g} to {1e3 * steps[whole].max():.3g} ms apart,"
        )
        notices.append(
            f"The samples, {1.0 / mean:.4g} a second on average{spread} were brought to a grid of "
            f"{chosen:.4g} Hz by straight lines between them."
        )
    after = np.searchsorted(samples, times, side="left").clip(1, len(samples) - 1)
    on_sample = np.isin(times, samples)
    return LogGrid(times, samples, np.asarray(whole[after - 1] | on_sample), tuple(notices))


def _even(t: Array, step: float) -> float | None:
    """The step of an even grid on which all samples lie, gaps between them or not; None where they
    do not."""
    places = np.cumsum(np.rint(np.diff(t, prepend=0.0) / step))
    step = float(places @ t / (places @ places))
    even = np.abs(t - places * step).max() <= _EVEN * step
    return step if even and (np.diff(places) > 0).all() else None


def _round(rate: float) -> float:
    """The nearest usual rate, or the rate itself where none is near."""
    nearest = min(_RATES, key=lambda x: abs(x / rate - 1.0))
    return float(nearest) if abs(nearest / rate - 1.0) <= _ROUND else rate
