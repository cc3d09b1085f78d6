"""Share a batch among threads, which a process starts when first needed and a forked child anew.

The batch is cut along its longest axis. Every sample is computed by the same code whatever its place in the
batch, so the result does not depend on the cut. Parts wait in a queue from which the caller and the helpers
take them: who comes late finds it empty.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise
from queue import SimpleQueue
from typing import Any

import numpy as np

GRAIN = 16
"""Parts begin at multiples of this many samples, so that all but the last consist of whole vectors."""

_Jobs = SimpleQueue[Callable[[], None]]
_lock = threading.Lock()
_jobs: _Jobs = SimpleQueue()
_helpers = 0


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
    """Run `ufunc` on parts of the batch at the same time; what a part raises is raised when all are done.

    An interrupt outside a part drops the parts that nobody has begun; what is being computed keeps its arrays.

    Args:
        ufunc: releases the GIL.
        arrays: inputs, of batch shapes that broadcast to `batch`.
        outs: outputs, of the whole batch shape, that overlap nothing.
        cores: number of core axes of each input, then of each output.
        batch: the broadcast batch shape, at least one axis.
        threads: how many at most, the caller's among them.
    """
    axis = batch.index(max(batch))
    operands = [(x, core + len(batch) - axis) for x, core in zip((*arrays, *outs), cores, strict=True)]
    inputs, parts = len(arrays), _parts(batch[axis], threads)
    todo, done = deque(parts), SimpleQueue[BaseException | None]()

    def work() -> None:
        while True:
            try:
                start, stop = todo.popleft()
            except IndexError:
                return
            problem = None
            try:
                cut = [_cut(x, from_end, start, stop) for x, from_end in operands]
                ufunc(*cut[:inputs], out=tuple(cut[inputs:]))
            except BaseException as raised:
                problem = raised
            done.put(problem)

    for _ in range(_start(min(threads, len(parts)) - 1)):
        _jobs.put(work)
    try:
        work()
        problems = [problem for _ in parts if (problem := done.get())]
    except BaseException:
        todo.clear()
        raise
    if problems:
        raise problems[0]


def _parts(count: int, threads: int) -> list[tuple[int, int]]:
    """Starts and stops, one part a thread: a part more costs its thread ten microseconds, for it asks for the GIL."""
    size = -(-count // (threads * GRAIN)) * GRAIN
    return list(pairwise([*range(0, count, size), count]))


def _cut(array: np.ndarray, from_end: int, start: int, stop: int) -> np.ndarray:
    axis = array.ndim - from_end
    if axis < 0 or array.shape[axis] == 1:  # broadcast along the cut
        return array
    return array[(slice(None),) * axis + (slice(start, stop),)]


def _start(wanted: int) -> int:
    """Have as many helpers as that, or as many as the system gives; how many may be asked."""
    global _helpers
    with _lock:
        try:
            while _helpers < wanted:
                threading.Thread(target=_serve, args=(_jobs,), name="freebody", daemon=True).start()
                _helpers += 1
        except RuntimeError:  # no more threads, or the interpreter is ending: the caller does the rest
            pass
        return min(_helpers, wanted)


def _serve(jobs: _Jobs) -> None:
    while True:
        jobs.get()()


def _forget() -> None:
    """Threads do not survive a fork, and the lock may have been held."""
    global _helpers, _jobs, _lock
    _helpers, _jobs, _lock = 0, SimpleQueue(), threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
