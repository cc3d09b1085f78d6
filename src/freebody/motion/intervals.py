"""Scalars that are intervals: an algorithm evaluated over them encloses all values that it takes
where its inputs are in theirs (Moore 1966).

Bounds are arrays of floats, rounded to the nearest number: an enclosure is right but for rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from freebody.arrays import Array

_TURN = 2.0 * np.pi


class Interval:
    """All numbers from `low` to `high`, arrays of one shape."""

    __slots__ = ("high", "low")
    __array_ufunc__ = None  # array * interval is ours

    def __init__(self, low: Any, high: Any):
        self.low, self.high = low, high

    @property
    def size(self) -> Array:
        """The largest size of its numbers."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of its bounds together."""
        return np.broadcast_shapes(np.shape(self.low), np.shape(self.high))

    def __getitem__(self, index: Any) -> Interval:
        return Interval(self.low[index], self.high[index])

    def __add__(self, other: Any) -> Interval:
        low, high = _ends(other)
        return Interval(self.low + low, self.high + high)

    __radd__ = __add__

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Any) -> Interval:
        return self + (-other)

    def __rsub__(self, other: Any) -> Interval:
        return -self + other

    def __mul__(self, other: Any) -> Interval:
        return _hull([x * y for x in _ends(self) for y in _ends(other)])

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Interval:
        return self * _inverse(*_ends(other))

    def __rtruediv__(self, other: Any) -> Interval:
        return _inverse(*_ends(self)) * other

    def elementary(self, name: str, operands: tuple[Any, ...]) -> Any:
        """The function of `elementary` of that name; any number, where nothing is known of it."""
        with np.errstate(all="ignore"):
            ends = [_ends(x) for x in operands]
            if name in _GROWING:
                return Interval(*(_GROWING[name](*side) for side in zip(*ends, strict=True)))
            known = _FUNCTIONS.get(name)
            return known(*ends) if known else _anything(*ends)


Bounds = tuple[Any, Any]


def _ends(x: Any) -> Bounds:
    return (x.low, x.high) if isinstance(x, Interval) else (x, x)


def _hull(values: Sequence[Any]) -> Interval:
    """The interval that holds arrays of numbers."""
    values = np.broadcast_arrays(*values)
    return Interval(np.minimum.reduce(values), np.maximum.reduce(values))


def _anything(*ends: Bounds) -> Interval:
    shape = np.broadcast_shapes(*(np.shape(x) for pair in ends for x in pair))
    return Interval(np.full(shape, -np.inf), np.full(shape, np.inf))


def _inverse(low: Any, high: Any) -> Interval:
    """1 over an interval; any number where 0 is in it."""
    with np.errstate(divide="ignore"):
        split = (np.asarray(low) <= 0.0) & (np.asarray(high) >= 0.0)
        one, two = 1.0 / np.asarray(high, dtype=float), 1.0 / np.asarray(low, dtype=float)
    return Interval(np.where(split, -np.inf, one), np.where(split, np.inf, two))


def _absolute(x: Bounds) -> Interval:
    sizes = [np.abs(end) for end in x]
    least = np.where((x[0] <= 0.0) & (x[1] >= 0.0), 0.0, np.minimum(*sizes))
    return Interval(least, np.maximum(*sizes))


def _less(a: Bounds, b: Bounds) -> Interval:
    return Interval(np.where(a[1] < b[0], 1.0, 0.0), np.where(a[0] < b[1], 1.0, 0.0))


def _less_equal(a: Bounds, b: Bounds) -> Interval:
    return Interval(np.where(a[1] <= b[0], 1.0, 0.0), np.where(a[0] <= b[1], 1.0, 0.0))


def _equal(a: Bounds, b: Bounds) -> Interval:
    sure = (a[0] == a[1]) & (b[0] == b[1]) & (a[0] == b[0])
    meet = (a[0] <= b[1]) & (b[0] <= a[1])
    return Interval(np.where(sure, 1.0, 0.0), np.where(meet, 1.0, 0.0))


def _where(condition: Bounds, a: Bounds, b: Bounds) -> Interval:
    never = (condition[0] == 0.0) & (condition[1] == 0.0)
    always = (condition[0] > 0.0) | (condition[1] < 0.0)
    ends = (
        np.where(always, x, np.where(never, y, choose(x, y)))
        for x, y, choose in zip(a, b, (np.minimum, np.maximum), strict=True)
    )
    return Interval(*ends)


def _wave(function: Callable[[Any], Any], top: float) -> Callable[[Bounds], Interval]:
    """A sine or cosine of an interval, which is largest at `top` and whole turns from it."""

    def waved(x: Bounds) -> Interval:
        low, high = np.broadcast_arrays(*map(np.asarray, x))
        one, two = function(low), function(high)

        def holds(place: float) -> Any:
            return np.floor((high - place) / _TURN) >= np.ceil((low - place) / _TURN)

        return Interval(
            np.where(holds(top + np.pi), -1.0, np.minimum(one, two)),
            np.where(holds(top), 1.0, np.maximum(one, two)),
        )

    return waved


_GROWING: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "tanh": np.tanh,
    "sign": np.sign,
    "minimum": np.minimum,
    "maximum": np.maximum,
}
"""Functions that fall with none of their operands."""

_FUNCTIONS: dict[str, Callable[..., Interval]] = {
    "absolute": _absolute,
    "less": _less,
    "less_equal": _less_equal,
    "equal": _equal,
    "where": _where,
    "sin": _wave(np.sin, 0.5 * np.pi),
    "cos": _wave(np.cos, 0.0),
}


def for_each(x: Any, axes: int) -> Any:
    """A number as it is; an array or an interval of several with so many axes behind its own, for
    each of which arrays of these axes are computed."""
    several = getattr(x, "shape", ())
    return x[(..., *(None,) * axes)] if several else x


def side_by_side(columns: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """The columns (*shape, n) of numbers or arrays of a shape; an interval where one of them is."""

    def joined(ends: Sequence[Any]) -> Array:
        return np.stack([np.broadcast_to(x, shape) for x in ends], axis=-1)

    if not any(isinstance(x, Interval) for x in columns):
        return joined(columns)
    return Interval(*(joined(side) for side in zip(*map(_ends, columns), strict=True)))
