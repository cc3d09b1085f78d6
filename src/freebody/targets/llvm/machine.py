"""The machine that kernels are compiled for, and the way from LLVM text to an object for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from freebody.errors import FreebodyError
from freebody.targets.llvm.lanes import DOUBLE, Lanes, Real
from freebody.targets.llvm.llvm_lock import exclusive

WIDTHS = (2, 4, 8, 16)
LONGEST_VECTOR = 512
"""Bits."""


@dataclass(frozen=True)
class Machine:
    """What the text of a kernel depends on."""

    width: int
    fma: bool
    x86: bool
    real: Real = DOUBLE

    @property
    def lanes(self) -> Lanes:
        """The vectors that a kernel computes with."""
        return Lanes(self.real, self.width)


class CompileError(FreebodyError, RuntimeError):
    """LLVM refused a kernel: a fault of freebody, not of its user."""


@dataclass(frozen=True)
class Host:
    """This machine's CPU as LLVM names it."""

    triple: str
    cpu: str
    features: str
    llvm: str

    @property
    def has(self) -> frozenset[str]:
        """Features that are present."""
        return frozenset(name[1:] for name in self.features.split(",") if name.startswith("+"))

    @property
    def x86(self) -> bool:
        """Whether this is a 64-bit x86."""
        return self.triple.startswith(("x86_64", "amd64"))

    def machine(self, width: int | None = None, real: Real = DOUBLE) -> Machine:
        """The machine of kernels of `width`, or of the width that suits the CPU."""
        has = self.has
        fma = "fma" in has if self.x86 else True
        bits = (
            512 if "avx512f" in has and "avx512dq" in has else 256 if "avx2" in has and fma else 128
        )
        return Machine(width or bits // real.bits, fma, self.x86, real)


@cache
def host() -> Host:
    """The host, asked once."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return Host(
        llvm.get_process_triple(),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
        ".".join(map(str, llvm.llvm_version_info)),
    )


def object_code(text: str, opt: int = 2) -> bytes:
    """A relocatable object for the host."""
    import llvmlite.binding as llvm

    here = host()
    with exclusive(), host_machine(opt) as machine, llvm.create_context() as context:
        # a context keeps all constants that were ever read in it: one for each text
        try:
            module = llvm.parse_assembly(text, context)
        except RuntimeError as problem:
            raise CompileError(
                f"LLVM {here.llvm} refused the text of a kernel: {problem}"
            ) from None
        with module:
            module.triple, module.data_layout = here.triple, str(machine.target_data)
            return machine.emit_object(module)


def host_machine(opt: int = 2, jit: bool = False) -> Any:
    """LLVM's code generator for the host."""
    import llvmlite.binding as llvm

    here = host()
    return llvm.Target.from_triple(here.triple).create_target_machine(
        cpu=here.cpu, features=here.features, opt=opt, reloc="pic", codemodel="small", jit=jit
    )
