"""NVIDIA's driver through its own Python binding (cuda-bindings), as far as launches need it."""

from __future__ import annotations

import contextlib
import ctypes
import importlib.util
import weakref
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

from freebody.errors import FreebodyError

THREADS = 128
"""Threads of a block: two blocks of threads with 255 registers each have room on a
multiprocessor."""

DEFAULT_STREAM = 1
"""The stream that work goes to where none is given: the driver's handle of what it calls the legacy
stream."""


class GpuError(FreebodyError, RuntimeError):
    """An error returned by a GPU's driver."""


def missing() -> str:
    """Words for what this machine lacks to run on a GPU; empty if nothing."""
    for package in ("cuda.bindings", "cuda.core", "llvmlite"):
        if not _installed(package):
            return f"{package.replace('.', '-')} is not installed; pip install 'freebody[cuda]'"
    try:
        call("cuInit", 0)
    except GpuError as problem:
        return f"NVIDIA's driver finds no GPU: {problem}"
    except RuntimeError:  # the binding's own, where there is no library
        return "there is no NVIDIA driver on this machine"
    return "" if call("cuDeviceGetCount") else "NVIDIA's driver finds no GPU"


def _installed(package: str) -> bool:
    try:
        return importlib.util.find_spec(package) is not None
    except ModuleNotFoundError:  # not even its parent
        return False


def call(name: str, *arguments: Any) -> Any:
    """The results of a function of the driver, without its status. Raises GpuError."""
    import cuda.bindings.driver as binding  # pyright: ignore[reportMissingImports]

    status, *results = getattr(binding, name)(*arguments)
    if int(status):
        raise GpuError(f"{name} failed: {getattr(status, 'name', status)}.")
    return results[0] if len(results) == 1 else None


def device_of(address: int) -> int:
    """The index of the GPU whose memory holds an address."""
    import cuda.bindings.driver as binding  # pyright: ignore[reportMissingImports]

    kind = binding.CUpointer_attribute.CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL
    with current(0):
        return int(call("cuPointerGetAttribute", kind, address))


@cache
def _context(device: int) -> Any:
    """A GPU's primary context, which all libraries of this process share."""
    return call("cuDevicePrimaryCtxRetain", call("cuDeviceGet", device))


@contextlib.contextmanager
def current(device: int) -> Iterator[None]:
    """Context in which a GPU is the calling thread's current one."""
    call("cuCtxPushCurrent", _context(device))
    try:
        yield
    finally:
        call("cuCtxPopCurrent")


class Module:
    """PTX entries assembled by the driver for one GPU, which must be current; unloaded with the
    object."""

    def __init__(self, text: str, names: Sequence[str], device: int):
        module = call("cuModuleLoadData", text.encode() + b"\0")
        weakref.finalize(self, _unload, module, device).atexit = False
        self._entries = {name: call("cuModuleGetFunction", module, name.encode()) for name in names}

    def launch(self, name: str, values: Sequence[int], count: int, stream: int) -> None:
        """Launch an entry for `count` samples with 64-bit arguments, the last of which is the
        number of samples."""
        blocks = -(-count // THREADS)
        given = (*values, count), (ctypes.c_int64,) * (len(values) + 1)
        call(
            "cuLaunchKernel", self._entries[name], blocks, 1, 1, THREADS, 1, 1, 0, stream, given, 0
        )


def _unload(module: Any, device: int) -> None:
    with contextlib.suppress(GpuError), current(device):
        call("cuModuleUnload", module)


class Memory:
    """Memory on the current GPU, freed in the order of its stream when the object is deleted.

    stream: its handle. owner: whatever keeps the stream.
    """

    def __init__(self, size: int, device: int, stream: int, owner: Any = None):
        self.device, self.stream, self.owner = device, stream, owner
        self.address = int(call("cuMemAllocAsync", max(1, size), stream))
        weakref.finalize(self, _free, self.address, device, stream, owner).atexit = False


def _free(address: int, device: int, stream: int, owner: Any) -> None:
    with contextlib.suppress(GpuError), current(device):
        call("cuMemFreeAsync", address, stream)


def wait(waiting: int, working: int) -> None:
    """Make later work on one stream wait for the work already on another."""
    if waiting == working:
        return
    event = call("cuEventCreate", 2)  # without a clock
    try:
        call("cuEventRecord", event, working)
        call("cuStreamWaitEvent", waiting, event, 0)
    finally:
        call("cuEventDestroy", event)


def handle_of(stream: Any) -> int:
    """The driver's handle of a stream of PyTorch, CuPy or cuda.core, or of a handle itself.

    Raises GpuError for what is none.
    """
    for name in ("cuda_stream", "ptr", "handle"):
        stream = getattr(stream, name, stream)
    try:
        return int(stream) or DEFAULT_STREAM
    except (TypeError, ValueError):
        raise GpuError(
            f"stream={stream!r} is not a stream: give one of PyTorch, CuPy or cuda.core, or the "
            f"driver's handle."
        ) from None
