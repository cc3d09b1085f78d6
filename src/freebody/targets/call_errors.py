"""Errors of a kernel's call: they name the argument that is to blame where NumPy has refused it."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.arrays import too_large
from freebody.errors import FreebodyError, ShapeError, shown
from freebody.program.program import Argument, Program
from freebody.targets.target import KernelError


class BatchError(FreebodyError, ValueError):
    """Leading dimensions that do not broadcast."""


def explained(
    program: Program, dtype: np.dtype[Any], arrays: tuple[Any, ...], out: Any, problem: Exception
) -> Exception:
    """The error that says which argument is to blame; the original one if none is."""
    if isinstance(problem, MemoryError):
        names = (argument.name for argument in program.inputs)
        return too_large(
            program.name, dict(zip(names, map(np.asarray, arrays), strict=True)), problem
        )
    name, inputs = program.name, program.inputs
    if len(arrays) != len(inputs):
        wanted = ", ".join(map(str, inputs))
        return KernelError(
            f"{name}: {len(arrays)} arguments given, expected {len(inputs)}: {wanted}."
        )
    for array, argument in zip(arrays, inputs, strict=True):
        given = np.asarray(array)
        if not np.can_cast(given.dtype, dtype, "same_kind"):
            return KernelError(
                f"{name}: {argument.name} holds {given.dtype} values, expected real numbers."
            )
        core = len(argument.shape)
        if given.ndim < core or given.shape[given.ndim - core :] != argument.shape:
            expected = f"({', '.join(['...', *map(str, argument.shape)])})"
            return ShapeError(name, argument.name, given.shape, expected)
    shapes = [np.shape(x)[: np.ndim(x) - len(i.shape)] for x, i in zip(arrays, inputs, strict=True)]
    try:
        batch = np.broadcast_shapes(*shapes)
    except ValueError:
        listed = ", ".join(
            f"{argument.name} {shape}" for argument, shape in zip(inputs, shapes, strict=True)
        )
        return BatchError(f"{name}: the batch shapes do not broadcast together: {listed}.")
    return (None if out is None else _of_out(program, dtype, batch, out)) or problem


def _of_out(
    program: Program, dtype: np.dtype[Any], batch: tuple[int, ...], out: Any
) -> Exception | None:
    """The error of the arrays to write to."""
    name, outputs = program.name, program.outputs
    given = out if isinstance(out, tuple) else (out,)
    if len(given) != len(outputs):
        wanted = ", ".join(f"{x.name} {batch + x.shape}" for x in outputs)
        return KernelError(
            f"{name}: out holds {len(given)} arrays, expected {len(outputs)}: {wanted}."
        )
    for array, argument in zip(given, outputs, strict=True):
        fault = _fault(array, argument, batch, dtype)
        if fault:
            place = f"out[{argument.name!r}]" if len(outputs) > 1 else "out"
            return (
                ShapeError(name, place, array.shape, str(batch + argument.shape))
                if fault is _SHAPE
                else KernelError(f"{name}: {place} {fault}.")
            )
    return None


_SHAPE = "has another shape"


def _fault(
    array: Any, argument: Argument, batch: tuple[int, ...], dtype: np.dtype[Any]
) -> str | None:
    if not isinstance(array, np.ndarray):
        wanted = f"an array of {dtype} of shape {batch + argument.shape}"
        return f"is {type(array).__name__} {shown(array)}, expected {wanted}"
    if array.shape != batch + argument.shape:
        return _SHAPE
    if not array.flags.writeable:
        return "cannot be written to; give a copy of it"
    if not np.can_cast(dtype, array.dtype, "same_kind"):
        return f"holds {array.dtype} values, expected {dtype}"
    return None
