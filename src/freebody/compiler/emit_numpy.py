"""Program to NumPy text: the fallback where llvmlite is missing, and a second opinion in tests.

The text is one function over a block of samples; each node is one line over vectors, and names are reused as
soon as their value is no longer read, so that a block stays in the cache.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.compiler.program import Argument, Program
from freebody.scalars.expr import ARITY

BLOCK = 1024
"""Samples evaluated at a time."""

EXPRESSION = {
    "neg": "-{a}",
    "sqrt": "sqrt({a})",
    "sin": "sin({a})",
    "cos": "cos({a})",
    "sign": "sign({a})",
    "add": "{a} + {b}",
    "sub": "{a} - {b}",
    "mul": "{a} * {b}",
    "div": "{a} / {b}",
}


def emit(program: Program) -> str:
    """Text of `evaluate(x, y)`: rows of x are the scalars of all inputs, rows of y become those of all outputs."""
    last = list(range(len(program)))
    for index in range(len(program)):
        for operand in program.operands(index):
            last[operand] = index
    for index in program.results:
        last[index] = len(program)
    names: dict[int, str] = {}
    free: list[str] = []
    made = 0
    lines = [f'"""{program}"""', "from numpy import cos, sign, sin, sqrt", "", "", "def evaluate(x, y):"]
    for index, op in enumerate(program.op):
        if op == "input":
            names[index] = f"x[{program.a[index]}]"
        elif op == "const":
            names[index] = repr(program.constants[program.a[index]])
        else:
            a, b = program.a[index], program.b[index]
            text = EXPRESSION[op].format(a=names[a], b=names.get(b, ""))
            for operand in set(program.operands(index)):
                if last[operand] == index and ARITY[program.op[operand]]:
                    free.append(names[operand])
            if free:
                names[index] = free.pop()
            else:
                names[index], made = f"t{made}", made + 1
            lines.append(f"    {names[index]} = {text}")
    lines += [f"    y[{position}] = {names[index]}" for position, index in enumerate(program.results)]
    return "\n".join([*lines, "    return", ""])


class BlockedFunction:
    """Behaves as the generalized ufunc of a program would, block by block in NumPy.

    Called with one array for each input: core shape last, any leading shapes that broadcast. Returns the
    output, or the tuple of outputs.
    """

    def __init__(self, program: Program, source: str):
        self.inputs, self.outputs = program.inputs, program.outputs
        self.__name__ = program.name
        scope: dict[str, Any] = {}
        exec(compile(source, f"<freebody {program.name}>", "exec"), scope)
        self._evaluate: Callable[[Any, Any], None] = scope["evaluate"]

    def __call__(self, *arrays: ArrayLike, out: Any = None) -> Any:
        if len(arrays) != len(self.inputs):
            raise TypeError(f"{self.__name__}() takes {len(self.inputs)} arrays, got {len(arrays)}")
        values = [_float64(array) for array in arrays]
        batch = np.broadcast_shapes(*map(_batch_shape, values, self.inputs))
        given = out if isinstance(out, tuple) else (out,) * len(self.outputs) if out is None else (out,)
        results = [
            np.empty(batch + argument.shape) if array is None else array
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
        y = np.empty((sum(argument.size for argument in self.outputs), count))
        with np.errstate(all="ignore"):
            for start in range(0, count, BLOCK):
                self._block(rows, y, slice(start, min(start + BLOCK, count)))
        row = 0
        for array, argument in zip(results, self.outputs, strict=True):
            made = y[row : row + argument.size].T.reshape(batch + argument.shape)
            np.copyto(array, made, casting="same_kind")  # as a ufunc does
            row += argument.size
        if out is None:
            results = [
                array[()] for array in results
            ]  # a number where there are no axes, as NumPy's ufuncs do
        return results[0] if len(results) == 1 else tuple(results)

    def _block(self, rows: Sequence[np.ndarray], y: np.ndarray, part: slice) -> None:
        x = (
            np.concatenate([array[part].T for array in rows])
            if rows
            else np.empty((0, part.stop - part.start))
        )
        self._evaluate(x, y[:, part])
        bad = ~np.isfinite(x).all(axis=0)
        if bad.any():
            y[:, part][:, bad] = np.nan


def _float64(value: ArrayLike) -> np.ndarray:
    array = np.asarray(value)
    if not np.can_cast(array.dtype, np.float64, "safe"):
        raise TypeError(f"cannot cast {array.dtype} to float64 safely")
    return array.astype(np.float64, copy=False)


def _batch_shape(value: np.ndarray, argument: Argument) -> tuple[int, ...]:
    core = len(argument.shape)
    if value.ndim < core or value.shape[value.ndim - core :] != argument.shape:
        raise ValueError(f"{argument} was given an array of shape {value.shape}")
    return value.shape[: value.ndim - core]
