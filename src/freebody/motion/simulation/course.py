"""The times at which steps of a simulation end, and the states of all lanes along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.motion.simulation.simulation import Simulated
from freebody.motion.simulation.steppers import State
from freebody.motion.simulation.torques import merged

_ULPS = 8.0  # more than the rounding of a sum of steps


@dataclass(frozen=True, eq=False)
class Course:
    """The times at which steps end (k,), and for each of them which row of the result it is, -1
    where it is none; at `calls`, some of the edges, a controller is called.

    begins, ends (k - 1,): between which times the steps from an edge to the next go: these, but for
    rounding on the inner side of a jump of the torque.
    """

    edges: Array
    begins: Array
    ends: Array
    rows: NDArray[np.intp]
    calls: tuple[int, ...]


def course(t: Array, every: int, others: Array, calls: Array) -> Course:
    """Of the times t, of which every so many are kept, other times at which steps end, and those of
    a controller's calls; those within rounding of each other are one."""
    near = 1e-9 * min(np.diff(t).min(), np.diff(calls).min() if len(calls) > 1 else np.inf)
    jumps = np.unique(others)
    apart = jumps[np.diff(jumps, prepend=-np.inf) > near]
    edges = merged(t, np.concatenate([apart, calls]), near)
    rows = np.full(len(edges), -1)
    rows[np.searchsorted(edges, t[::every])] = np.arange(len(t[::every]))
    place = _nearest(edges, jumps)
    off = np.abs(edges[place] - jumps)
    at = off <= near
    inner = np.zeros(len(edges))
    np.maximum.at(inner, place[at], off[at] + _ULPS * np.spacing(np.abs(edges).max()))
    called = np.unique(_nearest(edges, calls)).tolist()
    return Course(edges, (edges + inner)[:-1], (edges - inner)[1:], rows, tuple(called))


def _nearest(edges: Array, times: Array) -> NDArray[np.intp]:
    """Which of the increasing edges is nearest to each time."""
    after = np.clip(np.searchsorted(edges, times), 1, len(edges) - 1)
    return after - (times - edges[after - 1] < edges[after] - times)


@dataclass(eq=False)
class Track:
    """The states of all lanes on a course, q (rows, n) and q̇ (rows, n): now, and in the result.

    Each row is moved on by itself: a lane, or all that are moved together.
    """

    course: Course
    state: State
    result: Simulated

    @property
    def rows(self) -> int:
        """How many."""
        return len(self.state[0])

    def kept(self, block: slice) -> list[Array]:
        """What the result has of q and q̇ of some rows, (rows, lanes of each, R, …), to be filled
        in."""
        all_of = ((x, x.shape[-2:]) for x in (self.result.q, self.result.qd))
        return [x.reshape(self.rows, -1, *core)[block] for x, core in all_of]

    def record(self, block: slice, edge: int, state: State) -> None:
        """Put states at an edge where they belong, if anywhere."""
        row = self.course.rows[edge]
        if row >= 0:
            for kept, x in zip(self.kept(block), state, strict=True):
                kept[:, :, row] = x.reshape(len(x), kept.shape[1], kept.shape[-1])
