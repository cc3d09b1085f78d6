"""The blocks of a sweep on a Dask cluster: the same code, the same blocks, joined in the same
order."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import islice
from math import ceil
from typing import Any

from freebody.errors import FreebodyError, MissingPackageError
from freebody.locks import imported
from freebody.sweeps.evaluation import BlockResult, SweepBlock, SweepTask
from freebody.targets.llvm.machine import host

_WORTH = 0.5
"""Seconds of work that are worth sending."""
_MOST = 64
"""Blocks that are sent together."""
_AHEAD = 2
"""Pieces of work for each thread of the cluster that may wait to be joined."""


def on_cluster(
    task: SweepTask, blocks: Iterable[SweepBlock], client: Any
) -> Iterator[tuple[SweepBlock, BlockResult]]:
    """The result of each block, in order; few are held at a time.

    client: a `distributed.Client`, or the address of a scheduler. What a lost worker had is done
    again by another.
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
        yield from _joined(task, iter(blocks), used)
    except (distributed.scheduler.KilledWorker, distributed.client.FutureCancelledError) as failure:
        raise FreebodyError(
            f"sweep: the cluster lost its workers: {failure} With store=, what is done is kept."
        ) from None
    finally:
        if opened:
            used.close()


def _joined(
    task: SweepTask, blocks: Iterator[SweepBlock], client: Any
) -> Iterator[tuple[SweepBlock, BlockResult]]:
    sent = client.scatter(task, broadcast=True)
    waiting: deque[tuple[list[SweepBlock], Any]] = deque()
    together = 1
    try:
        while True:
            room = _AHEAD * max(1, sum(client.nthreads().values())) - len(waiting)
            for _ in range(room):
                some = list(islice(blocks, together))
                if not some:
                    break
                waiting.append((some, client.submit(_done, sent, some, repr(host()), pure=False)))
            if not waiting:
                return
            some, future = waiting.popleft()
            results, seconds = future.result()
            together = max(1, min(_MOST, ceil(_WORTH * len(some) / max(seconds, 1e-3))))
            yield from zip(some, results, strict=True)
    finally:
        client.cancel([future for _, future in waiting])


def _done(task: SweepTask, blocks: list[SweepBlock], cpu: str) -> tuple[list[BlockResult], float]:
    """On a worker: the results, and the seconds that they took."""
    if repr(host()) != cpu:
        raise FreebodyError(
            "sweep: a worker's processor is not of the kind of this machine's, so that last digits "
            "would depend on who computed what. Run the sweep on machines of one kind."
        )
    start = time.perf_counter()
    return [task(block) for block in blocks], time.perf_counter() - start
