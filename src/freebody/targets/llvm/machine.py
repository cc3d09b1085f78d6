"""The machine that kernels are compiled for, this one or a level that others reach too, and the
way from LLVM text to an object for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from freebody.errors import FreebodyError, listed
from freebody.targets import settings
from freebody.targets.llvm.lanes import DOUBLE, Lanes, Real
from freebody.targets.llvm.llvm_lock import library, to_compile

WIDTHS = (2, 4, 8, 16)
LONGEST_VECTOR = 512
"""Bits."""


@dataclass(frozen=True)
class Machine:
    """The parts of a machine that the text of a kernel depends on."""

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
    """A machine's CPU as LLVM names it: this one's, or a level that this one reaches."""

    triple: str
    cpu: str
    features: str
    llvm: str
    effort: int = 2
    """LLVM's on the machine code, 0 to 3."""

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


@dataclass(frozen=True)
class CpuLevel:
    """A level that many CPUs reach, for which LLVM gives all of them the same code.

    llvm: its name there. features: what a CPU has that reaches it, in LLVM's words.
    """

    x86: bool
    llvm: str
    features: tuple[str, ...]


_V2 = ("cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3")
_V3 = (*_V2, "avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
_V4 = (*_V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")

LEVELS = {
    "x86-64": CpuLevel(True, "x86-64", ()),
    "x86-64-v2": CpuLevel(True, "x86-64-v2", _V2),
    "x86-64-v3": CpuLevel(True, "x86-64-v3", _V3),
    "x86-64-v4": CpuLevel(True, "x86-64-v4", _V4),
    "armv8-a": CpuLevel(False, "generic", ()),
}
"""By name. x86: the System V ABI, AMD64 Architecture Processor Supplement, table 3.1."""


def lacking(level: str) -> str:
    """The words for what this machine lacks to run code for a level; empty where it runs it."""
    here, wanted = host(), LEVELS[level]
    if here.x86 != wanted.x86:
        return f"this machine ({here.triple}) is of another architecture"
    missing = [name for name in wanted.features if name not in here.has]
    return f"this CPU ({here.cpu}) lacks {listed(missing)}" if missing else ""


def at_level(level: str | None) -> Host:
    """The host; with a level a CPU that reaches it and has no more."""
    here = replace(host(), effort=settings.OPTIMISE)
    if level is None:
        return here
    wanted = LEVELS[level]
    features = ",".join(f"+{name}" for name in wanted.features)
    return replace(here, cpu=wanted.llvm, features=features)


@cache
def host() -> Host:
    """The host, found out once."""
    llvm = library()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return Host(
        llvm.get_process_triple(),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
        ".".join(map(str, llvm.llvm_version_info)),
    )


def object_code(text: str, opt: int | None = None, here: Host | None = None) -> bytes:
    """A relocatable object for the host, or a level of it; opt: an effort of its own."""
    llvm, here = library(), here or at_level(None)
    with (
        to_compile(text),
        code_generator(here.effort if opt is None else opt, here=here) as machine,
        llvm.create_context() as context,
    ):
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


def code_generator(opt: int = 2, jit: bool = False, here: Host | None = None) -> Any:
    """LLVM's for the host, or a level of it."""
    llvm, here = library(), here or host()
    return llvm.Target.from_triple(here.triple).create_target_machine(
        cpu=here.cpu, features=here.features, opt=opt, reloc="pic", codemodel="small", jit=jit
    )
