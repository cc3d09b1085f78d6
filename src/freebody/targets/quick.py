"""The C function of a kernel, for callables that take more kinds of arguments than the kernel itself."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from freebody.targets.kernel import Kernel
from freebody.targets.llvm import fastcall


def quick(kernel: Kernel, general: Callable[..., Any]) -> Callable[..., Any] | None:
    """A function that is called as the kernel where all is plain, and goes to `general` otherwise; None without one."""
    call = kernel.__call__
    kept = getattr(call, "__self__", None)
    if not isinstance(kept, tuple):  # a method of a kernel that has no C function
        return None
    _, title, definition, code = kept
    address = struct.unpack(fastcall._METHOD_DEF, definition)[1]
    return fastcall.function(address, title.decode(), general, code)
