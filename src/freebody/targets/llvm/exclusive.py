"""One thread at a time in LLVM; what ends meanwhile waits, and nobody waits for it."""

from __future__ import annotations

import contextlib
import os
import threading
from collections import deque
from collections.abc import Iterator
from typing import Any

_lock = threading.Lock()
_gone: deque[Any] = deque()

# a fork waits, since its child would find this lock and LLVM's taken for ever
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_lock.acquire, after_in_parent=_lock.release, after_in_child=_lock.release)


@contextlib.contextmanager
def exclusive() -> Iterator[None]:
    """Alone in LLVM."""
    try:
        with _lock:
            yield
    finally:
        _close_what_is_gone()


def close(thing: Any) -> None:
    """Close an object of LLVM: now, or when the thread is done that works with LLVM just now.

    For finalizers, which run at any moment of any thread, also of one that holds the lock.
    """
    _gone.append(thing)
    _close_what_is_gone()


def _close_what_is_gone() -> None:
    while _gone and _lock.acquire(blocking=False):
        try:
            while _gone:
                _gone.popleft().close()
        finally:
            _lock.release()
