"""LLVM used by one thread at a time, and only where there is memory for what it does: where it gets
none, it ends the process. Finalizers meanwhile leave what they close to the thread in LLVM, and
nobody waits for them."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from freebody.errors import OutOfMemoryError
from freebody.locks import COMPILER

_gone: deque[Any] = deque()


_LIBRARY = 200 * 2**20
"""Bytes of addresses that LLVM's library takes when it is loaded; rather too many."""

_COMPILING, _OF_TEXT = 32 * 2**20, 32
"""Bytes that it takes to compile a text, and further ones for each letter (up to 20 were seen)."""

_LOADING, _OF_CODE = 16 * 2**20, 64
"""Bytes that it takes to load machine code, and further ones for each byte of it."""


@cache
def library() -> Any:
    """LLVM's. Raises OutOfMemoryError."""
    _require_room(_LIBRARY, "to load its library")
    import llvmlite.binding as llvm

    return llvm


def to_compile(text: str) -> contextlib.AbstractContextManager[None]:
    """`_exclusive`, with memory to compile a text."""
    size = _COMPILING + _OF_TEXT * len(text)
    return _exclusive(size, f"to compile {len(text) / 1e6:.2g} MB of a kernel's text")


def to_load(code: int) -> contextlib.AbstractContextManager[None]:
    """`_exclusive`, with memory to load so many bytes of machine code."""
    return _exclusive(_LOADING + _OF_CODE * code, f"to load {code / 1e3:.3g} kB of code")


@contextlib.contextmanager
def _exclusive(room: int, what: str) -> Iterator[None]:
    """Alone in LLVM, with so many bytes of memory. A handler of a signal may come between two calls
    of it, not into one: nothing there calls back. Raises OutOfMemoryError."""
    try:
        with COMPILER:
            _require_room(room, what)
            yield
    finally:
        _close_what_is_gone()


def _require_room(size: int, what: str) -> None:
    """Allocate memory as LLVM will, and give it back untouched."""
    try:
        np.empty(size, np.uint8)
    except MemoryError:
        raise OutOfMemoryError(
            f"LLVM may need {size / 2**20:.0f} MiB of memory {what}, which this process does not "
            f"get. Free some, raise its limit (such as ulimit -v), or set FREEBODY_TARGET=numpy, "
            f"which compiles nothing."
        ) from None


def close(thing: Any) -> None:
    """Close an object of LLVM: now, or when the thread is done that works with LLVM just now.

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
