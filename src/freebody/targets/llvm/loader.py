"""Compiled objects in this process: loaded, called, and freed once nothing can reach them."""

from __future__ import annotations

import ctypes
import itertools
import os
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from freebody.targets.llvm.machine import (
    CompileError,
    close,
    code_generator,
    host,
    library,
    to_load,
)


class LoadedCode(int):
    """A loaded object: its code and data exist as long as this, so every possible caller keeps a
    reference to it.

    It is an integer without a dict because the garbage collector does not know such objects: of
    those that it knows, it runs `__del__` before the finalizers of others in the same garbage,
    which may still call a kernel.
    """

    __slots__ = ()

    def __del__(self, ending: Any = sys.is_finalizing) -> None:
        if not ending():  # else the system takes back everything, and threads may still be inside
            _give_back(self)


_engines: dict[int, tuple[Any, int]] = {}
"""Number of the code -> LLVM's engine that holds it, and the process that loaded it."""

_numbers = itertools.count()


def load(
    objects: Sequence[bytes], exports: Sequence[str], imports: Mapping[str, int]
) -> tuple[LoadedCode, dict[str, int]]:
    """Loaded objects as something to keep alive, and the addresses of the exported functions.

    objects: each calls only functions of those behind it. Of an object that is not there yet, LLVM
    expects that it may come to lie anywhere, and of one that is there, that it lies within 2 GB.
    imports: addresses of the symbols that it refers to, besides the C functions that every kernel
    may call.

    Raises
    ------
    CompileError
        No object, or one that lacks an export.
    """
    llvm = library()
    with to_load(sum(map(len, objects))):
        for name, address in {**_externals(), **imports}.items():
            if llvm.address_of_symbol(name) is None:
                llvm.add_symbol(name, address)
        # an engine of its own: what several share is not given back until all of them are gone
        module = llvm.parse_assembly("", _context())
        module.triple = host().triple
        # LLVM's own way of placing code looks for a hole among the process's addresses for each
        # section; code reaches its constants only within 2 GB, and where no two holes are that
        # near, LLVM ends the process. llvmlite's way has a single piece for each object.
        engine = llvm.create_mcjit_compiler(module, code_generator(jit=True), use_lmm=True)
        engine.remove_module(module)  # it would be compiled, although there is nothing in it
        module.close()
        try:
            for code in objects:
                engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        except RuntimeError as problem:
            raise CompileError(
                f"LLVM {host().llvm} refused the object of a kernel: {problem}"
            ) from None
        engine.finalize_object()
        addresses = {name: engine.get_function_address(name) for name in exports}
    number = next(_numbers)
    _engines[number] = engine, os.getpid()
    loaded = LoadedCode(number)
    if not all(addresses.values()):
        raise CompileError(f"the object of a kernel lacks one of {', '.join(exports)}.")
    return loaded, addresses


def _give_back(code: LoadedCode) -> None:
    """Let LLVM free a code's memory; a forked child does not, since the pages are its parent's."""
    engine, process = _engines.pop(int(code))
    if process == os.getpid():
        close(engine)
    else:
        engine.detach()


@cache
def _context() -> Any:
    return library().create_context()


@cache
def _externals() -> dict[str, int]:
    """Addresses of the C functions that kernels call."""
    return {
        name: ctypes.cast(getattr(ctypes.CDLL(library), name), ctypes.c_void_p).value or 0
        for library, names in libraries(sys.platform, host().x86).items()
        for name in names
    }


def libraries(system: str, x86: bool) -> dict[str | None, tuple[str, ...]]:
    """Names of the C functions that kernels call, by the library that contains them; None: the
    process itself."""
    names = ("malloc", "free") if x86 else ("malloc", "free", "feclearexcept")
    if system != "win32":
        return {None: names}
    # a function with much on its stack touches it page by page on Windows
    return {"ucrtbase": names, "ntdll": ("__chkstk",)}
