"""The axes of a sweep: the quantities that vary along each, and their values in any part of the
grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, KindError, listed
from freebody.motion.motion import Motion
from freebody.sweeps.samples import Samples

Read = Callable[[str, Any], tuple[str, Array]]
"""(name, values) -> the name in full, and the values (n, *core), checked."""


@dataclass(frozen=True)
class SweepAxis:
    """An axis of a sweep's grid: its name, and all quantities that vary together along it, each (n,
    *core)."""

    name: str
    given: Mapping[str, Array]
    times: Array | None = None
    """Times of a motion along the axis, s."""

    @property
    def size(self) -> int:
        """Number of points along the axis."""
        if isinstance(self.given, Samples):
            return self.given.count
        return len(next(iter(self.given.values())))

    def at(self, places: slice | np.ndarray) -> dict[str, Array]:
        """The values at the given places of the axis, (*places, *core), by name."""
        if isinstance(self.given, Samples):
            return self.given.at(places)
        return {name: array[places] for name, array in self.given.items()}


def read_axes(over: Any, read: Read, inputs: Sequence[str] | None) -> tuple[SweepAxis, ...]:
    """The axes named in `over`, in its order.

    inputs: those of the function, of which a motion gives positions, rates and accelerations; None
    where any may be given.
    """
    if not isinstance(over, Mapping) or not over:
        raise KindError(
            "sweep",
            "over",
            over,
            "a dict of what varies, as {'link2.mass': np.linspace(1, 3, 20), 'motion': motion}",
        )
    axes = tuple(_axis(name, value, read, inputs) for name, value in over.items())
    every = [name for axis in axes for name in axis.given]
    twice = [name for name in dict.fromkeys(every) if every.count(name) > 1]
    if twice:
        raise FreebodyError(f"sweep: {twice[0]!r} varies along two axes of over; give it once.")
    return axes


def _axis(name: Any, value: Any, read: Read, inputs: Sequence[str] | None) -> SweepAxis:
    if not isinstance(name, str):
        raise KindError("sweep", "a key of over", name, "a name")
    times = None
    if isinstance(value, Samples):  # their ranges are read instead of all points
        full = {key: read(key, np.stack(pair))[0] for key, pair in value.bounds.items()}
        return SweepAxis(name, value.renamed(full))
    if isinstance(value, Motion):
        times, value = value.t, _states(name, value, inputs)
    if not isinstance(value, Mapping):
        full, array = read(name, value)
        given = {full: array}
    else:
        given = dict(read(key, each) for key, each in value.items())
        if not given or len(given) < len(value):
            raise FreebodyError(f"sweep: over[{name!r}] must name each thing that varies once.")
    sizes = {key: len(array) for key, array in given.items()}
    if len(set(sizes.values())) > 1:
        raise FreebodyError(
            f"sweep: what varies together along {name!r} has different lengths: "
            f"{listed(f'{key} {size}' for key, size in sizes.items())}."
        )
    if not min(sizes.values()):
        raise FreebodyError(f"sweep: over[{name!r}] has no value; give at least one.")
    return SweepAxis(name, given, times)


def _states(name: str, motion: Motion, inputs: Sequence[str] | None) -> dict[str, Array]:
    """The positions, rates and accelerations of a motion that the function takes, by name."""
    found = {
        key: getattr(motion, key) for key in ("q", "qd", "qdd") if inputs is None or key in inputs
    }
    if not found:
        raise FreebodyError(
            f"sweep: over[{name!r}] is a motion, and the function takes neither q, qd nor qdd."
        )
    return found


@dataclass(frozen=True)
class SweepGrid:
    """The grid of a sweep as a table: rows and columns are products of some axes, the last of which
    runs quickest; results are reduced along the columns."""

    rows: tuple[SweepAxis, ...]
    columns: tuple[SweepAxis, ...]
    constants: dict[str, Array]
    """Inputs and numbers that are the same at all points."""

    @property
    def shape(self) -> tuple[int, int]:
        """The number of rows and of columns."""
        return prod(axis.size for axis in self.rows), prod(axis.size for axis in self.columns)

    def part(self, rows: range, columns: range) -> dict[str, Array]:
        """The values in a part of the table by name, (R or 1, C or 1, *core)."""
        found = {name: value[None, None] for name, value in self.constants.items()}
        for axis, index in zip(self.rows, _places(self.rows, rows), strict=True):
            found |= {name: array[:, None] for name, array in axis.at(index).items()}
        for axis, index in zip(self.columns, _places(self.columns, columns), strict=True):
            found |= {name: array[None] for name, array in axis.at(index).items()}
        return found

    def row_points(self) -> dict[str, Array]:
        """The values at each row by name, (R, ...)."""
        rows = range(self.shape[0])
        return {
            name: array
            for axis, index in zip(self.rows, _places(self.rows, rows), strict=True)
            for name, array in axis.at(index).items()
        }

    def column(self, index: np.ndarray) -> dict[str, tuple[np.ndarray, dict[str, Array]]]:
        """For each axis of the columns the places (-1: none) and the values (NaN: none) that belong
        to given column numbers."""
        none = index < 0
        sizes = [axis.size for axis in self.columns]
        places = np.unravel_index(np.where(none, 0, index), sizes)
        found = {}
        for axis, place in zip(self.columns, places, strict=True):
            values = axis.at(place)
            for array in values.values():
                array[none] = np.nan
            found[axis.name] = np.where(none, -1, place), values
        return found

    def point(self, row: int, column: int) -> dict[str, int]:
        """The place on each axis of the point in a row and column."""
        found = {}
        for axes, at in ((self.rows, row), (self.columns, column)):
            places = _places(axes, range(at, at + 1))
            for axis, place in zip(axes, places, strict=True):
                found[axis.name] = place.start if isinstance(place, slice) else int(place[0])
        return found


def _places(axes: Sequence[SweepAxis], among: range) -> list[Any]:
    """The places on each axis of consecutive points of the axes' product; for a single axis a
    slice, which copies nothing."""
    if len(axes) == 1:
        return [slice(among.start, among.stop)]
    if not axes:
        return []
    return list(np.unravel_index(np.arange(among.start, among.stop), [x.size for x in axes]))
