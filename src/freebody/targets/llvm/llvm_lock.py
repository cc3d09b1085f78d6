"""One thread at a time in LLVM; what ends meanwhile waits, and nobody waits for it."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterator
from typing import Any

from freebody.locks import COMPILER

_gone: deque[Any] = deque()


@contextlib.contextmanager
def exclusive() -> Iterator[None]:
    """Alone in LLVM. A handler of a signal may come between two calls of it, not into one: nothing
    there calls back."""
    try:
        with COMPILER:
            yield
    finally:
        _close_what_is_gone()


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
