"""Quick calls of a kernel with a few samples from Python: a C function for the interpreter in front
of the gufunc loop.

NumPy's ufunc machinery takes longer than the arithmetic of one robot. So each kernel also has a
function of CPython's fast calling convention that looks at its arguments itself: exact arrays of
its number type and the core shapes, or of a short batch of them, contiguous and aligned. It makes
the outputs, or takes those given as `out=` if they are such arrays too and overlap nothing, runs
the loop and returns; anything else goes to the general way, unchanged. A function may hold the last
argument, a robot's numbers, which then need not be given.

It knows where CPython and NumPy keep the fields of an object and an array: both layouts are part of
their stable binary interfaces on 64-bit builds with the GIL, and `available` is false elsewhere, or
where the environment says FREEBODY_FASTCALL=off.
"""

from __future__ import annotations

import ctypes
import importlib
import struct
import sys
import sysconfig
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from freebody.targets import settings
from freebody.targets.llvm.fastchecks import PAIR
from freebody.targets.llvm.lanes import Real

_SCALAR, _NEW = 60, 93
"""Positions of PyArray_Scalar and PyArray_New in the table of __multiarray_api.h."""
_FASTCALL_KEYWORDS = 0x0080 | 0x0002
_METHOD_DEF = "PPiP"  # PyMethodDef: name, function, flags, text
_OUT = sys.intern("out")  # as the name of a keyword is


def available() -> bool:
    """Whether this interpreter has the known memory layouts, and FREEBODY_FASTCALL is not off."""
    return (
        settings.FASTCALL
        and sys.implementation.name == "cpython"
        and struct.calcsize("P") == 8
        and not sysconfig.get_config_var("Py_GIL_DISABLED")
        and not hasattr(sys, "getobjects")  # builds with traced references have longer objects
    )


@cache
def symbols(real: Real) -> dict[str, int]:
    """Addresses of the functions and types that the LLVM text of a quick call refers to, by
    name."""
    python = ctypes.pythonapi
    named = {
        name: ctypes.cast(getattr(python, name), ctypes.c_void_p).value or 0
        for name in (
            "PyObject_Vectorcall",
            "PyTuple_New",
            "PyTuple_SetItem",
            "Py_IncRef",
            "Py_DecRef",
        )
    }
    return named | {
        "freebody.PyArray_Type": id(np.ndarray),
        "freebody.PyFloat_Type": id(float),
        "freebody.PyTuple_Type": id(tuple),
        "freebody.name.out": id(_OUT),
        f"freebody.descr.{real.dtype}": id(np.dtype(real.dtype)),
        "freebody.PyArray_New": numpy_api("_ARRAY_API", _NEW),
        "freebody.PyArray_Scalar": numpy_api("_ARRAY_API", _SCALAR),
    }


class Definition:
    """One of a kernel's C functions listed in `EXPORTS`, from which Python functions are made."""

    __slots__ = ("_held", "_method")

    def __init__(self, address: int, name: str, keep: Any):
        """Define the C function; keep: objects that must live as long as the code can be called."""
        title = name.encode()
        at = ctypes.cast(ctypes.c_char_p(title), ctypes.c_void_p).value
        self._method = struct.pack(_METHOD_DEF, at, address, _FASTCALL_KEYWORDS, 0)
        self._held = title, keep

    def function(
        self, general: Callable[..., Any], most: int, held: Any = None, units: bytes = b""
    ) -> Callable[..., Any]:
        """A Python function of the C code that passes arguments that are not plain on to `general`,
        and keeps alive what it points to.

        most: samples of a batch that it takes. held: the last argument of calls that do not give
        it. units: see `unit_entries`.
        """
        seen = general, held, units, struct.pack("q", most), self._method, self._held
        return _new_function()(self._method, seen, None)


def unit_entries(places: Sequence[tuple[int, int]]) -> bytes:
    """The places (input, first entry) of four numbers of unit length, as bytes that a checked
    function reads."""
    return b"".join(struct.pack(PAIR, *place) for place in places)


@cache
def _new_function() -> Any:
    new = ctypes.pythonapi.PyCFunction_NewEx
    new.restype = ctypes.py_object
    new.argtypes = [ctypes.c_char_p, ctypes.py_object, ctypes.c_void_p]
    return new


@cache
def numpy_api(table: str, position: int) -> int:
    """The address at a position of a table of NumPy's C functions, "_ARRAY_API" or "_UFUNC_API"."""
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    found = pointer(getattr(importlib.import_module("numpy._core._multiarray_umath"), table), None)
    return ctypes.cast(found, ctypes.POINTER(ctypes.c_void_p))[position] or 0
