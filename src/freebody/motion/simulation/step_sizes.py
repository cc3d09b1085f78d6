"""From one time to the next in steps: of a given size, or of sizes that each motion chooses for
itself so that its error stays small."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.motion.simulation.contact_events import ContactEvents
from freebody.motion.simulation.course import Track
from freebody.motion.simulation.motion_lanes import Some
from freebody.motion.simulation.steppers import State, Stepper
from freebody.motion.simulation.unending import IN_A_ROW, MOST, GivenUp, Growth

_ROUND = 1e-9  # of a step: what is left of an interval that rounding left
_SHORTEST = 1e-13  # of the duration, or of 1 s: steps this short lead nowhere
_WATCHED = 50  # steps between two looks at the shortest
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 4.0  # of a step: how much the next may differ


class Advance(Protocol):
    """Moves rows on. block: how many had best be moved side by side."""

    block: int

    def __call__(self, track: Track, block: slice, first: int, last: int) -> Iterator[float]:
        """From one edge to another: the states there, and those of the result on the way; NaN where
        a motion cannot go on. Stops at times between them."""
        ...


@dataclass(eq=False)
class SpanBySpan:
    """By Python from edge to edge. through: of rows, their states, and two times -> the states at
    the second one."""

    through: Callable[[slice, State, float, float], State]
    stop: threading.Event
    block: int = 8192
    """So that a step lasts long: threads wait for each other between two steps, for Python."""

    def __call__(self, track: Track, block: slice, first: int, last: int) -> Iterator[float]:
        """See `Advance`."""
        way, (q, qd) = track.course, track.state
        state = q[block], qd[block]
        for k in range(first, last):
            state = self.through(block, state, float(way.begins[k]), float(way.ends[k]))
            if self.stop.is_set():
                return
            track.record(block, k + 1, state)
            yield float(way.edges[k + 1])
        q[block], qd[block] = state


def step_counts(lengths: Array, step: float | None) -> NDArray[np.intp]:
    """How many equal steps of at most `step` (s; None: one) intervals take."""
    if step is None:
        return np.ones(lengths.shape, dtype=np.intp)
    return np.maximum(1, np.ceil(lengths / step - _ROUND).astype(np.intp))


@dataclass(eq=False)
class FixedSteps:
    """Equal steps of at most `step` (s; None: one), between which Python has to do."""

    stepper: Stepper
    step: float | None
    stop: threading.Event
    events: ContactEvents | None = None

    def __call__(self, lanes: slice, state: State, start: float, end: float) -> State:
        """See `SpanBySpan`."""
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


@dataclass(eq=False)
class ControlledSteps:
    """Each step is made twice, whole and in halves, whose difference tells the error (Hairer,
    Norsett and Wanner 1993, II.4); each lane has its own steps.

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
    watch: Callable[[int, float, State, float], None] | None = None
    """Told now and then of a lane, a time, its state there, and the step it took."""
    order: int = 4
    given_up: dict[int, GivenUp] = field(default_factory=dict)
    """By lane where it was when there was no end to be seen."""
    growth: Growth = field(init=False)
    slow: NDArray[np.intp] = field(init=False)
    """Of each lane, how many steps in a row were too short for the end to be reached."""

    def __post_init__(self) -> None:
        self.slow = np.zeros(len(self.sizes), dtype=int)
        self.growth = Growth(len(self.sizes), self.end)

    def __call__(self, lanes: slice, state: State, start: float, end: float) -> State:
        """See `SpanBySpan`."""
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
                factor = np.nan_to_num(_SAFETY * error ** (-1.0 / (self.order + 1)), nan=_LEAST)
            h_next = h * np.clip(factor, _LEAST, _MOST)
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

    def _moved(self, lanes: Some, state: State, start: Array, h: Array) -> State:
        return self._tried(lanes, state, start, h)[0]

    def _tried(
        self, lanes: Some, state: State, start: Array, h: Array
    ) -> tuple[State, Array, State]:
        """The states after a step, their error over what is allowed (lanes,), NaN where one is not
        finite, and the states halfway."""
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


def _of(state: State, which: NDArray[np.bool_]) -> State:
    return state[0][which], state[1][which]
