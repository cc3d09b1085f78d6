"""Sharing of a batch among threads, which a process starts on first need and a forked child anew.

The batch is cut along its longest axis. Every sample is computed by the same code whatever its
place in the batch, so the result does not depend on the cut. Parts wait in a queue from which the
caller and the helpers take them: who comes late finds it empty.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import prod
from queue import SimpleQueue
from typing import Any

import numpy as np

GRAIN = 16
"""Parts begin at multiples of this many samples, so that all but the last consist of whole
vectors."""

_Jobs = SimpleQueue[Callable[[], None]]
_lock = threading.RLock()  # a signal's handler may come while its thread starts helpers
_jobs: _Jobs = SimpleQueue()
_helpers = 0


def cpus() -> int:
    """The number of CPUs that this process may use."""
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
    longest: int = sys.maxsize,
) -> None:
    """Run `ufunc` on parts of the batch in several threads at a time; an exception in a part is
    raised when all are done.

    An interrupt drops the parts that nobody has begun, and waits no longer than a part takes; what
    is being computed keeps its arrays.

    Parameters
    ----------
    ufunc
        Releases the GIL.
    arrays
        Inputs, of batch shapes that broadcast to `batch`.
    outs
        Outputs, of the whole batch shape, that overlap nothing.
    cores
        Number of core axes of each input, then of each output.
    batch
        The broadcast batch shape, at least one axis.
    threads
        How many at most, the caller's among them.
    longest
        Samples that a part may have.
    """
    inputs, parts = len(arrays), list(_parts(batch, threads, longest))
    todo, done = deque(parts), SimpleQueue[BaseException | None]()

    def drop() -> None:
        with contextlib.suppress(IndexError):
            while True:
                todo.popleft()
                done.put(None)

    def work() -> None:
        while True:
            try:
                part = todo.popleft()
            except IndexError:
                return
            problem = None
            try:
                cut = [
                    _cut(x, x.ndim - core, part)
                    for x, core in zip((*arrays, *outs), cores, strict=True)
                ]
                ufunc(*cut[:inputs], out=tuple(cut[inputs:]))
            except BaseException as raised:
                problem = raised
            if isinstance(problem, KeyboardInterrupt):
                drop()
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


def _parts(batch: tuple[int, ...], threads: int, longest: int) -> Iterator[tuple[slice, ...]]:
    """Parts of the batch, cut along its longest axis; parts that are still too long are cut along
    further axes.

    One part a thread where that is short enough: a part more costs its thread ten microseconds, as
    it asks for the GIL.
    """
    axis = batch.index(max(batch))
    others = prod(batch) // batch[axis]
    count = max(threads, -(-batch[axis] * others // longest))
    size = min(-(-batch[axis] // count), max(1, longest // others))
    if GRAIN * others <= longest:
        size = -(-size // GRAIN) * GRAIN
    for start, stop in pairwise([*range(0, batch[axis], size), batch[axis]]):
        shorter = (*batch[:axis], 1, *batch[axis + 1 :])
        inner = _parts(shorter, 1, longest) if size == 1 and others > longest else [_whole(shorter)]
        for part in inner:
            yield (*part[:axis], slice(start, stop), *part[axis + 1 :])


def _whole(batch: tuple[int, ...]) -> tuple[slice, ...]:
    return (slice(None),) * len(batch)


def _cut(array: np.ndarray, axes: int, part: tuple[slice, ...]) -> np.ndarray:
    """The part of an array whose first `axes` axes broadcast to the last ones of the batch."""
    own = part[len(part) - axes :]
    return array[
        tuple(slice(None) if n == 1 else s for n, s in zip(array.shape, own, strict=False))
    ]


def _start(wanted: int) -> int:
    """The number of helper threads after starting as many as wanted, or as the system allows."""
    global _helpers
    with _lock:
        try:
            while _helpers < wanted:
                threading.Thread(target=_serve, args=(_jobs,), name="freebody", daemon=True).start()
                _helpers += 1
        except RuntimeError:
            pass  # no more threads, or the interpreter is ending: the caller does the rest
        return min(_helpers, wanted)


def _serve(jobs: _Jobs) -> None:
    while True:
        jobs.get()()


def _forget() -> None:
    """Reset the state of threads in a forked child, where no thread survives and the lock may have
    been held."""
    global _helpers, _jobs, _lock
    _helpers, _jobs, _lock = 0, SimpleQueue(), threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
