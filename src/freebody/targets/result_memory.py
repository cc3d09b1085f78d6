"""Memory for long results: that of results no longer in use is used again.

The system hands out memory page by page, when a page is first written, and that takes up to five
times as long as the arithmetic that fills it. The C library keeps short pieces itself, GNU's also
long ones once a long one has come and gone. What a longer result leaves behind is kept here for the
next one of about its size.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from math import prod

import numpy as np

from freebody.arrays import Array


def _shortest() -> int:
    """The size in bytes from which the C library returns memory to the system as soon as it is
    freed.

    GNU's asks the system for 128 kB and more, until such a piece is freed: then it keeps pieces of
    that length from there on, up to 32 MB (mallopt(3), M_MMAP_THRESHOLD).
    """
    names = getattr(os, "confstr_names", {})
    if "CS_GNU_LIBC_VERSION" not in names or not os.confstr("CS_GNU_LIBC_VERSION"):
        return 2**17
    np.empty(2**25 - 2**14, dtype=np.uint8)  # no page of it is written
    return 2**24


SMALLEST = _shortest()
"""Bytes of the smallest array for which keeping memory is worth it."""

LARGEST = 2**26
"""Bytes up to which a piece is kept."""

LIMIT = 2**26
"""Bytes that are kept in all, in pieces that nobody uses."""

_FLOAT64 = np.dtype(np.float64)

_kept: dict[int, deque[tuple[Array, int]]] = {}
"""Bytes of a piece -> pieces and their addresses; what was used last comes last."""


def empty(shape: tuple[int, ...], dtype: np.dtype = _FLOAT64) -> np.ndarray:
    """An array of unspecified values in C order."""
    size = dtype.itemsize * prod(shape)
    if not SMALLEST <= size <= LARGEST:
        return np.empty(shape, dtype)
    step = 1 << (size.bit_length() - 3)  # pieces of few different lengths
    return np.asarray(_KeptMemory(shape, -(-size // step) * step, dtype))


class _KeptMemory:
    """A block of memory that lives as long as the array in it, and is then kept for reuse.

    No lock guards what is kept: this may happen at any moment of any thread, and each step is one
    operation.
    """

    __slots__ = ("__array_interface__", "address", "memory")

    def __init__(self, shape: tuple[int, ...], size: int, dtype: np.dtype):
        try:
            self.memory, self.address = _kept[size].pop()
        except (KeyError, IndexError):
            self.memory = np.empty(size // 8)
            self.address = self.memory.ctypes.data
        self.__array_interface__ = {
            "data": (self.address, False),
            "shape": shape,
            "typestr": dtype.str,
            "version": 3,
        }

    def __del__(self) -> None:
        with contextlib.suppress(AttributeError, TypeError):  # the interpreter is ending
            _keep(self.memory, self.address)


def _keep(memory: Array, address: int) -> None:
    """Keep a block of memory for reuse, and release those that were not used for longest."""
    size = memory.nbytes
    pieces = _kept.pop(size, None) or deque()
    pieces.append((memory, address))
    _kept[size] = pieces
    total = sum(size * len(pieces) for size, pieces in tuple(_kept.items()))
    for size, pieces in tuple(_kept.items()):
        while total > LIMIT and pieces:
            with contextlib.suppress(IndexError):
                pieces.popleft()
            total -= size
