"""Share a batch among threads: one pool a process, made when first needed, forgotten in a forked child.

The batch is cut along its longest axis. Every sample is computed by the same code whatever its place in the
batch, so the result does not depend on the cut.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

GRAIN = 64
"""Parts begin at multiples of this many samples, so that all but the last consist of whole vectors."""

_lock = threading.Lock()
_pool: ThreadPoolExecutor | None = None


def cpus() -> int:
    """CPUs that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_split(
    ufunc: Callable[..., Any],
    arrays: Sequence[np.ndarray],
    outs: Sequence[np.ndarray],
    cores: Sequence[int],
    batch: tuple[int, ...],
    threads: int,
) -> None:
    """Run `ufunc` on parts of the batch at the same time; the caller's thread takes the first part.

    Args:
        ufunc: releases the GIL.
        arrays: inputs, of batch shapes that broadcast to `batch`.
        outs: outputs, of the whole batch shape, that overlap nothing.
        cores: number of core axes of each input, then of each output.
        batch: the broadcast batch shape, at least one axis.
        threads: how many parts at most.
    """
    axis = batch.index(max(batch))
    from_end = len(batch) - axis
    size = -(-batch[axis] // threads)
    size = -(-size // GRAIN) * GRAIN if size > GRAIN else size
    operands = [*arrays, *outs]

    def part(start: int) -> None:
        cut = [_cut(x, core + from_end, start, start + size) for x, core in zip(operands, cores, strict=True)]
        ufunc(*cut[: len(arrays)], out=tuple(cut[len(arrays) :]))

    starts = range(0, batch[axis], size)
    pending = [_executor().submit(part, start) for start in starts[1:]]
    try:
        part(0)
    finally:
        for future in pending:
            future.result()


def _cut(array: np.ndarray, from_end: int, start: int, stop: int) -> np.ndarray:
    axis = array.ndim - from_end
    if axis < 0 or array.shape[axis] == 1:  # broadcast along the cut
        return array
    return array[(slice(None),) * axis + (slice(start, stop),)]


def _executor() -> ThreadPoolExecutor:
    global _pool
    with _lock:
        if _pool is None:
            _pool = ThreadPoolExecutor(max(32, cpus()), thread_name_prefix="freebody")
        return _pool


def _forget() -> None:
    """The threads of a pool do not survive a fork, and its lock may have been held."""
    global _pool, _lock
    _pool, _lock = None, threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
