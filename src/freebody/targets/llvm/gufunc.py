"""A NumPy generalized ufunc from the address of a compiled loop, through NumPy's C API."""

from __future__ import annotations

import ctypes
import importlib
import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from freebody.program.program import Argument
from freebody.targets.kernel import signature
from freebody.targets.llvm.lanes import Real

_FROM_FUNC_AND_DATA_AND_SIGNATURE = 31
"""Position in the table of __ufunc_api.h; part of NumPy's stable ABI."""
_NONE = -1  # PyUFunc_None: no identity
_OBJ = 88  # offset of `obj` in PyUFuncObject of ufuncobject.h, on 64-bit builds


def make_gufunc(
    address: int,
    name: str,
    inputs: Sequence[Argument],
    outputs: Sequence[Argument],
    keep: Any,
    real: Real,
) -> np.ufunc:
    """The ufunc of a loop over numbers of one type, with fixed core sizes.

    Args:
        address: of `void loop(char **args, intptr_t *dimensions, intptr_t *steps, void *data)`.
        name: shown by NumPy in its messages.
        inputs: names and core shapes.
        outputs: names and core shapes.
        keep: whatever must live as long as the code is callable.
        real: type of the numbers.
    """
    functions, data = struct.pack("P", address), struct.pack("P", 0)
    types = bytes([real.number] * (len(inputs) + len(outputs)))
    title, core = name.encode(), signature(inputs, outputs).encode()
    make = _api(
        _FROM_FUNC_AND_DATA_AND_SIGNATURE,
        ctypes.py_object,
        *[ctypes.c_char_p] * 3,
        *[ctypes.c_int] * 4,
        *[ctypes.c_char_p] * 2,
        ctypes.c_int,
        ctypes.c_char_p,
    )
    ufunc = make(functions, data, types, 1, len(inputs), len(outputs), _NONE, title, core, 0, core)
    _hold(ufunc, (functions, data, types, title, core, keep))
    return ufunc


def _hold(ufunc: np.ufunc, things: tuple[Any, ...]) -> None:
    """Let a ufunc hold what it points to: in the place where `np.frompyfunc` keeps its callable, or
    for ever."""
    if _has_place():
        ctypes.c_void_p.from_address(id(ufunc) + _OBJ).value = id(things)
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(things))


@cache
def _has_place() -> bool:
    """Whether NumPy's ufuncs have their callable where its headers say; in another layout things
    are kept for ever."""

    def probe(x: Any) -> Any:
        return x

    known = np.frompyfunc(probe, 1, 1)
    return np.ufunc.__basicsize__ >= _OBJ + ctypes.sizeof(
        ctypes.c_void_p
    ) and ctypes.c_void_p.from_address(id(known) + _OBJ).value == id(probe)


def _api(position: int, result: Any, *arguments: Any) -> Any:
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    table = pointer(importlib.import_module("numpy._core._multiarray_umath")._UFUNC_API, None)
    address = ctypes.cast(table, ctypes.POINTER(ctypes.c_void_p))[position]
    return ctypes.PYFUNCTYPE(result, *arguments)(address)
