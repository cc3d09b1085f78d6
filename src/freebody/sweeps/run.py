"""All blocks of a sweep: side by side in this process where the function allows it, or on a
cluster; results come in the order of the blocks."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from freebody.sweeps.evaluation import BlockResult, SweepBlock, SweepTask
from freebody.targets.threads import cpus

_AHEAD = 2
"""Blocks for each thread that may wait to be joined."""

Keep = Callable[[SweepBlock, BlockResult], object]
"""What is done with a block as soon as it is there."""


def evaluated(
    task: SweepTask, blocks: Iterable[SweepBlock], keep: Keep | None = None, client: Any = None
) -> Iterator[BlockResult]:
    """The result of each block, in order; few are held at a time."""
    if client is not None:
        from freebody.sweeps.cluster import on_cluster

        for block, result in on_cluster(task, blocks, client):
            if keep is not None:
                keep(block, result)
            yield result
    elif not task.function.threads or cpus() == 1:
        for block in blocks:
            yield _kept(task, block, keep)
    else:
        yield from _by_threads(task, blocks, keep)


def _kept(task: SweepTask, block: SweepBlock, keep: Keep | None) -> BlockResult:
    result = task(block)
    if keep is not None:
        keep(block, result)
    return result


def _by_threads(
    task: SweepTask, blocks: Iterable[SweepBlock], keep: Keep | None
) -> Iterator[BlockResult]:
    with ThreadPoolExecutor(cpus()) as pool:
        waiting: deque[Future[BlockResult]] = deque()
        try:
            for block in blocks:
                waiting.append(pool.submit(_kept, task, block, keep))
                if len(waiting) > _AHEAD * cpus():
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


Progress = Callable[[str, float], None]
"""What is being done, and which share of it is."""
