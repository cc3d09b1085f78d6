"""The result of a sweep as a dataset: arrays joined block by block, and labelled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, OutOfMemoryError, warn
from freebody.model.doubts import attribute, doubts_used
from freebody.model.model import Model
from freebody.sweeps.axes import SweepAxis, SweepGrid
from freebody.sweeps.evaluation import BlockResult, FailedPoint, SweepBlock, SweepTask, with_more
from freebody.sweeps.functions import SweptFunction
from freebody.sweeps.reductions import Gathered, SweepReduction, finished, joined

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = 10
"""The number of failed points that the attributes name."""


class SweepArrays:
    """The arrays of a sweep's result, filled as blocks arrive."""

    def __init__(self, task: SweepTask, held: bool = True):
        """Allocate the arrays; held: whether values are kept here, or only what failed."""
        self.grid, self.reductions = grid, reductions = task.grid, task.reductions
        self.outputs = task.outputs if held else ()
        self._whole_rows = task.whole_rows
        rows, columns = grid.shape
        self.reasons: list[FailedPoint] = []
        self.values: dict[tuple[str, str], Array] = {}
        """Arrays by output and reduction (rows, *core), or (rows, columns, *core) and no
        reduction."""
        self._open: list[Gathered] | None = None
        names = [x.name for x in reductions] or [""]
        try:
            self.failed = np.zeros(rows, dtype=np.int64)
            for output, core in self.outputs:
                shape = (rows, *core) if reductions else (rows, columns, *core)
                self.values |= {(output, name): np.full(shape, np.nan) for name in names}
        except MemoryError:
            raise OutOfMemoryError(
                f"sweep: the {rows * columns:.3g} points of {task.outputs[0][0]} do not fit into "
                f"memory; give reduce=, or fewer points."
            ) from None

    def add(self, block: SweepBlock, result: BlockResult) -> None:
        """Put the next block's results in their place."""
        rows = slice(block.rows.start, block.rows.stop)
        self.failed[rows] += result.failed
        self.reasons = with_more(self.reasons, result.reasons, _SHOWN)
        for (output, _), values in zip(self.outputs, result.values, strict=False):
            self.values[output, ""][rows, block.columns.start : block.columns.stop] = values
        if result.gathered:
            found = result.gathered
            self._open = found if self._open is None else joined(self._open, found)
            if self._whole_rows or block.columns.stop == self.grid.shape[1]:
                self._finish(rows)

    def _finish(self, rows: slice) -> None:
        """Compute the reductions of rows whose blocks have all arrived."""
        for (output, _), found in zip(self.outputs, self._open or (), strict=True):
            done = found if self._whole_rows else finished(self.reductions, found)
            for name, values in done.items():
                self.values[output, name][rows] = values
        self._open = None


def _about(model: Model, function: SweptFunction, arrays: SweepArrays) -> dict[str, Any]:
    """The attributes of a result; warns where some points failed, raises an error where all did."""
    grid, points = arrays.grid, arrays.grid.shape[0] * arrays.grid.shape[1]
    failed = int(arrays.failed.sum())
    reasons = [_sentence(grid, point) for point in arrays.reasons]
    if failed == points:
        raise FreebodyError(f"sweep: no point has a value; {reasons[0]}")
    if failed:
        warn(
            f"sweep: {failed} of {points} points have no value, and count in no reduction; the "
            f"first: {reasons[0]}",
        )
    found = {"model": model.name, "points": points, "failed": failed, "failures": reasons}
    return found | attribute(doubts_used(model, *function.touches))


def lazy_dataset(
    model: Model,
    function: SweptFunction,
    arrays: SweepArrays,
    stored: xr.Dataset,
) -> xr.Dataset:
    """All values as a dataset read from a store on access, over `point` (the rows of the table) and
    the columns."""
    about, grid = _about(model, function, arrays), arrays.grid
    coordinates: dict[str, Any] = {}
    for axis in grid.columns:
        coordinates |= _coordinates(axis)
    for name, array in grid.row_points().items():
        coordinates[name] = (("point", *(f"{name}_{k}" for k in range(array.ndim - 1))), array)
    front = ("point", *(x.name for x in grid.columns))
    names = dict(zip(("row", "column"), front, strict=True))
    for output, values in stored.data_vars.items():
        inner = _dimensions(model, function, str(output), values.shape[2:], coordinates, front)
        names |= dict(zip(map(str, values.dims[2:]), inner, strict=True))
    named = stored.rename(names).assign(failed=(("point",), arrays.failed))
    return named.assign_coords(coordinates).assign_attrs(about)


def dataset(model: Model, function: SweptFunction, arrays: SweepArrays) -> xr.Dataset:
    """The result as a dataset over the axes that are not reduced."""
    import xarray as xr

    about, grid = _about(model, function, arrays), arrays.grid
    axes = grid.rows if arrays.reductions else grid.rows + grid.columns
    coordinates: dict[str, Any] = {}
    for axis in axes:
        coordinates |= _coordinates(axis)
    named: dict[str, Any] = {}
    front, sizes = tuple(x.name for x in axes), tuple(x.size for x in axes)
    for reduction in arrays.reductions or (None,):
        for output, core in arrays.outputs:
            inner = _dimensions(model, function, output, core, coordinates, front)
            values = arrays.values[output, reduction.name if reduction else ""]
            if reduction is None:
                named[output] = (front + inner, values.reshape(sizes + core))
            elif not reduction.of_place:
                about_it = {"long_name": reduction.meaning}
                shaped = values.reshape(sizes + core)
                named[f"{output}_{reduction.name}"] = (front + inner, shaped, about_it)
            else:
                named |= _places(grid, reduction, output, values, (front, sizes), inner)
    kept = tuple(x.name for x in grid.rows)
    named["failed"] = (kept, arrays.failed.reshape([x.size for x in grid.rows]))
    clash = sorted(set(named) & (set(coordinates) | set(front)))
    if clash:
        raise FreebodyError(f"sweep: {clash[0]!r} is a result's name; call the axis otherwise.")
    return xr.Dataset(named, coordinates, about)


def _sentence(grid: SweepGrid, point: FailedPoint) -> str:
    place = ", ".join(f"{name} {at}" for name, at in grid.point(*point[:2]).items())
    return f"at {place}: {point.reason}"


def _coordinates(axis: SweepAxis) -> dict[str, Any]:
    """Coordinates along an axis: its times, and every quantity that varies."""
    found: dict[str, Any] = {} if axis.times is None else {"t": ((axis.name,), axis.times)}
    for name, array in axis.given.items():
        inner = tuple(f"{name}_{k}" for k in range(array.ndim - 1))
        found[name] = ((axis.name, *inner), array)
    return found


_NAMED = {"nv": ("coordinate", "velocity_names"), "nq": ("position", "position_names")}


def _dimensions(
    model: Model,
    function: SweptFunction,
    output: str,
    core: tuple[int, ...],
    coordinates: dict[str, Any],
    front: tuple[str, ...],
) -> tuple[str, ...]:
    """Names of the dimensions of an output's core, with joints labelled by name and other entries
    by number."""
    labels = function.dimensions(output) or ("",) * len(core)
    found: list[str] = []
    for k, dimension in enumerate(labels):
        name, names = _NAMED.get(dimension, ("", ""))
        if not name or name in found or name in front:
            name = f"{output}_{k}"
        else:
            coordinates[name] = list(getattr(model, names))
        found.append(name)
    return tuple(found)


def _places(
    grid: SweepGrid,
    reduction: SweepReduction,
    output: str,
    values: Array,
    front: tuple[tuple[str, ...], tuple[int, ...]],
    inner: tuple[str, ...],
) -> dict[str, Any]:
    """Variables for the place of a reduction's result on each reduced axis (-1: none), and for the
    values there."""
    (dims, sizes), found = front, {}
    core = values.shape[1:]
    for axis, (place, given) in grid.column(values.astype(np.int64)).items():
        name = f"{output}_{reduction.name}"
        about = {"long_name": f"{reduction.meaning}, place on {axis}"}
        found[f"{name}_{axis}"] = (dims + inner, place.reshape(sizes + core), about)
        for key, array in given.items():
            further = tuple(f"{key}_{k}" for k in range(array.ndim - len(core) - 1))
            shaped = array.reshape(sizes + core + array.shape[1 + len(core) :])
            label = f"{name}_{key}" if key != axis else f"{name}_{key}_value"
            found[label] = (dims + inner + further, shaped)
    return found
