"""Many motions side by side: blocks of lanes that stay in the processor's caches, shared among
threads."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from math import ceil

import numpy as np

from freebody.arrays import Array
from freebody.motion.simulation.course import Track
from freebody.motion.simulation.first_order_system import Drive
from freebody.motion.simulation.lane_torques import HeldTorque, LaneTorque
from freebody.motion.simulation.motion_lanes import MotionLanes
from freebody.motion.simulation.step_sizes import Advance
from freebody.motion.simulation.unending import SampledGrowth
from freebody.targets.threads import cpus

_LOOK = 0.05  # s
_FEWEST = 256
"""Motions that are worth a thread."""

_Blocks = deque[tuple[int, slice]]
"""Blocks that are to be moved, and which they are."""


@dataclass(eq=False)
class Walk:
    """Moves all lanes over a course.

    controller: of (t, q, qd) of all lanes, what the torque holds from each call to the next.
    growth: looks at the rates there; motions without hope are NaN from there.
    """

    track: Track
    advance: Advance
    lanes: MotionLanes
    controller: Drive | None
    torque: LaneTorque | None
    growth: SampledGrowth | None
    threads: int | None
    tell: Callable[[float], None]
    stop: threading.Event
    """Set where an interrupt ends the steps; `advance` looks at it too."""

    def run(self) -> None:
        """Fill in the result."""
        way, rows = self.track.course, self.track.rows
        starts = way.calls or (0,)
        ends = (*starts[1:], len(way.edges) - 1)
        threads = self.threads or cpus()
        size = min(self.advance.block, max(_FEWEST, ceil(rows / threads)))
        blocks = [slice(k, min(k + size, rows)) for k in range(0, rows, size)]
        threads = min(threads, len(blocks))
        self.track.record(slice(0, rows), 0, self.track.state)
        reached = np.zeros(len(blocks))
        with ThreadPoolExecutor(threads) as pool:
            for first, last in zip(starts, ends, strict=True):
                if self.controller is not None:
                    self._call(self.controller, first, last)
                todo = deque(enumerate(blocks))
                if threads == 1:
                    for _ in self._section(todo, first, last, reached):
                        self.tell(float(reached.mean()))
                else:
                    self._shared(pool, threads, todo, first, last, reached)

    def _shared(
        self,
        pool: ThreadPoolExecutor,
        threads: int,
        todo: _Blocks,
        first: int,
        last: int,
        reached: Array,
    ) -> None:
        """A section of all blocks by several threads; an interrupt ends them soon."""

        def run() -> None:
            for _ in self._section(todo, first, last, reached):
                pass

        running = [pool.submit(run) for _ in range(threads)]
        try:
            # in slices of time: an interrupt may have come to another thread
            while wait(running, timeout=_LOOK).not_done:
                self.tell(float(reached.mean()))
        except BaseException:
            self.stop.set()
            raise
        for future in running:
            future.result()

    def _section(self, todo: _Blocks, first: int, last: int, reached: Array) -> Iterator[None]:
        """Blocks that nobody has taken, from one edge to another; stops now and then. reached: the
        part of the course that each has behind it."""
        begin, end = self.track.course.edges[[0, -1]]
        while not self.stop.is_set():
            try:
                at, block = todo.popleft()
            except IndexError:
                return
            for now in self.advance(self.track, block, first, last):
                reached[at] = (now - begin) / (end - begin)
                yield

    def _call(self, controller: Drive, first: int, last: int) -> None:
        """The controller, at an edge; its torque is recorded until the next call, the one before at
        the end of all."""
        assert isinstance(self.torque, HeldTorque)
        if self.growth is not None and self.track.rows == self.lanes.count:
            lost = self.growth.hopeless(self.track.state[1])
            for x in self.track.state:
                x[lost] = np.nan
        q, qd = (x.reshape(*self.lanes.shape, -1) for x in self.track.state)
        way, result = self.track.course, self.track.result
        now = np.asarray(way.edges[first])
        self.torque.tau[:] = self.lanes.all(controller(now, q, qd), 1)
        if result.tau is not None:
            every = result.tau.reshape(self.lanes.count, *result.tau.shape[-2:])
            rows = way.rows[first : last + (last == len(way.edges) - 1)]
            every[:, rows[rows >= 0]] = self.torque.tau[:, None]
