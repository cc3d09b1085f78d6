"""Whether two sweeps are the same: a hash of all that their results depend on."""

from __future__ import annotations

import hashlib
import inspect
from typing import Any

import numpy as np

from freebody.errors import FreebodyError
from freebody.model.model import Model
from freebody.sweeps.evaluation import SweepTask
from freebody.sweeps.functions import SweptCallable, SweptKernel
from freebody.targets import Kernel
from freebody.targets.llvm.machine import host


def identity(task: SweepTask, points: int) -> str:
    """SHA-256 in hexadecimal, of the function, the robot, the grid, what is gathered, and how the
    table is cut into blocks of so many points; and of the kind of processor, whose code gives the
    last digits."""
    digest = hashlib.sha256()

    def add(*parts: Any) -> None:
        for part in parts:
            content = part if isinstance(part, bytes) else repr(part).encode()
            digest.update(len(content).to_bytes(8, "little") + content)

    add("1", repr(host()), np.__version__, points, task.tile, task.hoisted, task.wanted)
    add(task.outputs, *_function(task.function), *_value(task.model))
    for axes in (task.grid.rows, task.grid.columns):
        add(*(part for axis in axes for part in (axis.name, *_given(axis.given))))
    add(*_given(task.grid.constants))
    return digest.hexdigest()


def _given(arrays: dict[str, Any]) -> list[Any]:
    return [part for name, array in arrays.items() for part in (name, *_value(array))]


def _function(function: Any) -> list[Any]:
    if isinstance(function, SweptCallable):
        return _value(function.function)
    assert isinstance(function, SweptKernel)
    made = function.kernel
    kernel = made if isinstance(made, Kernel) else made.kernel
    code = kernel.program.digest if kernel.loop is None else kernel.loop.content
    return [code, kernel.target, kernel.width, kernel.dtype.name, function.numbers]


def _value(value: Any) -> list[Any]:
    """What tells one value from another, in this process and in any."""
    if isinstance(value, Model):
        return ["model", value._key()]
    if isinstance(value, np.ndarray) and value.dtype != object:
        return ["array", value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes()]
    if inspect.isfunction(value):
        held = [x.cell_contents for x in value.__closure__ or ()]
        held += [*(value.__defaults__ or ()), *(value.__kwdefaults__ or {}).items()]
        return ["function", *_code(value.__code__), *(part for x in held for part in _value(x))]
    if isinstance(value, tuple | list):
        return ["row", len(value), *(part for x in value for part in _value(x))]
    if value is None or isinstance(value, bool | int | float | str | bytes):
        return [value]
    raise FreebodyError(
        f"sweep: a store must know the function again, and cannot: it is or holds a "
        f"{type(value).__name__}. Give a function of Python that holds numbers, arrays, texts, "
        f"models and functions alone."
    )


def _code(code: Any) -> list[Any]:
    found: list[Any] = [code.co_code, code.co_names, code.co_varnames]
    for constant in code.co_consts:
        found += _code(constant) if inspect.iscode(constant) else [constant]
    return found
