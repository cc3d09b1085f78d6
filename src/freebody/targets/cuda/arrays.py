"""Arrays on a GPU, of whatever library, and the launches that go through a batch of them."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import prod
from typing import Any

import numpy as np

from freebody.targets.cuda import driver

_NAMESPACES = {"cupy": "cupy", "torch": "torch", "jax": "jax.numpy", "jaxlib": "jax.numpy"}
"""Package of an array's class -> where its `from_dlpack` is."""


@dataclass(frozen=True)
class DeviceView:
    """Numbers in a GPU's memory: the address of the first, the shape, and the strides counted in
    numbers."""

    address: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]
    dtype: np.dtype
    device: int
    readonly: bool = False
    owner: Any = None

    @property
    def extent(self) -> tuple[int, int]:
        """The address of the first byte of the array, and of the byte behind its last."""
        reach = (
            [(n - 1) * s for n, s in zip(self.shape, self.strides, strict=True)]
            if prod(self.shape)
            else []
        )
        low, high = sum(min(0, r) for r in reach), sum(max(0, r) for r in reach)
        size = self.dtype.itemsize if prod(self.shape) else 0
        return (
            self.address + low * self.dtype.itemsize,
            self.address + high * self.dtype.itemsize + size,
        )

    def overlaps(self, other: DeviceView) -> bool:
        """Whether two arrays may share bytes."""
        (a, b), (c, d) = self.extent, other.extent
        return a < d and c < b

    def step(self, core: int) -> int | None:
        """The constant distance between entries of the last `core` axes in C order; None where it
        varies."""
        axes = [
            (n, s)
            for n, s in zip(
                self.shape[len(self.shape) - core :],
                self.strides[len(self.shape) - core :],
                strict=True,
            )
            if n != 1
        ]
        for (_, outer), (n, inner) in pairwise(axes):
            if outer != n * inner:
                return None
        return axes[-1][1] if axes else 1


def on_gpu(value: Any) -> bool:
    """Whether a value is an array in a GPU's memory: of CuPy, PyTorch, JAX, Numba, or one that a
    kernel returned."""
    if isinstance(value, np.ndarray | float | int | list | tuple):
        return False
    device = getattr(value, "__dlpack_device__", None)
    if device is not None:
        return int(device()[0]) in (2, 13)  # memory of CUDA, managed by CUDA
    return hasattr(value, "__cuda_array_interface__")


def device_of(value: Any) -> int:
    """The index of the GPU that an array is on."""
    device = getattr(value, "__dlpack_device__", None)
    if device is not None:
        return int(device()[1])
    return driver.device_of(value.__cuda_array_interface__["data"][0])


def view(value: Any, stream: int) -> DeviceView:
    """A view of any library's array on the current GPU; later work on the stream waits for pending
    work on the array."""
    from cuda.core.utils import StridedMemoryView  # pyright: ignore[reportMissingImports]

    found = StridedMemoryView.from_any_interface(value, stream_ptr=stream)
    shape = tuple(found.shape)
    strides = row_strides(shape) if found.strides is None else tuple(found.strides)
    dtype = np.dtype(found.dtype)
    return DeviceView(
        found.ptr, shape, strides, dtype, found.device_id, bool(found.readonly), found
    )


def row_strides(shape: Sequence[int]) -> tuple[int, ...]:
    """Strides of an array in C order, in numbers."""
    return tuple(prod(shape[k + 1 :]) for k in range(len(shape)))


class DeviceArray:
    """A result in a GPU's memory, for every library that reads `__cuda_array_interface__` or
    DLPack."""

    def __init__(self, memory: driver.Memory, shape: tuple[int, ...], dtype: np.dtype):
        self._memory, self.shape, self.dtype = memory, shape, dtype

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {
            "shape": self.shape,
            "typestr": self.dtype.str,
            "data": (self._memory.address, False),
            "strides": None,
            "version": 3,
            "stream": self._memory.stream,
        }

    def __dlpack_device__(self) -> tuple[int, int]:
        return 2, self._memory.device

    def __dlpack__(self, *, stream: int | None = None, **options: Any) -> Any:
        from cuda.core.utils import StridedMemoryView  # pyright: ignore[reportMissingImports]

        if stream != -1:
            with driver.current(self._memory.device):
                driver.wait(stream or driver.DEFAULT_STREAM, self._memory.stream)
        return StridedMemoryView.from_cuda_array_interface(self, stream_ptr=-1).__dlpack__(
            stream=-1, **options
        )

    @property
    def view(self) -> DeviceView:
        """The array as a view of its memory."""
        memory = self._memory
        return DeviceView(
            memory.address,
            self.shape,
            row_strides(self.shape),
            self.dtype,
            memory.device,
            owner=memory,
        )

    def numpy(self) -> np.ndarray:
        """A copy in the host's memory; waits until the numbers are there."""
        made = np.empty(self.shape, self.dtype)
        if not made.size:
            return made
        with driver.current(self._memory.device):
            driver.call(
                "cuMemcpyDtoHAsync",
                made.ctypes.data,
                self._memory.address,
                made.nbytes,
                self._memory.stream,
            )
            driver.call("cuStreamSynchronize", self._memory.stream)
        return made

    def like(self, other: Any) -> Any:
        """The array as one of another array's library, in the same memory; itself where that
        library is unknown."""
        name = _NAMESPACES.get(type(other).__module__.partition(".")[0])
        library = sys.modules.get(name) if name else None
        return self if library is None else library.from_dlpack(self)

    def __repr__(self) -> str:
        return f"DeviceArray(shape={self.shape}, dtype={self.dtype}, device={self._memory.device})"


@dataclass(frozen=True)
class Launch:
    """The samples of one launch: their number, and for each array the index of the first and the
    distance between samples."""

    count: int
    begins: tuple[int, ...]
    steps: tuple[int, ...]


def runs(batch: tuple[int, ...], strides: Sequence[tuple[int, ...]]) -> Iterator[Launch]:
    """Launches that go through a batch of arrays with given strides along its axes (0: broadcast),
    counted in numbers.

    Axes along which all arrays go on as they do along the next are one; of those that are left the
    longest is the launch's own, and there is one launch for each entry of the others.
    """
    if not prod(batch):
        return
    axes: list[tuple[int, list[int]]] = []
    for n, steps in zip(batch, zip(*strides, strict=True), strict=True):
        if n == 1:
            continue
        if axes and all(before == n * s for before, s in zip(axes[-1][1], steps, strict=True)):
            axes[-1] = axes[-1][0] * n, list(steps)
        else:
            axes.append((n, list(steps)))
    if not axes:
        axes = [(1, [0] * len(strides))]
    longest = max(range(len(axes)), key=lambda k: axes[k][0])
    count, own = axes.pop(longest)
    for index in np.ndindex(*(n for n, _ in axes)):
        begins = [
            sum(i * steps[k] for i, (_, steps) in zip(index, axes, strict=True))
            for k in range(len(strides))
        ]
        yield Launch(count, tuple(begins), tuple(own))
