"""This machine's CPU, or a level that it reaches, as a target: programs as LLVM vector code,
compiled or found on disk, loaded as generalized ufuncs."""

from __future__ import annotations

import ctypes
import hashlib
import importlib.metadata
import importlib.util
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from operator import is_
from pathlib import Path
from typing import Any

import numpy as np

from freebody.program.passes import optimise
from freebody.program.program import Argument, Program
from freebody.targets import settings
from freebody.targets.finite_check import plainly
from freebody.targets.kernel import BatchLoop, Kernel, signature
from freebody.targets.llvm import cache as disk
from freebody.targets.llvm import fastcall, fastcode
from freebody.targets.llvm.emit import emit, emit_own
from freebody.targets.llvm.lanes import REALS, Real
from freebody.targets.llvm.loader import LoadedCode, load
from freebody.targets.llvm.machine import (
    LEVELS,
    LONGEST_VECTOR,
    WIDTHS,
    Host,
    Machine,
    at_level,
    lacking,
    object_code,
)
from freebody.targets.llvm.shared_functions import declarations, declared_once, object_beside
from freebody.targets.target import Target

_NAME = "cpu"
_LENGTH = 8
"""Number of bytes of a length."""


class _QuickKernel(Kernel):
    """A kernel whose calls run C functions of its own, which Python finds in the slots of the
    kernel's class."""

    __slots__ = ("__call__",)

    def __init__(self, kernel: Kernel, addresses: Mapping[str, int], code: LoadedCode):
        super().__init__(
            kernel.program, kernel.target, kernel.width, kernel.ufunc, kernel.dtype.name
        )
        self._plain, self._checked = (
            fastcall.Definition(addresses[symbol], self.program.name, code)
            for symbol in fastcode.EXPORTS
        )
        # what is not plain goes to the kernel without them
        self.__call__ = self._plain.function(kernel.__call__, self.few)

    def quick(self, general: Callable[..., Any], held: Any = None) -> Callable[..., Any]:
        return self._plain.function(general, self.few, held)

    def quick_checked(
        self, general: Callable[..., Any], held: Any = None, units: Sequence[tuple[int, int]] = ()
    ) -> Callable[..., Any]:
        entries = fastcall.unit_entries(units) if units else b""
        plain = self._checked.function(general, self.few, held, entries)

        def converted(*arrays: Any) -> Any:
            some = tuple(map(plainly, arrays))
            return (general if all(map(is_, some, arrays)) else plain)(*some)

        return self._checked.function(converted, self.few, held, entries)


def _build(level: str | None, program: Program, width: int | None, dtype: str) -> Kernel:
    here, real = at_level(level), REALS[dtype]
    machine = here.machine(width, real)
    fast = fastcall.available()
    key = disk.key(program.digest, here, machine, compiler_version(), fast)
    code = disk.load(key)
    if code is None:
        code = _compiled(program, machine, fast, here)
        disk.store(key, code)
    symbols = ("kernel", *fastcode.EXPORTS) if fast else ("kernel",)
    loaded, addresses = load(_apart(code), symbols, fastcall.symbols(real) if fast else {})
    ufunc = _make_gufunc(
        addresses["kernel"], program.name, program.inputs, program.outputs, loaded, real
    )
    kernel = Kernel(program, _NAME + (f":{level}" if level else ""), machine.width, ufunc, dtype)
    kernel = _QuickKernel(kernel, addresses, loaded) if fast else kernel
    kernel.loop = BatchLoop(addresses["kernel"], key, loaded)
    return kernel


def _compiled(program: Program, machine: Machine, fast: bool, here: Host) -> bytes:
    """The kernel's own object and the shared one loaded beside it, preceded by the length of the
    first: everything that a process needs which finds it on disk."""
    text = emit_own(optimise(program), machine)
    text += fastcode.text(program, machine.real) if fast else ""
    own = object_code(declared_once(text + declarations(text, machine)), here=here)
    return len(own).to_bytes(_LENGTH, "little") + own + object_beside(machine, here)


def _apart(code: bytes) -> tuple[bytes, bytes]:
    end = _LENGTH + int.from_bytes(code[:_LENGTH], "little")
    return code[_LENGTH:end], code[end:]


def _source(level: str | None, program: Program, width: int, dtype: str) -> str:
    return emit(optimise(program), at_level(level).machine(width, REALS[dtype]))


@cache
def compiler_version() -> str:
    """A version of the compiler that changes with its source, so that objects of another version
    are not taken from the cache."""
    digest = hashlib.sha256()
    house = Path(__file__).parent.parent.parent
    for path in sorted([*house.glob("program/*.py"), *house.glob("targets/**/*.py")]):
        digest.update(path.read_bytes())
    return f"{_installed_version()} {digest.hexdigest()}"


def _installed_version() -> str:
    try:
        return importlib.metadata.version("freebody")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _target(level: str | None) -> Target:
    return Target(
        build=partial(_build, level),
        source=partial(_source, level),
        widths={
            dtype: tuple(n for n in WIDTHS if n * real.bits <= LONGEST_VECTOR)
            for dtype, real in REALS.items()
        },
        variant=lambda _: (fastcall.available(), settings.OPTIMISE),
        loops=True,
        missing=partial(_missing, level),
    )


def _missing(level: str | None) -> str:
    if importlib.util.find_spec("llvmlite") is None:
        return "llvmlite is not installed"
    return lacking(level) if level else ""


TARGET = replace(_target(None), kinds={level: partial(_target, level) for level in LEVELS})


_FROM_FUNC_AND_DATA_AND_SIGNATURE = 31
"""Position in the table of __ufunc_api.h; part of NumPy's stable ABI."""
_NONE = -1  # PyUFunc_None: no identity
_OBJ = 88  # offset of `obj` in PyUFuncObject of ufuncobject.h, on 64-bit builds


def _make_gufunc(
    address: int,
    name: str,
    inputs: Sequence[Argument],
    outputs: Sequence[Argument],
    keep: Any,
    real: Real,
) -> np.ufunc:
    """A NumPy ufunc of a loop over numbers of one type, with fixed core sizes.

    Parameters
    ----------
    address
        Of `void loop(char **args, intptr_t *dimensions, intptr_t *steps, void *data)`.
    name
        Shown by NumPy in its messages.
    inputs
        Names and core shapes.
    outputs
        Names and core shapes.
    keep
        Whatever must live as long as the code is callable.
    real
        Type of the numbers.
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
    """Make a ufunc keep the objects that it points to alive: in the field where `np.frompyfunc`
    keeps its callable, or for ever."""
    if _has_place():
        ctypes.c_void_p.from_address(id(ufunc) + _OBJ).value = id(things)
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(things))


@cache
def _has_place() -> bool:
    """Whether NumPy's ufuncs keep their callable where its headers say; otherwise objects are kept
    for ever."""

    def probe(x: Any) -> Any:
        return x

    known = np.frompyfunc(probe, 1, 1)
    return np.ufunc.__basicsize__ >= _OBJ + ctypes.sizeof(
        ctypes.c_void_p
    ) and ctypes.c_void_p.from_address(id(known) + _OBJ).value == id(probe)


def _api(position: int, result: Any, *arguments: Any) -> Any:
    return ctypes.PYFUNCTYPE(result, *arguments)(fastcall.numpy_api("_UFUNC_API", position))
