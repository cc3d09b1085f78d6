"""What tells one function of Python from another, and one value from another, in this process and
in any: so a store knows the function again that it was begun with."""

from __future__ import annotations

import dis
import inspect
import sys
from typing import Any

import numpy as np

from freebody.errors import FreebodyError
from freebody.kernels.inputs import InputKernel
from freebody.model.model import Model
from freebody.targets import Kernel


def fingerprint(value: Any, known: tuple[Any, ...] = ()) -> list[Any]:
    """A value as parts whose `repr` is the same where it is.

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
        return _function(value, known)
    named = _named(value)
    if named:
        return named
    raise FreebodyError(
        f"sweep: a store must recognise the function later, and cannot: it is, contains or reads "
        f"a {type(value).__name__}. Give a Python function that contains only numbers, arrays, "
        f"strings, models, kernels and functions."
    )


def _named(value: Any) -> list[Any]:
    """Modules, and what is installed, by name; nothing for others."""
    if inspect.ismodule(value):
        return ["module", value.__name__]
    module = getattr(value, "__module__", None) or ("numpy" if isinstance(value, np.ufunc) else "")
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
    if callable(value) and name and isinstance(module, str) and _is_installed(module):
        return ["installed", module, name]
    return []


def _is_installed(module: str) -> bool:
    """Whether a module is Python's, or a package's; those are told by their versions."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names or top == "freebody":
        return top != "__main__"
    file = getattr(sys.modules.get(module), "__file__", None) or ""
    return "site-packages" in file or "dist-packages" in file


def _function(function: Any, known: tuple[Any, ...]) -> list[Any]:
    if function in known:  # it calls itself
        return ["function above", known.index(function)]
    known = (*known, function)
    code = function.__code__
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    held: list[Any] = [x.cell_contents for x in cells.values()]
    held += [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).items()]
    found = function.__globals__
    held += [(name, found[name]) for name in sorted(_read(code)) if name in found]
    return ["function", *_code(code), *(part for x in held for part in fingerprint(x, known))]


def _read(code: Any) -> set[str]:
    """Names of globals that the code and what is defined in it read."""
    names = {x.argval for x in dis.get_instructions(code) if x.opname == "LOAD_GLOBAL"}
    return names.union(*(_read(x) for x in code.co_consts if inspect.iscode(x)))


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
