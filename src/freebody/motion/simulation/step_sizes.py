"""Steps from one time to the next: the times at which steps of many motions end; equal steps, made
one by one or many in a compiled call; and steps that each motion chooses by its error."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.motion.simulation.contact_events import ContactEvents
from freebody.motion.simulation.one_step import KernelStepper, LaneState, Stepper
from freebody.motion.simulation.results import Simulated
from freebody.motion.simulation.run import Some, merged
from freebody.motion.simulation.unending import IN_A_ROW, MOST, GivenUp, Growth
from freebody.targets.in_turn import Placed

_ULPS = 8.0  # more than the rounding of a sum of steps
_ROUND = 1e-9  # of a step: what is left of an interval that rounding left
_SHORTEST = 1e-13  # of the duration, or of 1 s: steps this short lead nowhere
_WATCHED = 50  # steps between two looks at the shortest
_SAFETY, _SMALLEST, _LARGEST = 0.9, 0.2, 4.0  # of a step: how much the next may differ
STAYING = 1024
"""Motions whose states, numbers and torques stay in a processor's caches from step to step."""
_MOST_AT_ONCE = 4096
"""Steps of a call, whose addresses stay there too."""


@dataclass(frozen=True, eq=False)
class StepTimes:
    """The times at which steps end (k,), with the result's row for each (-1: none); at `calls`,
    some of these edges, a controller is called.

    begins, ends (k - 1,): between which times the steps from an edge to the next go: these, but for
    rounding on the inner side of a jump of the torque.
    """

    edges: Array
    begins: Array
    ends: Array
    rows: NDArray[np.intp]
    calls: tuple[int, ...]


def step_times(t: Array, every: int, others: Array, calls: Array) -> StepTimes:
    """The times at which steps end: the times t, every `every`-th of which is kept, further times,
    and those of a controller's calls; times that differ by rounding only are merged."""
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
    return StepTimes(edges, (edges + inner)[:-1], (edges - inner)[1:], rows, tuple(called))


def _nearest(edges: Array, times: Array) -> NDArray[np.intp]:
    """The index of the increasing edge nearest to each time."""
    after = np.clip(np.searchsorted(edges, times), 1, len(edges) - 1)
    return after - (times - edges[after - 1] < edges[after] - times)


@dataclass(eq=False)
class LaneMotions:
    """The states of all lanes, q (rows, n) and q̇ (rows, n), now and in the result.

    Each row is moved on by itself: a lane, or all that are moved together.
    """

    times: StepTimes
    state: LaneState
    result: Simulated

    @property
    def rows(self) -> int:
        """The number of rows of states."""
        return len(self.state[0])

    def kept(self, block: slice) -> list[Array]:
        """The views of the result for q and q̇ of some rows, (rows, lanes of each, R, …), to be
        filled in."""
        all_of = ((x, x.shape[-2:]) for x in (self.result.q, self.result.qd))
        return [x.reshape(self.rows, -1, *core)[block] for x, core in all_of]

    def record(self, block: slice, edge: int, state: LaneState) -> None:
        """Put the states at an edge into the result, if it has a row for them."""
        row = self.times.rows[edge]
        if row >= 0:
            for kept, x in zip(self.kept(block), state, strict=True):
                kept[:, :, row] = x.reshape(len(x), kept.shape[1], kept.shape[-1])


class Advance(Protocol):
    """A way to move rows of states from edge to edge. block: the best number of rows to move
    together."""

    block: int

    def __call__(
        self, motions: LaneMotions, block: slice, first: int, last: int
    ) -> Iterator[float]:
        """Move the states from one edge to another and record those of the result; NaN where a
        motion cannot go on. Yields times in between."""
        ...


@dataclass(eq=False)
class SpanBySpan:
    """A way to move rows from edge to edge in Python. through: (rows, their states, two times) ->
    the states at the second time."""

    through: Callable[[slice, LaneState, float, float], LaneState]
    stop: threading.Event
    block: int = 8192
    """Number of lanes in a block, so large that a step lasts long: threads wait for each other
    between two steps, for Python."""

    def __call__(
        self, motions: LaneMotions, block: slice, first: int, last: int
    ) -> Iterator[float]:
        """Move rows from edge to edge; see `Advance`."""
        times, (q, qd) = motions.times, motions.state
        state = q[block], qd[block]
        for k in range(first, last):
            state = self.through(block, state, float(times.begins[k]), float(times.ends[k]))
            if self.stop.is_set():
                return
            motions.record(block, k + 1, state)
            yield float(times.edges[k + 1])
        q[block], qd[block] = state


@dataclass(eq=False)
class FixedSteps:
    """Equal steps of at most `step` (s; None: one from edge to edge) that Python makes one by
    one."""

    stepper: Stepper
    step: float | None
    stop: threading.Event
    events: ContactEvents | None = None

    def __call__(self, lanes: slice, state: LaneState, start: float, end: float) -> LaneState:
        """The states at the end of a span; see `SpanBySpan`."""
        if self.events is not None:
            state = self.events.begin(lanes, state, start)
        count = int(step_counts(np.asarray(end - start), self.step))
        h = (end - start) / count
        for k in range(count):
            if self.stop.is_set():
                break
            before, now = state, start + k * h
            state = self.stepper.step(lanes, before, now, h)
            if self.events is not None:
                state = self.events.through(lanes, before, state, now, h, self.stepper.step)
        return state


def step_counts(lengths: Array, step: float | None) -> NDArray[np.intp]:
    """The number of equal steps of at most `step` (s; None: one) in each interval."""
    if step is None:
        return np.ones(lengths.shape, dtype=np.intp)
    return np.maximum(1, np.ceil(lengths / step - _ROUND).astype(np.intp))


@dataclass(eq=False)
class ControlledSteps:
    """Steps whose length each lane chooses by its error: each step is made twice, whole and in
    halves, and the difference tells the error (Hairer, Norsett and Wanner 1993, II.4).

    tolerance: relative error of a step of order 4, a hundredth of it absolute. end: of the run, to
    which a motion that takes too many short steps does not come. extrapolated:
    whether the difference corrects the result, which then is of order 5; not where coordinates do
    not simply add. sizes (lanes,): with which each goes on.
    """

    stepper: Stepper
    tolerance: float
    max_step: float
    duration: float
    end: float
    extrapolated: bool
    sizes: Array
    stop: threading.Event
    events: ContactEvents | None = None
    watch: Callable[[int, float, LaneState, float], None] | None = None
    """Function that is told now and then of a lane, a time, its state there, and the step it
    took."""
    order: int = 4
    given_up: dict[int, GivenUp] = field(default_factory=dict)
    """The last steps of motions that were given up, by lane."""
    growth: Growth = field(init=False)
    slow: NDArray[np.intp] = field(init=False)
    """The number of steps in a row of each lane that were too short for the end to be reached."""

    def __post_init__(self) -> None:
        self.slow = np.zeros(len(self.sizes), dtype=int)
        self.growth = Growth(len(self.sizes), self.end)

    def __call__(self, lanes: slice, state: LaneState, start: float, end: float) -> LaneState:
        """The states at the end of a span; see `SpanBySpan`."""
        if self.events is not None:
            state = self.events.begin(lanes, state, start)
        q, qd = (x.copy() for x in state)
        now, sizes = np.full(len(q), start), self.sizes[lanes]
        first = range(self.sizes.shape[0])[lanes].start
        going = np.flatnonzero(np.isfinite(q).all(axis=1) & np.isfinite(qd).all(axis=1))
        rounds = 0
        while len(going) and not self.stop.is_set():
            rounds += 1
            left = end - now[going]
            wanted = np.minimum(sizes[going], self.max_step)
            h = np.where(wanted > left * (1.0 - _ROUND), left, wanted)
            at = (q[going], qd[going])
            reached, error, middle = self._tried(first + going, at, now[going], h)
            if self.events is not None:
                states = at, middle, reached
                error = np.maximum(error, self.events.unseen(first + going, states, now[going], h))
            good = error <= 1.0
            with np.errstate(divide="ignore", invalid="ignore"):
                factor = np.nan_to_num(_SAFETY * error ** (-1.0 / (self.order + 1)), nan=_SMALLEST)
            h_next = h * np.clip(factor, _SMALLEST, _LARGEST)
            # a step that the edge cut short says nothing of the next
            sizes[going] = np.where(good & (h < wanted), np.maximum(wanted, h_next), h_next)
            done, taken, reached = going[good], h[good], _of(reached, good)
            if self.events is not None:
                taken, reached = self.events.cut(
                    first + done, _of(at, good), reached, now[done], taken, self._moved
                )
            q[done], qd[done] = reached
            before = now[done]
            now[done] = np.where(taken == left[good], end, before + taken)
            lost = ~np.isfinite(qd[done]).all(axis=-1)
            now[done[lost]] = end
            too_short = (taken * MOST < self.end - now[done]) | (now[done] == before)
            slow = self.slow[lanes]
            slow[done] = np.where(too_short, slow[done] + 1, 0)
            at_rest = h_next < _SHORTEST * min(self.duration, 1.0)
            slow[going] = np.where(~good & at_rest, IN_A_ROW, slow[going])
            doubling = np.full(len(q), np.nan)
            doubling[done] = self.growth.hopeless(first + done, now[done], qd[done])
            slow[np.isfinite(doubling)] = IN_A_ROW
            stuck = going[slow[going] >= IN_A_ROW]
            for k in stuck.tolist():
                there = float(now[k]), float(now[k] + sizes[k]), qd[k].copy()
                self.given_up[first + k] = GivenUp(*there, float(doubling[k]))
            q[stuck] = qd[stuck] = np.nan
            now[stuck] = end
            if self.watch is not None and rounds % _WATCHED == 0 and len(done):
                k = done[h[good].argmin()]
                self.watch(first + int(k), float(now[k]), (q[k], qd[k]), float(h[good].min()))
            going = going[now[going] < end]
        return q, qd

    def _moved(self, lanes: Some, state: LaneState, start: Array, h: Array) -> LaneState:
        return self._tried(lanes, state, start, h)[0]

    def _tried(
        self, lanes: Some, state: LaneState, start: Array, h: Array
    ) -> tuple[LaneState, Array, LaneState]:
        """The states after a step, their error relative to what is allowed (lanes,), NaN where a
        state is not finite, and the states halfway."""
        half, step = 0.5 * h, self.stepper.step
        rough = step(lanes, state, start, h)
        middle = step(lanes, state, start, half)
        fine = step(lanes, middle, start + half, half)
        error, better = np.zeros(len(h)), []
        part = 1.0 / (2.0**self.order - 1.0)
        with np.errstate(invalid="ignore", over="ignore"):
            for old, one, two in zip(state, rough, fine, strict=True):
                off = part * (two - one)
                most = np.maximum(np.abs(old), np.abs(two))
                allowed = self.tolerance * (0.01 + most)
                error = np.maximum(error, (np.abs(off) / allowed).max(axis=1, initial=0.0))
                better.append(two + off if self.extrapolated else two)
        return (better[0], better[1]), error, middle


def _of(state: LaneState, which: NDArray[np.bool_]) -> LaneState:
    return state[0][which], state[1][which]


@dataclass(eq=False)
class CompiledSteps:
    """Equal steps of at most `step` (s; None: one from edge to edge), many in one call of compiled
    code; see `Advance`."""

    stepper: KernelStepper
    step: float | None
    stop: threading.Event
    block: int = STAYING

    def __call__(
        self, motions: LaneMotions, block: slice, first: int, last: int
    ) -> Iterator[float]:
        """Move rows from edge to edge, see `Advance`; between two rows of the result the states are
        updated in place, and to and from these rows they go without a copy."""
        times = motions.times
        begins, ends = times.begins[first:last], times.ends[first:last]
        counts = step_counts(ends - begins, self.step)
        lengths, passed = (ends - begins) / counts, np.cumsum(counts)
        state = [x[block][None] for x in motions.state]
        kept = [x[:, 0].swapaxes(0, 1) for x in motions.kept(block)]
        places, row = [*zip(state, kept, strict=True)], -1
        at_once = min(
            _MOST_AT_ONCE, max(1, self.stepper.kernel.at_once // (block.stop - block.start))
        )
        for begin in range(0, passed[-1], at_once):
            if self.stop.is_set():
                return
            steps = np.arange(begin, min(begin + at_once, passed[-1]))
            span = np.searchsorted(passed, steps, side="right")
            h = lengths[span]
            start = begins[span] + (steps - (passed - counts)[span]) * h
            rows = np.where(steps + 1 == passed[span], times.rows[first + 1 + span], -1)
            before, row = np.append(row, rows[:-1]), rows[-1]
            self.stepper.in_turn(
                block,
                [Placed(x, *here) for here in map(_place, (before, rows)) for x in places],
                start,
                h,
            )
            yield float(start[-1] + h[-1])
        if row >= 0:
            for x, every in places:
                x[0] = every[row]


def _place(rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The places of the states at the ends of steps: 1 where a step ends at a row of the result,
    else 0; and the index of that row."""
    return (rows >= 0).astype(np.intp), np.maximum(rows, 0)
