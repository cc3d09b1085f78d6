"""All blocks of a sweep, in this process: side by side where the function allows it, joined in
their order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor

from freebody.sweeps.evaluation import BlockResult, SweepBlock, SweepTask
from freebody.targets.threads import cpus

_AHEAD = 2
"""Blocks for each thread that may wait to be joined."""


def evaluated(task: SweepTask, blocks: Iterable[SweepBlock]) -> Iterator[BlockResult]:
    """The result of each block, in order; few are held at a time."""
    if not task.function.threads or cpus() == 1:
        yield from map(task, blocks)
        return
    with ThreadPoolExecutor(cpus()) as pool:
        waiting: deque[Future[BlockResult]] = deque()
        try:
            for block in blocks:
                waiting.append(pool.submit(task, block))
                if len(waiting) > _AHEAD * cpus():
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


Progress = Callable[[str, float], None]
"""What is being done, and which share of it is."""
