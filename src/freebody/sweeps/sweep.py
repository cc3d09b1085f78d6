"""`sweep`: a function evaluated over the grid of many parameters and states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import prod
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array, is_count
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed
from freebody.model.model import Model
from freebody.sweeps.axes import SweepAxis, SweepGrid, read_axes
from freebody.sweeps.dataset import SweepArrays, dataset, lazy_dataset
from freebody.sweeps.evaluation import BlockResult, SweepBlocks, SweepTask
from freebody.sweeps.functions import (
    FAILURES,
    FAULTS,
    SweptCallable,
    SweptFunction,
    SweptKernel,
    input_shapes,
    named_formulas,
    names_of,
    reader,
)
from freebody.sweeps.identity import computed_with, identity, needs_of
from freebody.sweeps.reductions import SweepReduction, reductions
from freebody.sweeps.run import Watched, evaluated, points_of
from freebody.sweeps.store import SweepStore
from freebody.targets import Kernel, compile_program
from freebody.targets.target import target_named

if TYPE_CHECKING:
    import xarray as xr

    from freebody.motion.simulation.run import Progress

_TILE = 1 << 18
"""Numbers of one output that are computed at once: they stay in a processor's cache."""
_BLOCK, _LARGEST_BLOCK, _BLOCKS = 1 << 20, 1 << 24, 1 << 10
"""Points of a block where the caller does not say; in large grids more, so that there are about so
many blocks."""
_LARGEST = 1 << 23
"""Numbers of one output of a block, where all values are kept: 64 MB."""
_WORTH_HOISTING = 64
"""Columns from which on a robot's own arithmetic is done once a row, instead of once a point."""


def sweep(
    model: Model,
    function: Any,
    *,
    over: Mapping[str, Any],
    at: Mapping[str, Any] | None = None,
    reduce: str | Sequence[str] | None = None,
    along: str | Sequence[str] | None = None,
    frame: str | None = None,
    reference: str = "world",
    block: int | None = None,
    store: str | PathLike[str] | None = None,
    client: Any = None,
    cpu: str | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """The values of a function at every point of a grid of many parameters and states, reduced on
    the way.

    Parameters
    ----------
    model
        The robot.
    function
        The name of a formula ("inverse_dynamics", "jacobian", … as for `fb.kernel`) or several;
        what `fb.compile` returns; or a function of (model, **what varies), which is given batches
        (rows or 1, columns or 1, ...) by name and a family where numbers of the model vary, and
        returns an array of that batch, or a dict of them.
    over
        The axes of the grid, in order. A number of the model or an input of the function with its
        values (n, ...); a name of your own with a dict of such, which vary together (`fb.samples`
        makes one); or a name with a `Motion`, whose q, qd and qdd the function gets.
    at
        Inputs and numbers that are the same at all points, by name.
    reduce
        "max", "min", "mean", "rms", "peak" (largest absolute value), a quantile ("p99", "p99.9": by
        a histogram, within 0.8 % of a value of that rank), "argmax", "argmin" or "argpeak" (the
        place on each axis, and what is given there), or several; None: all values.
    along
        Axes that are reduced; None: the last.
    frame, reference
        As for `fb.kernel`.
    block
        Points in one piece of work: sums, and so the last digits of means, depend on it but not on
        the number of processors; None: 2**20, and up to 2**24 on grids of more than 10**9 points.
    store
        Folder of a Zarr store, in which each block is put when it is done; the same call goes on
        with what is there, after whatever stopped it, and ends with the same bytes. Without reduce=
        the values stay there: they are read when they are looked at, over one axis `point` in the
        place of all but the last. Needs the extra `sweep`.
    client
        A `distributed.Client` of Dask or the address of its scheduler: blocks are evaluated by its
        workers, with the same bytes as here; None: this process. Needs the extra `sweep`.
    cpu
        A level of processors for which kernels are compiled ("x86-64-v2", "x86-64-v3", "x86-64-v4",
        "armv8-a"): all that reach it give the same bytes; None: this machine's own.
    progress
        A function that is called after each block with a text (points done, points per second, time
        left) and with the fraction done.

    Returns
    -------
    xarray.Dataset
        Over the other axes, with `failed`, how many points had no value (NaN, or refused: a mass
        below 0, a singular matrix); they count in no reduction, and its attributes name some and
        why.

    Raises
    ------
    FreebodyError
        No point has a value, or an argument is wrong.
    """
    target = _target(cpu, function)
    split = reduce is not None, along
    grid, swept = _read(model, function, over, at, frame, reference, split, target)
    chosen = reductions(reduce) if reduce is not None else ()
    outputs = _outputs(swept, grid)
    points = _block(block, outputs, chosen, grid)
    task = _task(model, grid, swept, outputs, chosen, points)
    blocks = SweepBlocks(grid.shape, points)
    if store is None:
        watched = Watched(grid, progress)
        results = map(watched, blocks, evaluated(task, blocks, None, client))
        return dataset(model, swept, _joined(SweepArrays(task), blocks, results))
    kept = SweepStore(store, task, blocks, identity(task, points), computed_with(needs_of(task)))
    missing = [x for x in blocks if not kept.holds(x)]
    watched = Watched(grid, progress, prod(grid.shape) - sum(map(points_of, missing)))
    for each, result in zip(missing, evaluated(task, missing, kept.write, client), strict=True):
        watched(each, result)
    arrays = _joined(SweepArrays(task, bool(chosen)), blocks, map(kept.read, blocks))
    if chosen:
        return kept.finish(dataset(model, swept, arrays))
    return lazy_dataset(model, swept, arrays, kept.values())


def _joined(
    arrays: SweepArrays, blocks: SweepBlocks, results: Iterator[BlockResult]
) -> SweepArrays:
    """The arrays filled with the results of all blocks, in order."""
    for each, result in zip(blocks, results, strict=True):
        arrays.add(each, result)
    return arrays


def _read(
    model: Model,
    function: Any,
    over: Any,
    at: Any,
    frame: str | None,
    reference: str,
    split: tuple[bool, str | Sequence[str] | None],
    target: str | None,
) -> tuple[SweepGrid, SweptFunction]:
    """The grid, and the function that is evaluated on it, from checked arguments.

    split: whether values are reduced, and along which axes.
    """
    if callable(function) and (frame is not None or reference != "world"):
        raise FreebodyError("sweep: frame= and reference= are those of a formula.")
    shapes = input_shapes(function, model, frame, reference)
    read = reader(model, shapes)
    axes = read_axes(over, read, None if shapes is None else list(shapes))
    constants = _constants(at, axes, read)
    names = [name for axis in axes for name in axis.given] + list(constants)
    numbers = _numbers(model, names, shapes)
    _require_inputs(shapes, names)
    rows, columns = _split(axes, *split)
    swept: SweptFunction
    if isinstance(function, Kernel):
        if numbers:
            raise FreebodyError(
                f"sweep: {numbers[0]!r} is no input of {function.program.name}, which takes "
                f"{listed(shapes or ())}."
            )
        swept = SweptKernel(_for(target, function), ())
    elif callable(function):
        swept = SweptCallable(function, model, numbers)
    else:
        swept = named_formulas(model, names_of(function), frame, reference, numbers, target)
    return SweepGrid(rows, columns, constants), swept


def _constants(at: Any, axes: Sequence[SweepAxis], read: Callable[..., Any]) -> dict[str, Array]:
    """Inputs and numbers that are the same at all points, by name; refuses any that also vary."""
    if at is not None and not isinstance(at, Mapping):
        raise KindError("sweep", "at", at, "a dict of what is the same at all points, by name")
    constants = dict(read(name, value, 0) for name, value in (at or {}).items())
    names = [name for axis in axes for name in axis.given] + list(constants)
    for name in constants:
        if names.count(name) > 1:
            raise FreebodyError(f"sweep: {name!r} is given by over and by at; give it once.")
    return constants


def _require_inputs(shapes: Mapping[str, Any] | None, names: Sequence[str]) -> None:
    """Refuse a function some of whose inputs are given neither as axes nor as constants."""
    missing = [name for name in shapes or () if name not in names]
    if missing:
        raise FreebodyError(
            f"sweep: the function needs {listed(missing)}; let it vary in over=, or give it in at=."
        )


def _target(cpu: Any, function: Any) -> str | None:
    """The target of kernels for a level of processors; None for this machine's own."""
    if cpu is None:
        return None
    levels = target_named("cpu").kinds
    if not isinstance(cpu, str):
        raise KindError("sweep", "cpu", cpu, f"the name of a level: {listed(levels)}")
    if cpu not in levels:
        raise UnknownNameError("CPU", cpu, "sweep", levels)
    if callable(function) and not isinstance(function, Kernel):
        raise FreebodyError(
            f"sweep: cpu= is for kernels: the name of a formula, or what fb.compile returns. A "
            f"Python function may call anything; set FREEBODY_TARGET=cpu:{cpu} where it runs."
        )
    return f"cpu:{cpu}"


def _for(target: str | None, kernel: Kernel) -> Kernel:
    if target is None:
        return kernel
    return compile_program(kernel.program, target=target, dtype=kernel.dtype.name)


def _numbers(model: Model, names: list[str], shapes: Mapping[str, Any] | None) -> tuple[str, ...]:
    """The given names that are numbers of the model and not inputs of the function."""
    from freebody.model.named_numbers import known

    rows = known(model).rows
    return tuple(x for x in names if x in rows and (shapes is None or x not in shapes))


def _split(
    axes: tuple[SweepAxis, ...], reduced: bool, along: str | Sequence[str] | None
) -> tuple[tuple[SweepAxis, ...], tuple[SweepAxis, ...]]:
    """The axes that stay, and those that are reduced; without a reduction the last axis is that of
    the columns."""
    if not reduced:
        if along is not None:
            raise FreebodyError("sweep: along= names axes that are reduced; give reduce= too.")
        return axes[:-1], axes[-1:]
    names = (
        (axes[-1].name,) if along is None else (along,) if isinstance(along, str) else tuple(along)
    )
    known = [axis.name for axis in axes]
    for name in names:
        if name not in known:
            raise UnknownNameError("axis", name, "over", known)
    if not names or len(set(names)) < len(names):
        raise FreebodyError("sweep: along= names at least one axis, and each once.")
    return (
        tuple(axis for axis in axes if axis.name not in names),
        tuple(axis for axis in axes if axis.name in names),
    )


def _outputs(swept: SweptFunction, grid: SweepGrid) -> tuple[tuple[str, tuple[int, ...]], ...]:
    """Names and core shapes of the outputs: known for a kernel; for a Python function found at the
    first point, or another one where that fails."""
    if isinstance(swept, SweptKernel):
        return tuple((x.name, x.shape) for x in swept.kernel.program.outputs)
    rows, columns = grid.shape
    first: Exception | None = None
    for share in (0.0, 0.5, 0.999, 0.25, 0.75):
        r, c = int(share * rows), int(share * columns)
        try:
            found = swept(grid.part(range(r, r + 1), range(c, c + 1)), False)
        except FAULTS:
            raise
        except FAILURES as problem:
            first = first or problem
        else:
            return tuple((name, x.shape[2:]) for name, x in found.items())
    assert first is not None
    raise first


def _task(
    model: Model,
    grid: SweepGrid,
    swept: SweptFunction,
    outputs: tuple[tuple[str, tuple[int, ...]], ...],
    chosen: tuple[SweepReduction, ...],
    points: int,
) -> SweepTask:
    """The sweep's task for all blocks, with everything that is decided by the whole grid."""
    moved = {name for axis in grid.columns for name in axis.given}
    by_row = bool(swept.numbers) and not moved & set(swept.numbers)
    largest = max(int(np.prod(core)) for _, core in outputs)
    return SweepTask(
        model,
        grid,
        swept,
        outputs,
        chosen,
        grid.shape[1] <= points,
        by_row,
        by_row and grid.shape[1] >= _WORTH_HOISTING,
        max(64, _TILE // largest),
    )


def _block(
    block: Any,
    outputs: tuple[tuple[str, tuple[int, ...]], ...],
    chosen: tuple[SweepReduction, ...],
    grid: SweepGrid,
) -> int:
    """The number of points in a block, as given or chosen by the size of the grid."""
    if block is None:
        rows, columns = grid.shape
        block = min(max(_BLOCK, 1 << (rows * columns // _BLOCKS).bit_length()), _LARGEST_BLOCK)
    if not is_count(block):
        raise KindError("sweep", "block", block, "a whole number of points from 1 up")
    largest = max(int(np.prod(core)) for _, core in outputs)
    return block if chosen else max(1, min(block, _LARGEST // largest))
