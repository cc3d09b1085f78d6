"""The loop of a kernel called step after step by compiled code."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freebody.targets.kernel import BatchLoop
from freebody.targets.llvm.loader import load
from freebody.targets.llvm.machine import object_code

_TEXT = """
define void @repeat(ptr %loop, ptr %samples, i64 %times, ptr %addresses, i64 %wide,
                    ptr %strides, i64 %far) {
entry:
  br label %step
step:
  %k = phi i64 [ 0, %entry ], [ %k.next, %run ]
  %args = phi ptr [ %addresses, %entry ], [ %args.next, %run ]
  %steps = phi ptr [ %strides, %entry ], [ %steps.next, %run ]
  %more = icmp slt i64 %k, %times
  br i1 %more, label %run, label %end
run:
  call void %loop(ptr %args, ptr %samples, ptr %steps, ptr null)
  %k.next = add i64 %k, 1
  %args.next = getelementptr ptr, ptr %args, i64 %wide
  %steps.next = getelementptr i64, ptr %steps, i64 %far
  br label %step
end:
  ret void
}
"""


def repeated(
    loop: BatchLoop, samples: int, addresses: NDArray[np.int64], strides: NDArray[np.int64]
) -> None:
    """Call the loop of a kernel once for each row of `addresses`, of its arguments, and `strides`,
    of their samples and then of their entries, as a gufunc's; both (T, …) in C order, strides that
    do not change (1, …). The GIL is released."""
    _code, run = _repeat()  # kept while it runs: two threads may have made one each
    run(
        loop.address,
        ctypes.byref(ctypes.c_int64(samples)),
        len(addresses),
        addresses.ctypes.data,
        addresses.shape[1],
        strides.ctypes.data,
        strides.shape[1] if len(strides) > 1 else 0,
    )


@cache
def _repeat() -> tuple[Any, Any]:
    """(what keeps the code, the C function)."""
    code, found = load([object_code(_TEXT)], ("repeat",), {})
    pointer, number = ctypes.c_void_p, ctypes.c_int64
    prototype = ctypes.CFUNCTYPE(None, pointer, pointer, number, pointer, number, pointer, number)
    return code, prototype(found["repeat"])
