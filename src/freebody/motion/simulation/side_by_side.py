"""Many motions side by side, on step kernels: blocks of lanes that stay in the processor's caches,
shared among threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.motion.simulation.first_order_system import Drive
from freebody.motion.simulation.lane_torques import HeldTorque, LaneTorque
from freebody.motion.simulation.motion_lanes import MotionLanes
from freebody.motion.simulation.simulation import Simulated
from freebody.motion.simulation.step_sizes import Advance
from freebody.motion.simulation.steppers import State
from freebody.targets.threads import cpus

_BLOCK = 8192
"""Motions whose states stay in a processor's caches from step to step, and whose step lasts so long
that threads seldom wait for each other between two steps, as they do for Python."""
_LOOK = 0.05  # s
_ULPS = 8.0  # more than the rounding of a sum of steps
_FEWEST = 256
"""Motions that are worth a thread."""


@dataclass(frozen=True, eq=False)
class Course:
    """The times at which steps end (k,), and for each of them which row of the result it is, -1
    where it is none; at `calls`, some of the edges, a controller is called.

    spans: between which times the steps from an edge to the next go: these, but for rounding on the
    inner side of a jump of the torque.
    """

    edges: Array
    spans: list[tuple[float, float]]
    rows: NDArray[np.intp]
    calls: tuple[int, ...]


def course(t: Array, every: int, others: Array, calls: Array) -> Course:
    """Of the times t, of which every so many are kept, other times at which steps end, and those of
    a controller's calls; those within rounding of each other are one."""
    near = 1e-9 * min(np.diff(t).min(), np.diff(calls).min() if len(calls) > 1 else np.inf)
    more = np.concatenate([others, calls])
    more = more[(more > t[0] + near) & (more < t[-1] - near)]
    places = np.clip(np.searchsorted(t, more), 1, len(t) - 1)
    apart = np.minimum(np.abs(more - t[places - 1]), np.abs(more - t[places]))
    edges = np.unique(np.concatenate([t, more[apart > near]]))
    rows = np.full(len(edges), -1)
    rows[np.searchsorted(edges, t[::every])] = np.arange(len(t[::every]))
    inner = _ULPS * np.spacing(edges) * np.isin(edges, others)
    spans = [*zip((edges + inner)[:-1].tolist(), (edges - inner)[1:].tolist(), strict=True)]
    called = sorted({int(np.abs(edges - x).argmin()) for x in calls})
    return Course(edges, spans, rows, tuple(called))


@dataclass(eq=False)
class Walk:
    """Moves all lanes over a course.

    controller: of (t, q, qd) of all lanes, what the torque holds from each call to the next.
    """

    course: Course
    advance: Advance
    lanes: MotionLanes
    state: State
    result: Simulated
    controller: Drive | None
    torque: LaneTorque | None
    threads: int | None
    tell: Callable[[float], None]
    stop: threading.Event
    """Set where an interrupt ends the steps; `advance` looks at it too."""

    @property
    def rows(self) -> int:
        """States that are moved on each by itself."""
        return len(self.state[0])

    def run(self) -> None:
        """Fill in the result."""
        starts = self.course.calls or (0,)
        ends = (*starts[1:], len(self.course.edges) - 1)
        threads = self.threads or cpus()
        size = min(_BLOCK, max(_FEWEST, ceil(self.rows / threads)))
        blocks = [slice(k, min(k + size, self.rows)) for k in range(0, self.rows, size)]
        threads = min(threads, len(blocks))
        self._record(slice(0, self.rows), 0, self.state)
        reached = np.zeros(len(blocks))
        with ThreadPoolExecutor(threads) as pool:
            for first, last in zip(starts, ends, strict=True):
                if self.controller is not None:
                    self._call(self.controller, first, last)
                if threads == 1:
                    for _ in self._section(blocks, first, last, reached):
                        self.tell(float(reached.mean()))
                else:
                    self._shared(pool, blocks, first, last, reached)

    def _shared(
        self, pool: ThreadPoolExecutor, blocks: list[slice], first: int, last: int, reached: Array
    ) -> None:
        """A section of all blocks by several threads; an interrupt ends them at the next step."""

        def run(k: int) -> None:
            for _ in self._section(blocks[k : k + 1], first, last, reached[k : k + 1]):
                pass

        running = [pool.submit(run, k) for k in range(len(blocks))]
        try:
            # in slices of time: an interrupt may have come to another thread
            while wait(running, timeout=_LOOK).not_done:
                self.tell(float(reached.mean()))
        except BaseException:
            self.stop.set()
            for future in running:
                future.cancel()
            raise
        for future in running:
            future.result()

    def _section(
        self, blocks: list[slice], first: int, last: int, reached: Array
    ) -> Iterator[None]:
        """One block after the other from one edge to another; stops at each edge. reached: the part
        of the course that each has behind it."""
        edges = self.course.edges
        q, qd = self.state
        for at, block in enumerate(blocks):
            state = q[block], qd[block]
            for k in range(first, last):
                state = self.advance(block, state, *self.course.spans[k])
                if self.stop.is_set():
                    return
                if self.course.rows[k + 1] >= 0:
                    self._record(block, k + 1, state)
                reached[at] = (edges[k + 1] - edges[0]) / (edges[-1] - edges[0])
                yield
            q[block], qd[block] = state

    def _record(self, block: slice, edge: int, state: State) -> None:
        row = self.course.rows[edge]
        for kept, x in zip((self.result.q, self.result.qd), state, strict=True):
            every = kept.reshape(self.rows, -1, *kept.shape[-2:])
            every[block, :, row] = x.reshape(len(x), every.shape[1], kept.shape[-1])

    def _call(self, controller: Drive, first: int, last: int) -> None:
        """The controller, at an edge; its torque is recorded until the next call, the one before at
        the end of all."""
        assert isinstance(self.torque, HeldTorque)
        q, qd = (x.reshape(*self.lanes.shape, -1) for x in self.state)
        now = np.asarray(self.course.edges[first])
        self.torque.tau[:] = self.lanes.all(controller(now, q, qd), 1)
        if self.result.tau is not None:
            every = self.result.tau.reshape(self.lanes.count, *self.result.tau.shape[-2:])
            rows = self.course.rows[first : last + (last == len(self.course.edges) - 1)]
            every[:, rows[rows >= 0]] = self.torque.tau[:, None]
