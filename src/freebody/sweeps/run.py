"""All blocks of a sweep: one after the other in this process, or on a cluster; results come in the
order of the blocks.

Here a block is shared among the processors, and is kept before the next one is begun: what stops
the process costs at most the one block that was under way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from freebody.sweeps.evaluation import BlockResult, Keep, SweepBlock, SweepTask
from freebody.targets.threads import cpus

Progress = Callable[[str, float], None]
"""What is being done, and which share of it is."""


def evaluated(
    task: SweepTask, blocks: Iterable[SweepBlock], keep: Keep | None = None, client: Any = None
) -> Iterator[BlockResult]:
    """The result of each block, in order; few are held at a time."""
    if client is not None:
        from freebody.sweeps.cluster import on_cluster

        yield from on_cluster(task, blocks, keep, client)
    elif not task.function.threads or cpus() == 1:
        yield from _one_by_one(task, blocks, keep)
    else:
        with ThreadPoolExecutor(cpus()) as pool:
            yield from _one_by_one(task, blocks, keep, pool)


def _one_by_one(
    task: SweepTask,
    blocks: Iterable[SweepBlock],
    keep: Keep | None,
    pool: ThreadPoolExecutor | None = None,
) -> Iterator[BlockResult]:
    for block in blocks:
        result = task(block) if pool is None else task(block, pool.map)
        if keep is not None:
            keep(block, result)
        yield result
