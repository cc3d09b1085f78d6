"""The loop of a kernel called step after step by compiled code: between two calls only the
addresses of its arrays move on."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from freebody.targets.kernel import BatchLoop
from freebody.targets.llvm.loader import load
from freebody.targets.llvm.machine import object_code

_TEXT = """
define void @repeat(ptr %loop, ptr %args, ptr %dims, ptr %steps, i64 %times,
                    i64 %count, ptr %moves) {
entry:
  br label %step
step:
  %k = phi i64 [ 0, %entry ], [ %k.next, %moved ]
  %more = icmp slt i64 %k, %times
  br i1 %more, label %run, label %end
run:
  call void %loop(ptr %args, ptr %dims, ptr %steps, ptr null)
  br label %move
move:
  %i = phi i64 [ 0, %run ], [ %i.next, %next ]
  %some = icmp slt i64 %i, %count
  br i1 %some, label %next, label %moved
next:
  %place = getelementptr ptr, ptr %args, i64 %i
  %address = load ptr, ptr %place, align 8
  %distance = getelementptr i64, ptr %moves, i64 %i
  %by = load i64, ptr %distance, align 8
  %new = getelementptr i8, ptr %address, i64 %by
  store ptr %new, ptr %place, align 8
  %i.next = add i64 %i, 1
  br label %move
moved:
  %k.next = add i64 %k, 1
  br label %step
end:
  ret void
}
"""


def repeated(loop: BatchLoop, states: np.ndarray, sequences: Sequence[np.ndarray]) -> None:
    """Fill in states (T + 1, N, s) after the first one by the loop of a kernel (state, *inputs) ->
    state.

    sequences: its inputs (T, N, …) after the state. The GIL is released.
    """
    arrays = [states[:-1], *sequences, states[1:]]
    cores = [stride for x in arrays for stride in x.strides[2:]]
    numbers = [x.ctypes.data for x in arrays]
    _repeat()[1](
        loop.address,
        _integers(numbers),
        _integers([states.shape[1]]),
        _integers([*(x.strides[1] for x in arrays), *cores]),
        len(states) - 1,
        len(arrays),
        _integers([x.strides[0] for x in arrays]),
    )


def _integers(values: Sequence[int]) -> Any:
    return (ctypes.c_int64 * len(values))(*values)


@cache
def _repeat() -> tuple[Any, Any]:
    """(what keeps the code, the C function)."""
    code, addresses = load([object_code(_TEXT)], ("repeat",), {})
    pointer, number = ctypes.c_void_p, ctypes.c_int64
    prototype = ctypes.CFUNCTYPE(None, pointer, pointer, pointer, pointer, number, number, pointer)
    return code, prototype(addresses["repeat"])
