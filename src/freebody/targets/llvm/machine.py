"""The machine that kernels are compiled for (this one, or a level that others reach too), and LLVM,
which makes an object for it from text.

LLVM is used by one thread at a time, and only where there is memory for what it does: where it gets
none, it ends the process. Finalizers meanwhile leave what they close to the thread in LLVM, and
nobody waits for them.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from freebody.errors import FreebodyError, OutOfMemoryError, listed
from freebody.locks import COMPILER
from freebody.targets import settings
from freebody.targets.llvm.lanes import DOUBLE, Lanes, Real

WIDTHS = (2, 4, 8, 16)
LONGEST_VECTOR = 512
"""Bits of the longest vectors that code is made for."""


@dataclass(frozen=True)
class Machine:
    """The properties of a machine that a kernel's text depends on."""

    width: int
    fma: bool
    x86: bool
    real: Real = DOUBLE

    @property
    def lanes(self) -> Lanes:
        """The vectors that a kernel computes with."""
        return Lanes(self.real, self.width)


class CompileError(FreebodyError, RuntimeError):
    """Raised where LLVM refuses a kernel: a fault of freebody, not of its user."""


@dataclass(frozen=True)
class Host:
    """A machine's CPU in LLVM's terms: this one's, or that of a level which it reaches."""

    triple: str
    cpu: str
    features: str
    llvm: str
    effort: int = 2
    """LLVM's on the machine code, 0 to 3."""

    @property
    def has(self) -> frozenset[str]:
        """The CPU features that are present."""
        return frozenset(name[1:] for name in self.features.split(",") if name.startswith("+"))

    @property
    def x86(self) -> bool:
        """Whether the CPU is a 64-bit x86."""
        return self.triple.startswith(("x86_64", "amd64"))

    def machine(self, width: int | None = None, real: Real = DOUBLE) -> Machine:
        """The machine description for kernels of vector `width`, or of the width that suits the
        CPU."""
        has = self.has
        fma = "fma" in has if self.x86 else True
        bits = (
            512 if "avx512f" in has and "avx512dq" in has else 256 if "avx2" in has and fma else 128
        )
        return Machine(width or bits // real.bits, fma, self.x86, real)


@dataclass(frozen=True)
class CpuLevel:
    """A level of features that many CPUs reach, for which LLVM generates the same code on all of
    them.

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
"""Levels of CPUs by name. x86: the System V ABI, AMD64 Architecture Processor Supplement, table
3.1."""


def lacking(level: str) -> str:
    """Words for what this machine lacks to run code of a level; empty where it lacks nothing."""
    here, wanted = host(), LEVELS[level]
    if here.x86 != wanted.x86:
        return f"this machine ({here.triple}) is of another architecture"
    missing = [name for name in wanted.features if name not in here.has]
    return f"this CPU ({here.cpu}) lacks {listed(missing)}" if missing else ""


def at_level(level: str | None) -> Host:
    """The host; for a level a CPU that has the level's features and no more."""
    here = replace(host(), effort=settings.OPTIMISE)
    if level is None:
        return here
    wanted = LEVELS[level]
    features = ",".join(f"+{name}" for name in wanted.features)
    return replace(here, cpu=wanted.llvm, features=features)


@cache
def host() -> Host:
    """The host, determined once."""
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
    """The relocatable object of LLVM text for the host or a level of it; opt: an optimisation level
    other than the usual."""
    llvm, here = library(), here or at_level(None)
    with (
        to_compile(text),
        code_generator(here.effort if opt is None else opt, here=here) as machine,
        llvm.create_context() as context,
    ):
        # a context keeps all constants that were ever read in it: one for each text
        try:
            module = llvm.parse_assembly(text + _room_for_addresses(text), context)
        except RuntimeError as problem:
            raise CompileError(
                f"LLVM {here.llvm} refused the text of a kernel: {problem}"
            ) from None
        with module:
            module.triple, module.data_layout = here.triple, str(machine.target_data)
            return machine.emit_object(module)


def _room_for_addresses(text: str) -> str:
    """LLVM text of a writable section as large as the table of functions that an object calls.

    LLVM fills such a table when it loads an object, but llvmlite's memory manager is not asked for
    it on x86; without another such piece it has no memory for it, and ends the process.
    """
    most = 32 + text.count("declare ")  # and what LLVM calls of its own accord
    return f"\n@freebody.room = internal global [{most} x i64] zeroinitializer\n"


def code_generator(opt: int = 2, jit: bool = False, here: Host | None = None) -> Any:
    """LLVM's code generator for the host, or for a level of CPUs."""
    llvm, here = library(), here or host()
    return llvm.Target.from_triple(here.triple).create_target_machine(
        cpu=here.cpu, features=here.features, opt=opt, reloc="pic", codemodel="small", jit=jit
    )


_gone: deque[Any] = deque()


_LIBRARY = 200 * 2**20
"""Bytes of addresses that LLVM's library takes when it is loaded; rather too many."""

_COMPILING, _OF_TEXT = 32 * 2**20, 32
"""Bytes that it takes to compile a text, and further ones for each letter (up to 20 were seen)."""

_LOADING, _OF_CODE = 16 * 2**20, 64
"""Bytes that it takes to load machine code, and further ones for each byte of it."""

_PIECES = 16
"""Pieces of memory with rights of their own that LLVM takes, rather too many; the system gives a
process only so many."""


@cache
def library() -> Any:
    """LLVM's Python binding, loaded on first use; raises OutOfMemoryError where there is no room
    for it."""
    _require_room(_LIBRARY, "to load its library")
    import llvmlite.binding as llvm

    return llvm


def to_compile(text: str) -> contextlib.AbstractContextManager[None]:
    """Context for compiling a text in LLVM, alone and with enough memory."""
    size = _COMPILING + _OF_TEXT * len(text)
    return _exclusive(size, f"to compile {len(text) / 1e6:.2g} MB of a kernel's text")


def to_load(code: int) -> contextlib.AbstractContextManager[None]:
    """Context for loading machine code of a given size in LLVM, alone and with enough memory."""
    return _exclusive(_LOADING + _OF_CODE * code, f"to load {code / 1e3:.3g} kB of code")


@contextlib.contextmanager
def _exclusive(room: int, what: str) -> Iterator[None]:
    """Context in which a thread is alone in LLVM with `room` bytes of memory. Signal handlers run
    between calls of LLVM, not during one. Raises OutOfMemoryError."""
    try:
        with COMPILER:
            _require_room(room, what)
            yield
    finally:
        _close_what_is_gone()


def _require_room(size: int, what: str) -> None:
    """Check that memory can be allocated as LLVM will do, by allocating and freeing it
    untouched."""
    import mmap  # what has LLVM has it; not every Python does

    try:
        np.empty(size, np.uint8)
        with contextlib.ExitStack() as pieces:
            for _ in range(_PIECES):
                pieces.enter_context(mmap.mmap(-1, 1))
    except (MemoryError, OSError):
        raise OutOfMemoryError(
            f"LLVM may need {size / 2**20:.0f} MiB of memory in up to {_PIECES} pieces {what}, "
            f"which this process does not get. Free some, raise its limits (such as ulimit -v and, "
            f"on Linux, vm.max_map_count), or set FREEBODY_TARGET=numpy, which compiles nothing."
        ) from None


def close(thing: Any) -> None:
    """Close an object of LLVM: now, or when the thread that is working with LLVM is done.

    For finalizers, which run at any moment of any thread.
    """
    _gone.append(thing)
    _close_what_is_gone()


def _close_what_is_gone() -> None:
    while _gone and COMPILER.acquire(blocking=False):
        try:
            while _gone:
                _gone.popleft().close()
        finally:
            COMPILER.release()
