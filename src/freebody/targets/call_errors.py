"""Errors of a kernel's call that name the argument to blame, where NumPy has refused it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from freebody.arrays import as_array, check_core, too_large
from freebody.errors import FreebodyError, ShapeError, no_real_numbers, shown
from freebody.program.program import Argument, Program
from freebody.targets.target import KernelError


class BatchError(FreebodyError, ValueError):
    """Leading dimensions of arguments that do not broadcast."""

    def __init__(self, function: str, shapes: Mapping[str, Any], what: str = "batch shapes"):
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        super().__init__(f"{function}: the {what} do not broadcast together: {listed}.")


def require_count(function: str, given: Sequence[Any], inputs: Sequence[Argument]) -> None:
    """Refuse a call with too few or too many arrays."""
    if len(given) != len(inputs):
        raise KernelError(
            f"{function}: {len(given)} arguments given, expected {len(inputs)}: "
            f"{', '.join(map(str, inputs))}."
        )


def require_real(function: str, argument: Argument, given: Any, wanted: Any) -> None:
    """Refuse numbers of a type that is not converted to the kernel's."""
    if not np.can_cast(given.dtype, wanted, "same_kind"):
        raise KernelError(no_real_numbers(f"{function}: {argument.name}", given))


def common_batch(
    function: str,
    inputs: Sequence[Argument],
    arrays: Sequence[Any],
    broadcast: Callable[..., tuple[int, ...]] = np.broadcast_shapes,
) -> tuple[int, ...]:
    """The batch shape of arrays, of any library's; refuses wrong core shapes."""
    batches = {}
    for argument, array in zip(inputs, arrays, strict=True):
        check_core(function, argument.name, array, argument.shape)
        batches[argument.name] = tuple(array.shape[: len(array.shape) - len(argument.shape)])
    try:
        return broadcast(*batches.values())
    except (ValueError, RuntimeError):
        raise BatchError(function, batches) from None


def explained(
    program: Program, dtype: np.dtype[Any], arrays: tuple[Any, ...], out: Any, problem: Exception
) -> Exception:
    """The error that names the argument to blame; the original error if none is found."""
    if isinstance(problem, MemoryError):
        names = (argument.name for argument in program.inputs)
        return too_large(
            program.name, dict(zip(names, map(np.asarray, arrays), strict=True)), problem
        )
    name, inputs = program.name, program.inputs
    try:
        require_count(name, arrays, inputs)
        given = [as_array(name, x.name, array) for x, array in zip(inputs, arrays, strict=True)]
        for array, argument in zip(given, inputs, strict=True):
            require_real(name, argument, array, dtype)
        batch = common_batch(name, inputs, given)
    except FreebodyError as fault:
        return fault
    return (None if out is None else _of_out(program, dtype, batch, out)) or problem


def _of_out(
    program: Program, dtype: np.dtype[Any], batch: tuple[int, ...], out: Any
) -> Exception | None:
    """The error in the `out` arrays of a call; None if they are right."""
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
