"""Steps that end at an event: a joint comes to rest, is released by friction, or meets or leaves
its stop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.motion.simulation.joint_contacts import JointContacts
from freebody.motion.simulation.one_step import LaneState, Rates
from freebody.motion.simulation.run import MotionLanes, Some

_NEAR = 1e-14  # of the duration
_TURNS = 200
_HAIR = 1e-14
"""rad, rad/s, m, m/s: how far behind a change a step may end."""
_LIES = 1e-12
"""rad, m: what comes to rest so near to its stop lies at it, lest friction has to hold it there."""
_ROUND = 1e-11
_IDLE = 500  # events in a row that bring a motion no further
_SHORTEST = 1e-13  # of the duration
_BEND = 0.2
"""Part of a bound by which the torque needed to hold a joint may bend within a step."""
_FINE = 1e-6  # of the duration: steps in which torques that jump may change as they like

LaneIndex = NDArray[np.intp]
StepMove = Callable[[Some, LaneState, Array, Array], LaneState]
"""(lanes, states, start, h) -> the states a step later."""


@dataclass(eq=False)
class ContactEvents:
    """The events of dry friction and stops in many motions: which coordinates are held, in which
    direction friction acts (lanes, nv), and when that changes.

    A step is made as if nothing changed. Where that is not so at its end, or between (a stop that
    was passed and left again), it is made again up to the time of the change, the state is put
    right there, and what holds from there on is decided anew.
    """

    contacts: JointContacts
    """Friction and stops of each lane."""
    rates: Rates
    duration: float
    senses: Array
    held: Array
    idle: NDArray[np.intp] = field(init=False)

    def __post_init__(self) -> None:
        self.idle = np.zeros(len(self.senses), dtype=int)

    @staticmethod
    def of(
        contacts: JointContacts, lanes: MotionLanes, rates: Rates, duration: float, qd: Array
    ) -> ContactEvents:
        """The events of all motions at their start, with rates qd (lanes, nv)."""
        own = contacts.lanes(lanes)
        senses = np.where(own.jumps, np.sign(qd), 0.0)
        return ContactEvents(own, rates, duration, senses, np.zeros(senses.shape))

    def begin(self, lanes: slice, state: LaneState, start: float) -> LaneState:
        """The states at a time at which torques may jump, after the events of that time."""
        each = np.arange(len(self.senses))[lanes]
        contacts = self.contacts.some(each)
        some = contacts.resting(*state) | contacts.hitting(*state)
        rows = np.flatnonzero(some.any(axis=-1) & _finite(state))
        if not len(rows):
            return state
        q, qd = (x.copy() for x in state)
        found = self._decided(each[rows], (q[rows], qd[rows]), np.full(len(rows), start))
        q[rows], qd[rows] = found
        return q, qd

    def through(
        self,
        lanes: slice,
        before: LaneState,
        after: LaneState,
        start: float,
        h: float,
        move: StepMove,
    ) -> LaneState:
        """The states a whole step after `before`, with events on the way; after: the states that
        the step without events leads to."""
        every = np.arange(len(self.senses))[lanes]
        at, left = np.full(len(every), start), np.full(len(every), h)
        taken, (q, qd) = self.cut(every, before, after, at, left, move)
        at, left = at + taken, left - taken
        while len(rows := np.flatnonzero((left > 0.0) & _finite((q, qd)))):
            begun = q[rows], qd[rows]
            ended = move(every[rows], begun, at[rows], left[rows])
            taken, reached = self.cut(every[rows], begun, ended, at[rows], left[rows], move)
            at[rows], left[rows] = at[rows] + taken, left[rows] - taken
            q[rows], qd[rows] = reached
        return q, qd

    def cut(
        self,
        lanes: LaneIndex,
        before: LaneState,
        after: LaneState,
        start: Array,
        h: Array,
        move: StepMove,
    ) -> tuple[Array, LaneState]:
        """The durations of the steps from `before` to `after` up to their first event, and the
        states there; start, h (lanes,)."""
        margins = self._margins(lanes, after, start + h)
        ends, changes = h.copy(), np.asarray((margins < 0.0).any(axis=-1))
        self._dips(lanes, before, after, start, ends, changes, move)
        rows = np.flatnonzero(changes)
        if not len(rows):
            self.idle[lanes] = 0
            return h, after
        q, qd = (x.copy() for x in after)

        own, begun, at = lanes[rows], (before[0][rows], before[1][rows]), start[rows]
        taken = ends[rows] = self._first_change(own, begun, at, ends[rows], move)
        state = self._decided(own, move(own, begun, at, taken), at + taken)
        short = taken < _SHORTEST * self.duration
        idle = np.where(short, self.idle[own] + 1, 0)
        self.idle[lanes], self.idle[own] = 0, idle
        lost = idle > _IDLE
        q[rows], qd[rows] = (np.where(lost[:, None], np.nan, x) for x in state)
        return ends, (q, qd)

    def unseen(
        self,
        lanes: LaneIndex,
        states: tuple[LaneState, LaneState, LaneState],
        start: Array,
        h: Array,
    ) -> Array:
        """An error estimate (lanes,), above 1 where steps of size h must be shorter, of events of
        held coordinates that may go unseen; states: at the start, halfway and at the end.

        What is held does not move, whatever acts on it: the errors of its state say nothing of how
        long a torque that changes with time still lets it rest.
        """
        found = np.zeros(len(lanes))
        held = (self.held[lanes] > 0.0).any(axis=-1) & (h > _FINE * self.duration)
        rows = np.flatnonzero(held)
        if not len(rows):
            return found
        own, grip = lanes[rows], self.contacts.grip[lanes[rows]]
        m0, m1, m2 = (
            self._margins(own, (q[rows], qd[rows]), start[rows] + part * h[rows])[:, -qd.shape[1] :]
            for (q, qd), part in zip(states, (0.0, 0.5, 1.0), strict=True)
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            size = np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.maximum(np.abs(m2), grip))
            bend = np.nan_to_num(np.abs(m0 - 2.0 * m1 + m2) / (_BEND * size), posinf=0.0)
        let_go = (m1 < 0.0) & (m2 >= 0.0)
        found[rows] = np.where(let_go, np.inf, bend**2.5).max(axis=-1)
        return found

    def _first_change(
        self, lanes: LaneIndex, before: LaneState, start: Array, h: Array, move: StepMove
    ) -> Array:
        """The times (lanes,), at most h, just behind the first event, by no more than `_HAIR` in
        its margin."""
        low, high = np.zeros(len(h)), h.copy()
        near = _NEAR * self.duration + 4.0 * np.spacing(np.abs(start) + h)
        left, speed = self._margins(lanes, before, start), before[1].copy()
        right = self._margins(lanes, move(lanes, before, start, h), start + h)
        side = np.zeros(len(h))
        for turn in range(_TURNS):
            k = np.flatnonzero((high - low > near) & (right.min(axis=-1) < -2.0 * _HAIR))
            if not len(k):
                break
            width = high[k] - low[k]
            part = _used_up(left[k], right[k], speed[k] * width[:, None])
            if turn % 4 == 3:
                part[:] = 0.5
            x = low[k] + part * width
            reached = move(lanes[k], (before[0][k], before[1][k]), start[k], x)
            found = self._margins(lanes[k], reached, start[k] + x)
            past = (found < 0.0).any(axis=-1)
            # an end that stays counts half (Illinois method; Dowell and Jarratt 1971)
            again = np.where(past, 1.0, -1.0) == side[k]
            left[k[past & again]] *= 0.5
            right[k[~past & again]] *= 0.5
            side[k] = np.where(past, 1.0, -1.0)
            high[k[past]], right[k[past]] = x[past], found[past]
            low[k[~past]], left[k[~past]] = x[~past], found[~past]
            speed[k[~past]] = reached[1][~past]
        return high

    def _margins(self, lanes: Some, state: LaneState, t: Array) -> Array:
        """Margins (lanes, 4 nv) of motions from events, negative after one: of sliding from rest,
        of all from their stops, of held coordinates from what can hold them."""
        (q, qd), held, senses = state, self.held[lanes] > 0.0, self.senses[lanes]
        contacts = self.contacts.some(lanes)
        x = contacts.positions(q)
        slide = np.where(~held & (senses != 0.0), senses * qd, np.inf)
        below, above = (np.where(held, np.inf, a) for a in _to_stops(contacts, x))
        hold = np.full(qd.shape, np.inf)
        if held.any():
            qdd, reaction, M, _ = self.rates(lanes, state, t, senses, self.held[lanes])
            least, most = contacts.bounds(q)
            within = np.minimum(reaction - least, most - reaction)
            # as far beyond as rounding cannot bring it, so that what is let go does begin to move
            size = np.abs(np.concatenate([np.einsum("...ij,...j->...i", M, qdd), reaction], -1))
            size = size.max(axis=-1) + contacts.grip.max(axis=-1) + np.abs(M).max(axis=(-2, -1))
            hold = np.where(held, within + _ROUND * size[..., None], np.inf)
        return np.concatenate([slide, below, above, hold], axis=-1)

    def _dips(
        self,
        lanes: LaneIndex,
        before: LaneState,
        after: LaneState,
        start: Array,
        ends: Array,
        changes: NDArray[np.bool_],
        move: StepMove,
    ) -> None:
        """Events within a step that its ends do not show: stops passed and left again, and sliding
        that reversed. `changes` are those events, `ends` the farthest points, taken from the cubic
        through both ends."""
        h, seen = ends.copy(), changes.copy()
        for part in self._suspected(lanes, before, after, h):
            reach = np.where(seen, np.inf, part * h)
            rows = np.flatnonzero(reach < ends)
            if not len(rows):
                continue
            own, there = (before[0][rows], before[1][rows]), reach[rows]
            state = move(lanes[rows], own, start[rows], there)
            margins = self._margins(lanes[rows], state, start[rows] + there)
            past = (margins < 0.0).any(axis=-1)
            ends[rows[past]] = there[past]
            changes[rows[past]] = True

    def _suspected(
        self, lanes: LaneIndex, before: LaneState, after: LaneState, h: Array
    ) -> Iterator[Array]:
        """The fractions of a step (lanes,) at which the cubic through its ends has a coordinate
        farthest beyond its lower stop, beyond its upper one, or slowest after reversing; infinite
        where none is."""
        contacts, free = self.contacts.some(lanes), self.held[lanes] == 0.0
        (x0, v0), (x1, v1) = ((contacts.positions(q), qd) for q, qd in (before, after))
        d0, d1 = h[:, None] * v0, h[:, None] * v1
        pairs = zip(_to_stops(contacts, x0), _to_stops(contacts, x1), (1.0, -1.0), strict=True)
        for m0, m1, side in pairs:
            turning = free & np.isfinite(m0) & (side * v0 < 0) & (side * v1 > 0)
            if turning.any():
                yield _earliest(turning, *_lowest(m0, m1, side * d0, side * d1))
        side = self.senses[lanes]
        sliding = free & (side * v0 > 0) & (side * v1 > 0)
        if sliding.any():
            yield _earliest(sliding, *_slowest(side * (x1 - x0), side * d0, side * d1))

    def _decided(self, lanes: LaneIndex, state: LaneState, t: Array) -> LaneState:
        """The states corrected at an event, after deciding anew which coordinates are held and in
        which direction friction acts."""
        (q, qd), contacts = (x.copy() for x in state), self.contacts.some(lanes)
        stopped = (self.held[lanes] == 0.0) & (self.senses[lanes] * qd < 0.0)
        qd[stopped] = 0.0
        off = np.where(qd == 0.0, _LIES, 0.0)
        to_stops = _to_stops(contacts, contacts.positions(q))
        for stop, left in zip((contacts.lower, contacts.upper), to_stops, strict=True):
            row, k = np.nonzero(left < off)
            q[row, contacts.place[k]] = stop[row, k]
        senses, held = self.senses[lanes], self.held[lanes]
        qdd, reaction, M, drag = self.rates(lanes, (q, qd), t, senses, held)
        hits = np.flatnonzero(contacts.hitting(q, qd).any(axis=-1))
        if len(hits):
            some = contacts.some(hits)
            qd[hits] = some.rebound(q[hits], qd[hits], M[hits])
            qdd, reaction, M, drag = self.rates(lanes, (q, qd), t, senses, held)
        forces = np.einsum("...ij,...j->...i", M, qdd) - reaction + drag * senses
        found = contacts.contact(q, qd, M, forces, drag)
        begins = np.sign(np.where(qd == 0.0, found.qdd, qd))
        self.senses[lanes] = np.where(contacts.jumps & ~found.held, begins, 0.0)
        self.held[lanes] = found.held
        return q, qd


def _used_up(left: Array, right: Array, speed: Array) -> Array:
    """The fraction of an interval (n,) at which the first margin (n, 4 nv) is just used up: by
    straight lines, and for stops by parabolas that begin with the speed (n, nv)."""
    a, b, nv = left + _HAIR, right + _HAIR, speed.shape[-1]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        part = np.where(b < 0.0, a / (a - b), np.inf)
        stops = slice(nv, 3 * nv)
        a, b, slope = a[:, stops], b[:, stops], np.concatenate([speed, -speed], axis=-1)
        bend = b - a - slope
        root = np.sqrt(np.maximum(slope * slope - 4.0 * bend * a, 0.0))
        curved = np.where(slope > 0.0, (slope + root) / (-2.0 * bend), 2.0 * a / (root - slope))
        part[:, stops] = np.where((b < 0.0) & np.isfinite(curved), curved, part[:, stops])
        part = part.min(axis=-1)
    return np.where((part > 0.0) & (part < 1.0), part, 0.1)


def _to_stops(contacts: JointContacts, x: Array) -> tuple[Array, Array]:
    """The distances of positions from the lower and from the upper stop."""
    return x - contacts.lower, contacts.upper - x


def _lowest(m0: Array, m1: Array, d0: Array, d1: Array) -> tuple[Array, Array]:
    """The place, between 0 and 1, of the minimum of the cubic with given end values and slopes, d0
    < 0 < d1, and its value there."""
    with np.errstate(invalid="ignore", divide="ignore"):
        a, b = _cubic(m1 - m0, d0, d1)
        root = np.sqrt(np.maximum(b * b - 3.0 * a * d0, 0.0))
        s = np.clip(-d0 / (b + root), 0.0, 1.0)
        return s, ((a * s + b) * s + d0) * s + m0


def _slowest(way: Array, d0: Array, d1: Array) -> tuple[Array, Array]:
    """The place of the smallest slope of the cubic that covers a distance `way` with given end
    slopes, and that slope."""
    a, b = _cubic(way, d0, d1)
    with np.errstate(invalid="ignore", divide="ignore"):
        s = np.where(a > 0.0, -b / (3.0 * a), np.nan)
        return s, np.where((s > 0.0) & (s < 1.0), b * s + d0, np.nan)


def _cubic(way: Array, d0: Array, d1: Array) -> tuple[Array, Array]:
    """The coefficients of s³ and s² of the cubic that is 0 at 0 and `way` at 1, with slopes d0 and
    d1 there."""
    return d0 + d1 - 2.0 * way, 3.0 * way - 2.0 * d0 - d1


def _earliest(which: NDArray[np.bool_], part: Array, value: Array) -> Array:
    """The smallest fraction (n,) among the marked entries whose value is negative."""
    with np.errstate(invalid="ignore"):
        return np.where(which & (value < 0.0), part, np.inf).min(axis=-1)


def _finite(state: LaneState) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(np.concatenate(state, axis=-1)).all(axis=-1))
