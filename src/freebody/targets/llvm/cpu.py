"""This machine's CPU as a target: programs as LLVM vector code, compiled or found on disk, loaded
as a gufunc."""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from freebody.program.passes import optimise
from freebody.program.program import Program
from freebody.targets.kernel import BatchLoop, Kernel
from freebody.targets.llvm import cache as disk
from freebody.targets.llvm import fastcall, fastcode
from freebody.targets.llvm.emit import emit
from freebody.targets.llvm.gufunc import make_gufunc
from freebody.targets.llvm.lanes import REALS
from freebody.targets.llvm.loader import LoadedCode, load
from freebody.targets.llvm.machine import LONGEST_VECTOR, WIDTHS, host, object_code
from freebody.targets.target import Target


class _QuickKernel(Kernel):
    """A kernel whose calls go to C functions of its own: Python finds them, by the class, in the
    kernel's slots."""

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
        self.__call__ = self._plain.function(kernel.__call__)  # type: ignore[method-assign]

    def quick(self, general: Callable[..., Any], held: Any = None) -> Callable[..., Any]:
        return self._plain.function(general, held)

    def quick_checked(
        self, general: Callable[..., Any], held: Any = None, units: Sequence[tuple[int, int]] = ()
    ) -> Callable[..., Any]:
        return self._checked.function(general, held, fastcall.unit_entries(units) if units else b"")


def _build(program: Program, width: int | None, dtype: str) -> Kernel:
    here, real = host(), REALS[dtype]
    machine = here.machine(width, real)
    fast = fastcall.available()
    key = disk.key(program.digest, here, machine, _compiler_version(), fast)
    code = disk.load(key)
    if code is None:
        text = emit(optimise(program), machine)
        code = object_code(text + fastcode.text(program, real) if fast else text)
        disk.store(key, code)
    symbols = ("kernel", *fastcode.EXPORTS) if fast else ("kernel",)
    loaded, addresses = load(code, symbols, fastcall.symbols(real) if fast else {})
    ufunc = make_gufunc(
        addresses["kernel"], program.name, program.inputs, program.outputs, loaded, real
    )
    kernel = Kernel(program, "cpu", machine.width, ufunc, dtype)
    kernel = _QuickKernel(kernel, addresses, loaded) if fast else kernel
    kernel.loop = BatchLoop(addresses["kernel"], key, loaded)
    return kernel


def _source(program: Program, width: int, dtype: str) -> str:
    return emit(optimise(program), host().machine(width, REALS[dtype]))


@cache
def _compiler_version() -> str:
    """Of the compiler's own text: whatever is changed in it, cached objects of the former text are
    not used."""
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


TARGET = Target(
    build=_build,
    source=_source,
    widths={
        dtype: tuple(n for n in WIDTHS if n * real.bits <= LONGEST_VECTOR)
        for dtype, real in REALS.items()
    },
    variant=lambda _: fastcall.available(),
    loops=True,
)
