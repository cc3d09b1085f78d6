"""NumPy as a target: a program run node by node, block by block; the fallback without llvmlite, and
a second opinion in tests.

No text is made, so none is executed.

Each node is one operation over arrays; registers are reused as soon as their value is no longer
read, so that a block of samples stays in the cache.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.elementary import NUMERIC
from freebody.program.passes import optimise
from freebody.program.program import Argument, Program
from freebody.scalars.operations import ARITY, OPERATIONS
from freebody.targets.kernel import Kernel
from freebody.targets.target import Target

BLOCK = 1024
"""Samples evaluated at a time."""


FUNCTION = {name: NUMERIC.get(name, record.number) for name, record in OPERATIONS.items()}
"""Each operation over arrays."""


@dataclass(frozen=True)
class Interpreter:
    """An interpreter of a program: for each step a function, the register of its result and those
    of its operands."""

    steps: tuple[tuple[Callable[..., Any], int, tuple[int, ...]], ...]
    registers: tuple[float | None, ...]
    """The registers at first: constants, and None."""
    inputs: tuple[tuple[int, int], ...]
    """Registers of the inputs that are read, with their positions among the scalars of all
    inputs."""
    results: tuple[int, ...]

    @classmethod
    def of(cls, program: Program) -> Interpreter:
        """The interpreter of a program."""
        last = _last_reader(program)
        held: list[float | None] = []
        free: list[int] = []
        place: list[int] = []
        steps, inputs = [], []
        for index, op in enumerate(program.op):
            if not ARITY[op]:
                place.append(len(held))
                held.append(program.constants[program.a[index]] if op == "const" else None)
                if op == "input":
                    inputs.append((place[index], program.a[index]))
                continue
            operands = program.operands(index)
            for operand in set(operands):
                if last[operand] == index and ARITY[program.op[operand]]:
                    free.append(place[operand])
            if not free:
                free.append(len(held))
                held.append(None)
            place.append(free.pop())
            steps.append((FUNCTION[op], place[index], tuple(place[i] for i in operands)))
        return cls(
            tuple(steps), tuple(held), tuple(inputs), tuple(place[i] for i in program.results)
        )

    def __call__(self, scalars: Sequence[Any] | np.ndarray) -> list[Any]:
        """The scalars of all outputs from those of all inputs, each an array or a number, in C
        order."""
        held: list[Any] = list(self.registers)
        for register, position in self.inputs:
            held[register] = scalars[position]
        for function, register, operands in self.steps:
            held[register] = function(*(held[i] for i in operands))
        return [held[i] for i in self.results]


def _last_reader(program: Program) -> list[int]:
    """The index of the last node that reads each node; for results the number of nodes."""
    last = list(range(len(program)))
    for index in range(len(program)):
        for operand in program.operands(index):
            last[operand] = index
    for index in program.results:
        last[index] = len(program)
    return last


class BlockedFunction:
    """A function that behaves like a program's generalized ufunc, block by block in NumPy.

    Called with one array for each input: core shape last, any leading shapes that broadcast.
    Returns the output, or the tuple of outputs.
    """

    def __init__(self, program: Program, dtype: str = "float64"):
        self.inputs, self.outputs, self.dtype = program.inputs, program.outputs, np.dtype(dtype)
        self.__name__ = program.name
        self._interpreter = Interpreter.of(program)

    def __call__(self, *arrays: ArrayLike, out: Any = None) -> Any:
        if len(arrays) != len(self.inputs):
            raise TypeError(f"{self.__name__}() takes {len(self.inputs)} arrays, got {len(arrays)}")
        values = [_real(array, self.dtype) for array in arrays]
        batch = np.broadcast_shapes(*map(_batch_shape, values, self.inputs))
        given = (
            out if isinstance(out, tuple) else (out,) * len(self.outputs) if out is None else (out,)
        )
        results = [
            np.empty(batch + argument.shape, self.dtype) if array is None else array
            for array, argument in zip(given, self.outputs, strict=True)
        ]
        for array, argument in zip(results, self.outputs, strict=True):
            if array.shape != batch + argument.shape:
                raise ValueError(
                    f"out for {argument} has shape {array.shape}, expected {batch + argument.shape}"
                )
        count = int(np.prod(batch))
        rows = [
            np.broadcast_to(value, batch + argument.shape).reshape(count, argument.size)
            for value, argument in zip(values, self.inputs, strict=True)
        ]
        y = np.empty((sum(argument.size for argument in self.outputs), count), self.dtype)
        with np.errstate(all="ignore"):
            for start in range(0, count, BLOCK):
                self._block(rows, y, slice(start, min(start + BLOCK, count)))
        row = 0
        for array, argument in zip(results, self.outputs, strict=True):
            made = y[row : row + argument.size].T.reshape(batch + argument.shape)
            np.copyto(array, made, casting="same_kind")  # as a ufunc does
            row += argument.size
        if out is None:
            # a number where there are no axes, as NumPy's ufuncs do
            results = [array[()] for array in results]
        return results[0] if len(results) == 1 else tuple(results)

    def _block(self, rows: Sequence[np.ndarray], y: np.ndarray, part: slice) -> None:
        x = (
            np.concatenate([array[part].T for array in rows])
            if rows
            else np.empty((0, part.stop - part.start), self.dtype)
        )
        for position, values in enumerate(self._interpreter(x)):
            y[position, part] = values
        bad = ~np.isfinite(x).all(axis=0)
        if bad.any():
            y[:, part][:, bad] = np.nan


def _real(value: ArrayLike, dtype: np.dtype) -> np.ndarray:
    array = np.asarray(value)
    if not np.can_cast(array.dtype, dtype, "same_kind"):
        raise TypeError(f"cannot make {dtype} of {array.dtype}")
    return array.astype(dtype, copy=False)


def _batch_shape(value: np.ndarray, argument: Argument) -> tuple[int, ...]:
    core = len(argument.shape)
    if value.ndim < core or value.shape[value.ndim - core :] != argument.shape:
        raise ValueError(f"{argument} was given an array of shape {value.shape}")
    return value.shape[: value.ndim - core]


def _build(program: Program, width: int | None, dtype: str) -> Kernel:
    return Kernel(program, "numpy", 1, BlockedFunction(optimise(program), dtype), dtype)


def _source(program: Program, width: int, dtype: str) -> str:
    return optimise(program).listing()


TARGET = Target(
    build=_build,
    source=_source,
    widths={"float64": (), "float32": ()},
    variant=lambda program: None,
    loops=False,
)
