"""All blocks of a sweep: one after the other in this process, or on a cluster; results come in the
order of the blocks.

Here a block is shared among the processors, and is kept before the next one is begun: what stops
the process costs at most the one block that was under way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from freebody.sweeps.axes import SweepGrid
from freebody.sweeps.evaluation import BlockResult, Keep, SweepBlock, SweepTask
from freebody.targets.threads import cpus

Progress = Callable[[str, float], None]
"""How far it is, in words and as a share."""


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


def points_of(block: SweepBlock) -> int:
    """How many points a block has."""
    return len(block.rows) * len(block.columns)


class Watched:
    """Tells how far a sweep is, block by block, and how quick."""

    def __init__(self, grid: SweepGrid, progress: Progress | None, found: int = 0):
        """found: points that were done before."""
        self._found, self._here, self._whole = found, 0, grid.shape[0] * grid.shape[1]
        self._progress, self._begun = progress, time.monotonic()

    def __call__(self, block: SweepBlock, result: BlockResult) -> BlockResult:
        """The same result, when the caller has been told."""
        self._here += points_of(block)
        if self._progress is not None:
            done = self._found + self._here
            rate = self._here / max(time.monotonic() - self._begun, 1e-6)
            left = (self._whole - done) / rate
            self._progress(
                f"{done:.3g} of {self._whole:.3g} points, {rate:.2g} per second, {left:.0f} s left",
                done / self._whole,
            )
        return result
