"""The identity of a sweep: a hash of everything its results depend on (function, grid, libraries),
by which a store recognises the sweep that it was begun with."""

from __future__ import annotations

import dis
import hashlib
import importlib.metadata
import inspect
import platform
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy._core._multiarray_umath import __cpu_features__

from freebody.errors import FreebodyError
from freebody.kernels.inputs import InputKernel
from freebody.model.model import Model
from freebody.sweeps.evaluation import SweepTask
from freebody.sweeps.functions import SweptCallable, SweptFunction
from freebody.sweeps.samples import SAMPLERS, Samples
from freebody.targets import Kernel
from freebody.targets.llvm.cpu import compiler_version
from freebody.targets.llvm.machine import at_level
from freebody.targets.target import chosen_target


class SweepNeeds(NamedTuple):
    """The target and libraries that a sweep needs. target: that of its kernel; None for a Python
    function, which may call kernels of the process's own target. scipy: whether SciPy makes its
    samples."""

    target: str | None
    scipy: bool


def needs_of(task: SweepTask) -> SweepNeeds:
    """The target and libraries that compute a sweep's task."""
    kernel = _kernel(task.function)
    every = [axis.given for axis in (*task.grid.rows, *task.grid.columns)]
    scipy = any(isinstance(x, Samples) and SAMPLERS[x.method].scipy for x in every)
    return SweepNeeds(None if kernel is None else kernel.target, scipy)


def computed_with(needs: SweepNeeds) -> dict[str, str]:
    """Names and versions of everything besides the arguments that last digits depend on, with the
    processor that code is made for, which for a level (`cpu=`) is the same everywhere."""
    target, _, level = (needs.target or chosen_target(None)).partition(":")
    found = {"freebody": compiler_version(), "NumPy": np.__version__}
    if target == "cpu":
        made_for = at_level(level or None)
        found["processor"] = " ".join((made_for.triple, made_for.cpu, *sorted(made_for.has)))
        found["LLVM"] = made_for.llvm
    if target != "cpu" or needs.target is None:
        used = sorted(name for name, there in __cpu_features__.items() if there)
        found["processor's instructions used by NumPy"] = f"{platform.machine()} {' '.join(used)}"
    if needs.scipy:
        found["SciPy"] = importlib.metadata.version("scipy")
    return found


def differing(here: Mapping[str, str], there: Mapping[str, str]) -> list[str]:
    """Names of the entries that differ."""
    return [key for key in {**here, **there} if here.get(key) != there.get(key)]


def identity(task: SweepTask, points: int) -> str:
    """The SHA-256, in hexadecimal, of the function, the robot, the grid, the reductions, the cut
    into blocks of so many points, and the libraries."""
    digest = hashlib.sha256()

    def add(*parts: Any) -> None:
        for part in parts:
            content = part if isinstance(part, bytes) else repr(part).encode()
            digest.update(len(content).to_bytes(8, "little") + content)

    with_what = sorted(computed_with(needs_of(task)).items())
    add("3", with_what, points, task.tile, task.hoisted)
    add([x.name for x in task.reductions])
    add(task.outputs, *_swept_function(task.function), *fingerprint(task.model))
    for axes in (task.grid.rows, task.grid.columns):
        add(*(part for axis in axes for part in (axis.name, *_given(axis.given))))
    add(*_given(task.grid.constants))
    return digest.hexdigest()


def _given(arrays: Mapping[str, Any]) -> list[Any]:
    if isinstance(arrays, Samples):
        bounds = [
            part for name, pair in arrays.bounds.items() for part in (name, *fingerprint(pair))
        ]
        return ["samples", arrays.count, arrays.method, arrays.seed, *bounds]
    return [part for name, array in arrays.items() for part in (name, *fingerprint(array))]


def _swept_function(function: Any) -> list[Any]:
    if isinstance(function, SweptCallable):
        return fingerprint(function.function)
    kernel = _kernel(function)
    assert kernel is not None
    code = kernel.program.digest
    return [code, kernel.target, kernel.width, kernel.dtype.name, function.numbers]


def _kernel(function: SweptFunction) -> Kernel | None:
    made = getattr(function, "kernel", None)
    return made.kernel if isinstance(made, InputKernel) else made


def fingerprint(value: Any, known: tuple[Any, ...] = ()) -> list[Any]:
    """A value as a list of parts whose `repr` is equal exactly where the value is.

    A function is its code, and what that reads: what it holds, and the globals that it names, other
    functions of the user's among them; what is installed counts by its name. known: functions that
    this one is a part of. Raises FreebodyError for what cannot be told from its like.
    """
    if isinstance(value, Model):
        return ["model", value._key()]
    if isinstance(value, np.ndarray) and value.dtype != object:
        return ["array", value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes()]
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        return [value]
    if isinstance(value, tuple | list):
        return ["row", len(value), *(part for x in value for part in fingerprint(x, known))]
    if isinstance(value, dict):
        return [
            "dict",
            len(value),
            *(part for x in value.items() for part in fingerprint(x, known)),
        ]
    if isinstance(value, InputKernel):
        return ["inputs", value.parameters, *fingerprint(value.values), *fingerprint(value.kernel)]
    if isinstance(value, Kernel):
        return ["kernel", value.program.digest, value.target, value.width, value.dtype.name]
    if inspect.isfunction(value) and not _is_installed(value.__module__):
        return _python_function(value, known)
    named = _named(value)
    if named:
        return named
    raise FreebodyError(
        f"sweep: a store must recognise the function later, and cannot: it is, contains or reads "
        f"a {type(value).__name__}. Give a Python function that contains only numbers, arrays, "
        f"strings, models, kernels and functions."
    )


def _named(value: Any) -> list[Any]:
    """A module or an installed function as its kind and name; empty for other values."""
    if inspect.ismodule(value):
        return ["module", value.__name__]
    module = getattr(value, "__module__", None) or ("numpy" if isinstance(value, np.ufunc) else "")
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
    if callable(value) and name and isinstance(module, str) and _is_installed(module):
        return ["installed", module, name]
    return []


def _is_installed(module: str) -> bool:
    """Whether a module is Python's own or a package's, which versions identify."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names or top == "freebody":
        return top != "__main__"
    file = getattr(sys.modules.get(module), "__file__", None) or ""
    return "site-packages" in file or "dist-packages" in file


def _python_function(function: Any, known: tuple[Any, ...]) -> list[Any]:
    if function in known:  # it calls itself
        return ["function above", known.index(function)]
    known = (*known, function)
    code = function.__code__
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    held: list[Any] = [x.cell_contents for x in cells.values()]
    held += [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).items()]
    found = function.__globals__
    held += [(name, found[name]) for name in sorted(_globals_read(code)) if name in found]
    return ["function", *_code(code), *(part for x in held for part in fingerprint(x, known))]


def _globals_read(code: Any) -> set[str]:
    """Names of the globals that a code object, and functions defined in it, read."""
    names = {x.argval for x in dis.get_instructions(code) if x.opname == "LOAD_GLOBAL"}
    return names.union(*(_globals_read(x) for x in code.co_consts if inspect.iscode(x)))


def _code(code: Any) -> list[Any]:
    found: list[Any] = [code.co_code, code.co_names, code.co_varnames]
    for constant in code.co_consts:
        if inspect.iscode(constant):
            found += _code(constant)
        else:  # a set has no order of its own
            found.append(
                sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant
            )
    return found
