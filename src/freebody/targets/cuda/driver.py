"""NVIDIA's driver, through its own binding (cuda-bindings), as far as a launch needs it."""

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
    """An error that the driver of a GPU has returned."""


def missing() -> str:
    """The words for what this machine lacks to run on a GPU; empty if nothing."""
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
    """A function of the driver: what it returns besides its status. Raises GpuError."""
    import cuda.bindings.driver as binding  # pyright: ignore[reportMissingImports]

    status, *results = getattr(binding, name)(*arguments)
    if int(status):
        raise GpuError(f"{name} failed: {getattr(status, 'name', status)}.")
    return results[0] if len(results) == 1 else None


def device_of(address: int) -> int:
    """The number of the GPU whose memory this is."""
    import cuda.bindings.driver as binding  # pyright: ignore[reportMissingImports]

    kind = binding.CUpointer_attribute.CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL
    with current(0):
        return int(call("cuPointerGetAttribute", kind, address))


@cache
def _context(device: int) -> Any:
    """The context that all libraries of this process share on a GPU."""
    return call("cuDevicePrimaryCtxRetain", call("cuDeviceGet", device))


@contextlib.contextmanager
def current(device: int) -> Iterator[None]:
    """A context with a GPU as the calling thread's current one."""
    call("cuCtxPushCurrent", _context(device))
    try:
        yield
    finally:
        call("cuCtxPopCurrent")


class Module:
    """A text of entries, assembled by the driver for one GPU, which is current; it goes with the
    object."""

    def __init__(self, text: str, names: Sequence[str], device: int):
        module = call("cuModuleLoadData", text.encode() + b"\0")
        weakref.finalize(self, _unload, module, device).atexit = False
        self._entries = {name: call("cuModuleGetFunction", module, name.encode()) for name in names}

    def launch(self, name: str, values: Sequence[int], count: int, stream: int) -> None:
        """Start an entry for `count` samples with its 64-bit values, of which n is the last."""
        blocks = -(-count // THREADS)
        given = (*values, count), (ctypes.c_int64,) * (len(values) + 1)
        call(
            "cuLaunchKernel", self._entries[name], blocks, 1, 1, THREADS, 1, 1, 0, stream, given, 0
        )


def _unload(module: Any, device: int) -> None:
    with contextlib.suppress(GpuError), current(device):
        call("cuModuleUnload", module)


class Memory:
    """Bytes on a GPU, which is current; they are given back, in the order of the stream, when the
    object goes.

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
    """Let later work on one stream begin when the work on another has ended."""
    if waiting == working:
        return
    event = call("cuEventCreate", 2)  # without a clock
    try:
        call("cuEventRecord", event, working)
        call("cuStreamWaitEvent", waiting, event, 0)
    finally:
        call("cuEventDestroy", event)


def handle_of(stream: Any) -> int:
    """The driver's handle of a stream: of PyTorch's, CuPy's, cuda.core's, or the handle itself.

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
