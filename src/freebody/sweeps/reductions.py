"""Reductions of many values: numbers gathered tile by tile and joined in order.

A value that is NaN counts in none of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, KindError, UnknownNameError

Gathered = dict[str, np.ndarray]
"""Arrays (R, *core, ...) by accumulator."""


@dataclass(frozen=True)
class Accumulator:
    """A pair of functions for a reduction: to gather values (R, *core, C), given the number of
    their first column, into (R, *core, ...); and to join two such results, earlier columns
    first."""

    gather: Callable[[Array, int], np.ndarray]
    join: Callable[[np.ndarray, np.ndarray], np.ndarray]


_STEPS, _LEAST, _DOUBLINGS = 6, -30, 70
_BINS = _DOUBLINGS << _STEPS
QUANTILE_ERROR = 0.5 / (1 << _STEPS)
"""Relative error of a quantile, which below 2**-30 is told as 0."""


def _bins(x: Array) -> np.ndarray:
    """The index of each value's bin: for each sign 64 bins in each doubling from 2**-30 to 2**40,
    and one for all smaller values; bins are in the order of a float's bits."""
    level = np.abs(x).view(np.int64)  # and what follows in place: this is most of a quantile's time
    level >>= 52 - _STEPS
    level -= ((1023 + _LEAST) << _STEPS) - 1
    np.maximum(level, 0, out=level)
    np.minimum(level, _BINS + 1, out=level)
    sign = x.view(np.int64) >> 63
    level ^= sign  # with the next line -level, where the number is negative
    level -= sign
    level += _BINS + 1
    return level


def _histogram(x: Array, first: int) -> np.ndarray:
    columns, width = x.shape[-1], 2 * _BINS + 3
    flat = x.reshape(-1, columns)
    place = _bins(flat)
    place += np.arange(len(flat))[:, None] * width
    lacking = np.isnan(flat)
    counted = place[~lacking] if lacking.any() else place.ravel()
    counts = np.bincount(counted, minlength=len(flat) * width)
    return counts.reshape(*x.shape[:-1], width)


def _quantile(counts: Array, share: float) -> Array:
    """The middle of the bin that holds the value of a given rank, such as 0.99."""
    total = np.cumsum(counts, axis=-1)
    rank = np.maximum(np.ceil(share * total[..., -1:]), 1)
    bins = np.argmax(total >= rank, axis=-1) - (_BINS + 1)
    level = np.abs(bins)
    edge = (np.int64(((1023 + _LEAST) << _STEPS) - 1) + level) << (52 - _STEPS)
    middle = np.ascontiguousarray(edge).view(np.float64) * 1.0
    after = np.ascontiguousarray(edge + (np.int64(1) << (52 - _STEPS))).view(np.float64)
    value = np.where(level == 0, 0.0, 0.5 * (middle + after))
    value = np.where(level > _BINS, np.inf, value)
    return np.where(total[..., -1] == 0, np.nan, np.sign(bins) * value)


def _place(key: Callable[[Array], Array]) -> Accumulator:
    """The accumulator of the largest key and the column where it first occurs, -1 for none: (...,
    2)."""

    def gather(x: Array, first: int) -> Array:
        keys, lacking = key(x), np.isnan(x)
        if lacking.any():
            keys = np.where(lacking, -np.inf, keys)
        index = np.argmax(keys, axis=-1)
        value = np.take_along_axis(keys, index[..., None], axis=-1)[..., 0]
        lacking = lacking.all(axis=-1)
        return np.stack([value, np.where(lacking, -1.0, index + first)], axis=-1)

    def join(a: Array, b: Array) -> Array:
        later = (b[..., 0] > a[..., 0]) | (a[..., 1] < 0)
        return np.where(later[..., None], b, a)

    return Accumulator(gather, join)


def _total(x: Array) -> Array:
    """The sum of the values that are not NaN."""
    lacking = np.isnan(x)
    return np.add.reduce(np.where(lacking, 0.0, x) if lacking.any() else x, axis=-1)


def _end(extreme: np.ufunc, key: Callable[[Array], Array]) -> Accumulator:
    """The accumulator of the largest or smallest key; since processors may pick any of equal zeros
    and NaNs, these become 0 and the plain NaN."""

    def plain(x: Array) -> Array:
        return np.where(np.isnan(x), np.nan, x + 0.0)

    return Accumulator(
        lambda x, first: plain(extreme.reduce(key(x), axis=-1)), lambda a, b: plain(extreme(a, b))
    )


_ACCUMULATORS = {
    "max": _end(np.fmax, lambda x: x),
    "min": _end(np.fmin, lambda x: x),
    "peak": _end(np.fmax, np.abs),
    "sum": Accumulator(lambda x, first: _total(x), np.add),
    "squares": Accumulator(lambda x, first: _total(x * x), np.add),
    "count": Accumulator(lambda x, first: x.shape[-1] - np.isnan(x).sum(axis=-1), np.add),
    "histogram": Accumulator(_histogram, np.add),
    "argmax": _place(lambda x: x),
    "argmin": _place(lambda x: -x),
    "argpeak": _place(np.abs),
}


@dataclass(frozen=True)
class SweepReduction:
    """A reduction: its name, the numbers to gather for it, and the function from these to its value
    (R, *core)."""

    name: str
    needs: tuple[str, ...]
    finish: Callable[[Gathered], Array]
    meaning: str
    of_place: bool = False
    """Whether the value is the number of a column."""


def _divided(total: Array, count: Array) -> Array:
    return np.where(count == 0, np.nan, total / np.maximum(count, 1))


_REDUCTIONS = {
    x.name: x
    for x in (
        SweepReduction("max", ("max",), lambda g: g["max"], "largest value"),
        SweepReduction("min", ("min",), lambda g: g["min"], "smallest value"),
        SweepReduction("peak", ("peak",), lambda g: g["peak"], "largest absolute value"),
        SweepReduction(
            "mean", ("sum", "count"), lambda g: _divided(g["sum"], g["count"]), "arithmetic mean"
        ),
        SweepReduction(
            "rms",
            ("squares", "count"),
            lambda g: np.sqrt(_divided(g["squares"], g["count"])),
            "root of the mean square",
        ),
        *(
            SweepReduction(
                f"arg{end}",
                (f"arg{end}",),
                lambda g, key=f"arg{end}": g[key][..., 1],
                f"where the {words} value first occurs",
                True,
            )
            for end, words in (
                ("max", "largest"),
                ("min", "smallest"),
                ("peak", "largest absolute"),
            )
        ),
    )
}
_PERCENT = re.compile(r"p(\d{1,2}(?:\.\d{1,6})?|100)")


def reductions(given: Any) -> tuple[SweepReduction, ...]:
    """Reductions by their names, one or several; a quantile as "p99" or "p99.9"."""
    names = (given,) if isinstance(given, str) else given
    if not isinstance(names, Sequence) or not all(isinstance(x, str) for x in names) or not names:
        raise KindError("sweep", "reduce", given, 'a name or several, as "max" or ["peak", "rms"]')
    if len(set(names)) < len(names):
        raise FreebodyError("sweep: reduce= names each reduction once.")
    return tuple(map(_named, names))


def _named(name: str) -> SweepReduction:
    percent = _PERCENT.fullmatch(name)
    if percent is None:
        if name not in _REDUCTIONS:
            raise UnknownNameError("reduction", name, "sweep", [*_REDUCTIONS, "p50", "p99"])
        return _REDUCTIONS[name]
    share = float(percent[1]) / 100.0
    return SweepReduction(
        name,
        ("histogram",),
        lambda g: _quantile(g["histogram"], share),
        f"{percent[1]} % quantile, from a histogram: within {100 * QUANTILE_ERROR:.1f} % of a "
        f"value of that rank; below 1e-9 told as 0, beyond 1.1e12 as infinite",
    )


def needed(reductions: Sequence[SweepReduction]) -> tuple[str, ...]:
    """Names of the accumulators that some reductions need."""
    return tuple(dict.fromkeys(key for x in reductions for key in x.needs))


def finished(reductions: Sequence[SweepReduction], found: Gathered) -> Gathered:
    """The values of all reductions, from the numbers gathered for some rows."""
    return {x.name: x.finish(found) for x in reductions}


def gathered(values: Sequence[Array], wanted: Sequence[str], first: int) -> list[Gathered]:
    """The numbers that reductions need, gathered from each output's values in a tile, (R, C,
    *core)."""
    if not wanted:
        return []
    # columns side by side: NumPy reduces them ten times as fast
    turned = [np.ascontiguousarray(np.moveaxis(x, 1, -1)) for x in values]
    return [{key: _ACCUMULATORS[key].gather(x, first) for key in wanted} for x in turned]


def joined(a: list[Gathered], b: list[Gathered]) -> list[Gathered]:
    """The numbers gathered for the same rows from two ranges of columns, a before b, joined."""
    return [
        {key: _ACCUMULATORS[key].join(x[key], y[key]) for key in x}
        for x, y in zip(a, b, strict=True)
    ]
