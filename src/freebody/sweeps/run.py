"""The evaluation of all blocks of a sweep, one after the other in this process or on a Dask
cluster; results come in the order of the blocks.

Here a block is shared among the processors, and is kept before the next one is begun: what stops
the process costs at most the one block that was under way. On a cluster the same code evaluates the
same blocks.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import islice
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

from freebody.errors import FreebodyError, MissingPackageError, listed
from freebody.locks import imported
from freebody.sweeps.axes import SweepGrid
from freebody.sweeps.evaluation import BlockResult, Keep, SweepBlock, SweepTask
from freebody.sweeps.identity import SweepNeeds, computed_with, differing, needs_of
from freebody.targets import KernelError
from freebody.targets.threads import cpus

if TYPE_CHECKING:
    from freebody.motion.simulation.run import Progress

_WORTH = 0.5
"""Seconds of work that are worth sending to a worker."""
_MOST = 64
"""The largest number of blocks that are sent together."""
_AHEAD = 2
"""Pieces for each thread of the cluster that may wait here for one before them."""


def evaluated(
    task: SweepTask, blocks: Iterable[SweepBlock], keep: Keep | None = None, client: Any = None
) -> Iterator[BlockResult]:
    """The result of each block in order; few are held in memory at a time."""
    if client is not None:
        yield from _on_cluster(task, blocks, keep, client)
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


def _on_cluster(
    task: SweepTask, blocks: Iterable[SweepBlock], keep: Keep | None, client: Any
) -> Iterator[BlockResult]:
    """The result of each block, computed on a cluster, in order; few are held in memory at a time.

    keep: is given each block as soon as its result is here, in whatever order they come.
    client: a `distributed.Client`, or the address of a scheduler. What a lost worker had under way
    is done again by another.
    """
    try:
        distributed = imported("distributed")
    except ModuleNotFoundError:
        raise MissingPackageError("sweep: client=", "distributed", "sweep") from None
    opened = isinstance(client, str)
    try:
        used = distributed.Client(client) if opened else client
    except (OSError, ValueError) as failure:
        raise FreebodyError(f"sweep: no Dask cluster answers at {client!r}: {failure}") from None
    if not isinstance(used, distributed.Client):
        raise FreebodyError(
            "sweep: client= takes a distributed.Client, or the address of a scheduler such as "
            "'tcp://10.0.0.1:8786'."
        )
    try:
        yield from _in_order(task, iter(blocks), keep, used, distributed.as_completed)
    except (distributed.scheduler.KilledWorker, distributed.client.FutureCancelledError) as failure:
        raise FreebodyError(
            f"sweep: the cluster lost its workers: {failure} With store=, what is done is kept."
        ) from None
    finally:
        if opened:
            used.close()


def _in_order(
    task: SweepTask,
    blocks: Iterator[SweepBlock],
    keep: Keep | None,
    client: Any,
    as_completed: Callable[..., Any],
) -> Iterator[BlockResult]:
    """Results from a cluster in the order of the blocks: those that arrive early wait. Each thread
    has one piece at a time and gets the next when its result is here, so that a lost worker holds
    up no more."""
    # as bytes: what a worker cannot read would break its connection instead of being said
    packed = imported("cloudpickle").dumps(task)
    needs = needs_of(task)
    sent, here = client.scatter(packed, broadcast=True), computed_with(needs)
    coming = as_completed(with_results=True)
    pieces: dict[Any, _SentBlocks] = {}
    arrived: dict[int, list[BlockResult]] = {}
    together, begun, joined = 1, 0, 0
    try:
        while True:
            threads = max(1, sum(client.nthreads().values()))
            room = threads - len(pieces)
            waiting = begun - joined - len(pieces)
            for _ in range(min(room, _AHEAD * threads - waiting)):
                some = list(islice(blocks, together))
                if not some:
                    break
                future = client.submit(_done, sent, some, needs, here, pure=False)
                pieces[future] = _SentBlocks(begun, some)
                begun += 1
                coming.add(future)
            if not pieces:
                return
            future, (results, seconds) = next(coming)
            piece = pieces.pop(future)
            if keep is not None:
                for block, result in zip(piece.blocks, results, strict=True):
                    keep(block, result)
            arrived[piece.number] = results
            count = len(piece.blocks)
            together = max(1, min(_MOST, ceil(_WORTH * count / max(seconds, 1e-3))))
            while joined in arrived:
                yield from arrived.pop(joined)
                joined += 1
    finally:
        client.cancel(list(pieces))


class _SentBlocks(NamedTuple):
    """Blocks that are sent to a worker together, with their number in the order of all pieces."""

    number: int
    blocks: list[SweepBlock]


def _done(
    packed: bytes, blocks: list[SweepBlock], needs: SweepNeeds, wanted: Mapping[str, str]
) -> tuple[list[BlockResult], float]:
    """The results of blocks on a worker, and the seconds they took; refuses a worker with other
    libraries."""
    others = differing(wanted, computed_with(needs))
    if others:
        advice = "Run the sweep on machines of one kind, with the same packages"
        raise FreebodyError(
            f"sweep: a worker has another {listed(others)} than this machine, so the last digits "
            f"would depend on which computed what. {advice}, or name in cpu= a level that all "
            f'processors reach, such as "x86-64-v3".'
        )
    try:
        task = _unpickled(packed)
    except KernelError as problem:
        raise FreebodyError(f"sweep, on a worker of the cluster: {problem}") from None
    start = time.perf_counter()
    return [task(block) for block in blocks], time.perf_counter() - start


@lru_cache(maxsize=1)
def _unpickled(packed: bytes) -> SweepTask:
    """The task, unpickled once for all blocks; its kernel is compiled, or found in the cache."""
    task: SweepTask = pickle.loads(packed)
    return task


def points_of(block: SweepBlock) -> int:
    """The number of points of a block."""
    return len(block.rows) * len(block.columns)


class Watched:
    """A reporter of a sweep's progress, block by block, and of its speed."""

    def __init__(self, grid: SweepGrid, progress: Progress | None, found: int = 0):
        """Begin a report; found: the number of points that were done before."""
        self._found, self._here, self._whole = found, 0, grid.shape[0] * grid.shape[1]
        self._progress, self._begun = progress, time.monotonic()

    def __call__(self, block: SweepBlock, result: BlockResult) -> BlockResult:
        """The block's result, after reporting progress with it."""
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
