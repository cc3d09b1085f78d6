"""The locks of a process, in the order in which they are taken, and a lock on imports that a fork
waits for.

A fork waits for them, since its child would find them taken for ever. They stand together, and are
there with the package itself, because hooks of a fork run in the order in which they were
registered: what is imported later registers none. Before a fork they run from the last to the
first: a lock that a thread takes while it holds one of these is registered before them, as
`logging` does with its own when it is imported.

A thread that holds one may take it again: a signal's handler, or a finalizer, runs in the middle of
whatever its thread does, and may ask for a kernel itself.
"""

from __future__ import annotations

import importlib
import logging  # noqa: F401 - its lock is taken within ours: a fork takes it after them
import os
import sys
import threading
from types import ModuleType

KERNELS = threading.RLock()
"""The lock of the kernels of this process; held while a target is imported and builds one."""

COMPILER = threading.RLock()
"""The lock of a compiler's library, which one thread uses at a time."""

IMPORTS = threading.RLock()
"""The lock of the imports of public names; nothing that a module does while it is imported takes
the locks above."""


_OURS = ("freebody.", "freebody_textbook.", "freebody_notes.")
"""Beginnings of the names of this distribution's modules."""


def imported(module: str) -> ModuleType:
    """A module of freebody or of a package that comes with it, imported under a lock so that no
    fork happens in the middle."""
    with IMPORTS:
        return importlib.import_module(module)


def _take() -> None:
    KERNELS.acquire()
    COMPILER.acquire()
    IMPORTS.acquire()
    # modules that other threads import by a statement: asking for one again waits until it is there
    for name in [name for name in list(sys.modules) if name.startswith(_OURS)]:
        importlib.import_module(name)


def _release() -> None:
    IMPORTS.release()
    COMPILER.release()
    KERNELS.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take, after_in_parent=_release, after_in_child=_release)
