"""The locks of all that compiles, in the order in which they are taken.

A fork waits for them, since its child would find them taken for ever. They stand together because hooks of a fork run
in the order in which they were registered: a target, which is imported when it is first used, must register none.
"""

from __future__ import annotations

import os
import threading

KERNELS = threading.Lock()
"""Of the kernels of this process; held while a target is imported and builds one."""

COMPILER = threading.Lock()
"""Of a compiler's library, which one thread uses at a time."""


def _take() -> None:
    KERNELS.acquire()
    COMPILER.acquire()


def _release() -> None:
    COMPILER.release()
    KERNELS.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take, after_in_parent=_release, after_in_child=_release)
