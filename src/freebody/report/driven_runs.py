"""Simulations of a model driven by the torques of a motion, in pieces or open loop.

First they are tried in steps that are known beforehand: the stretches on which the motion is
smooth, or equal parts of them. So the torques of all stages come in one batch, and a step costs no
more than its thirteen accelerations. The method is that of scipy's DOP853 (Hairer, Nørsett and
Wanner 1993), whose own estimate tells whether the steps are short enough. Where they are not, one
of scipy's integrators takes its own steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp
from scipy.sparse import block_diag

from freebody.arrays import Array
from freebody.motion.motion import Motion
from freebody.motion.ranges import Ranges
from freebody.motion.simulation.first_order_system import System
from freebody.trees.positions import difference

TOLERANCE = {"DOP853": 1e-12, "BDF": 1e-11, "Radau": 1e-8}
"""Relative error per step of the integrators, absolute a hundredth of it; what is stiff also damps
its errors."""
ASTRAY = "astray"
"""Why a run ended in which a joint left the motion by its whole range."""

_EVALUATIONS = 30_000
"""Evaluations of the open-loop run, which might otherwise follow a tumbling robot for minutes."""
_MOST_EVALUATIONS = 150_000
"""Evaluations of all pieces together."""
_SAME = 1e-9
"""Share of a piece, or of the motion: times as near as that are one."""
_BESIDE = 1e-6
"""Share of a step, or of a stretch between jumps: there a jump at its beginning is over, and one at
its end is not yet."""

_PARTS = (1, 3, 9)
"""Numbers of steps into which a stretch is divided, tried one after the other where the method asks
for more."""
_STEP_ERROR = 1e-12
"""Error of a step, relative to 1 + the state."""
_MOST_IN_STEPS = 300_000
"""Evaluations, of all lanes together."""
_AT_ONCE = 4096
"""Steps whose torques are computed together."""
_NODES = np.append(DOP853.C, 1.0)
_WEIGHTS = [*(row[:k] for k, row in enumerate(DOP853.A)), DOP853.B]
"""Weights of the slopes before each stage; the last leads to the end of the step."""

_kept = lru_cache(maxsize=1)
"""Keeps a function's last value: implicit methods ask for several slopes at one time."""

_AccelerationLaw = Callable[[float, Array], Any]


def land(
    whole: System, motion: Motion, start: Array, end: Array, allowed: Ranges, method: str
) -> Array:
    """The distance (pieces,) from the reference at each piece's end, relative to the joint range;
    all pieces run side by side; infinite for a run that was broken off."""
    reference = MotionReference(whole, motion)
    for parts in _PARTS if method == "DOP853" else ():
        try:
            *_, y = _steps(reference, _edges(motion, start, end, parts))
        except _TooLong:
            continue
        return _missed(whole, motion, end, y, allowed)
    length = end - start
    count, n = len(length), whole.size
    cuts = _cuts(motion.jumps, start, length)
    inside = 0.0, 1.0  # of the stretch between cuts

    @_kept
    def torque(s: float, low: float, high: float) -> Array:
        return reference.torque(start + s * length, start + np.clip(s, low, high) * length)

    def torque_at(s: float) -> Array:
        return torque(s, *inside)

    def rate(s: float, y: Array) -> Array:
        t = start + s * length
        states = y.reshape(count, n)
        return (whole.rate(t, states, torque_at(s)) * length[:, None]).ravel()

    def slope(s: float, y: Array) -> Any:
        t = start + s * length
        A = whole.jacobian(t, y.reshape(count, n), torque_at(s)) * length[:, None, None]
        return block_diag(A, format="csc") if count > 1 else A[0]

    y, counted = reference.state(start).ravel(), _limited(rate, _MOST_EVALUATIONS)
    for stretch in pairwise(cuts):
        inside = _inside(*stretch)
        try:
            found = _run(counted, slope, stretch, y, method, among_jumps=len(cuts) > 2)
        except _Spent:
            return np.full(count, np.inf)
        if not found.success:
            return np.full(count, np.inf)
        y = found.y[:, -1]
    return _missed(whole, motion, end, whole.normalised(y.reshape(count, n)), allowed)


def _missed(whole: System, motion: Motion, end: Array, y: Array, allowed: Ranges) -> Array:
    """The distance (pieces,) of states (pieces, n) from the motion at times (pieces,), relative to
    the joint range."""
    off = difference(whole.model, motion.at(end)[0], whole.split(y)[0])
    return np.abs(off / allowed.width).max(axis=-1)


def open_loop(
    whole: System, motion: Motion, allowed: Ranges, method: str
) -> tuple[Array, Array, str]:
    """(times, distance from the reference (k, nv), the reason why it ended early) of one open-loop
    run over the whole motion.

    It ends where a joint has gone astray by its whole range, or when its evaluations are spent.
    """
    reference, model = MotionReference(whole, motion), whole.model
    for parts in _PARTS if method == "DOP853" else ():
        try:
            return _in_steps(reference, allowed, parts)
        except _TooLong:
            continue
    inside = 0.0, 0.0  # of the stretch that is run

    @_kept
    def torque(t: float, low: float, high: float) -> Array:
        return reference.torque(np.asarray(t), np.asarray(np.clip(t, low, high)))

    def torque_at(t: float) -> Array:
        return torque(t, *inside)

    def rate(t: float, y: Array) -> Array:
        return whole.rate(np.asarray(t), y, torque_at(t))

    def slope(t: float, y: Array) -> Array:
        return whole.jacobian(np.asarray(t), y, torque_at(t))

    def astray(t: float, y: Array) -> float:
        q = whole.split(whole.normalised(y))[0]
        off = difference(model, motion.at(t)[0], q)
        return 1.0 - float(np.abs(off / allowed.width).max())

    astray.terminal = True
    counted, ended = _limited(rate, _EVALUATIONS), ""
    times, states = [motion.t[0]], [reference.state(motion.t[0])]
    for start, end in pairwise(_stretches(motion)):
        inside = _inside(start, end)
        seen = motion.t[(motion.t > start) & (motion.t < end)]
        wanted = {"t_eval": np.append(seen, end), "events": astray}
        jumps = len(motion.jumps) > 0
        try:
            found = _run(counted, slope, (start, end), states[-1], method, jumps, **wanted)
        except _Spent:
            ended = "it needs too many steps"
            break
        times += list(found.t)
        states += list(np.asarray(found.y).T)  # a list where not one of the times was reached
        if found.status != 0:
            ended = ASTRAY if found.status == 1 else "the integrator found no further step"
            break
    t = np.array(times)
    q = whole.split(whole.normalised(np.stack(states)))[0]
    return t, np.abs(difference(model, motion.at(t)[0], q)), ended


def _in_steps(reference: MotionReference, allowed: Ranges, parts: int) -> tuple[Array, Array, str]:
    """The results of `open_loop` by equal steps, `parts` in each smooth stretch of the motion.
    Raises _TooLong."""
    motion, whole = reference.motion, reference.system
    times = _edges(motion, motion.t[:1], motion.t[-1:], parts)
    at, due = motion.at(times[:, 0])[0], np.isin(times[:, 0], motion.t)
    found, ended = [np.zeros(whole.model.nv)], ""
    for k, y in enumerate(_steps(reference, times), start=1):
        off = np.abs(difference(whole.model, at[k], whole.split(y)[0][0]))
        if (off > allowed.width).any():
            ended = ASTRAY
            break
        if due[k]:
            found.append(off)
    return times[due, 0][: len(found)], np.stack(found), ended


def _run(
    rate: _AccelerationLaw, slope: _AccelerationLaw, stretch: tuple[float, float], y: Array,
    method: str,
    among_jumps: bool, **more: Any,
) -> Any:  # fmt: skip
    """The solution over a stretch by one of the integrators of `TOLERANCE`; between jumps that are
    close a single step is tried first."""
    if method != "DOP853":
        more["jac"] = slope
    if among_jumps:
        more["first_step"] = stretch[1] - stretch[0]
    small = TOLERANCE[method]
    return solve_ivp(rate, stretch, y, method=method, rtol=small, atol=small / 100, **more)


def _cuts(jumps: Array, start: Array, length: Array) -> list[float]:
    """Fractions of the pieces, from 0 to 1, at which the accelerations of one of them jump, so that
    no integrator steps across."""
    inside = (jumps[:, None] - start) / length
    cuts = np.unique(inside[(inside > _SAME) & (inside < 1.0 - _SAME)])
    apart = np.diff(cuts, prepend=0.0) > _SAME
    return [0.0, *cuts[apart].tolist(), 1.0]


def _inside(start: float, end: float) -> tuple[float, float]:
    """Two times just inside the ends of a stretch, where a jump at an end has no effect."""
    return start + _BESIDE * (end - start), end - _BESIDE * (end - start)


class _Spent(Exception):
    """Raised when a run has used up its evaluations."""


def _limited(rate: Callable[[float, Array], Array], most: int) -> Callable[[float, Array], Array]:
    """The function `rate`, made to raise `_Spent` after `most` calls."""
    calls = 0

    def counted(t: float, y: Array) -> Array:
        nonlocal calls
        calls += 1
        if calls > most:
            raise _Spent
        return rate(t, y)

    return counted


def _stretches(motion: Motion) -> Array:
    """Times that divide the open-loop run: accelerations jump there, or the states reached are kept
    in case the evaluations run out."""
    edges = np.unique(np.concatenate([motion.t[::20], motion.t[-1:], motion.jumps]))
    return edges[np.append(np.diff(edges) > _SAME * motion.duration, True)]


class _TooLong(Exception):
    """Raised where steps are too long for the method, or too many."""


@dataclass(frozen=True)
class MotionReference:
    """A motion with the torque that it needs at any time, and the system under that torque."""

    system: System
    motion: Motion

    def torque(self, t: Array, around: Array | None = None) -> Array:
        """The torque at times t; around: times on the side of a jump that is meant."""
        return self.system.torque(t, *self.motion.at(t, around))

    def state(self, t: Array) -> Array:
        """The state (q, q̇) of the motion at times t."""
        q, qd, _ = self.motion.at(t)
        return np.concatenate([q, qd], axis=-1)


def _edges(motion: Motion, start: Array, end: Array, parts: int) -> Array:
    """Times (k + 1, lanes) from each start (lanes,) to its end, with the motion smooth in between
    and each smooth stretch divided equally; lanes with fewer steps repeat their end."""
    pieces = motion.t if motion.pieces is None else motion.pieces.breaks
    every = np.unique(np.concatenate([motion.t, pieces, motion.jumps]))
    near = _SAME * motion.duration

    def lane(begin: float, last: float) -> Array:
        inside = every[(every > begin + near) & (every < last - near)]
        apart = inside[np.diff(inside, prepend=begin) > near]
        whole = np.concatenate([[begin], apart, [last]])
        within = np.arange(parts * (len(whole) - 1) + 1) / parts
        return np.interp(within, np.arange(len(whole)), whole)

    lanes = [lane(*ends) for ends in zip(start.tolist(), end.tolist(), strict=True)]
    count = max(map(len, lanes))
    return np.stack([np.pad(x, (0, count - len(x)), mode="edge") for x in lanes], axis=-1)


def _steps(reference: MotionReference, times: Array) -> Iterator[Array]:
    """The states (lanes, n) at the times (k + 1, lanes) after the first, where they are on the
    motion, one after the other. Raises _TooLong."""
    system, y = reference.system, reference.state(times[0])
    if times.size * len(_NODES) > _MOST_IN_STEPS:
        raise _TooLong
    at_once = max(1, _AT_ONCE // times.shape[1])
    for first in range(0, len(times) - 1, at_once):
        some = times[first : first + at_once + 1]
        begin, h = some[:-1, None], np.diff(some, axis=0)[:, None]
        at = begin + h * _NODES[:, None]
        tau = reference.torque(at, begin + h * np.clip(_NODES, _BESIDE, 1.0 - _BESIDE)[:, None])
        for now, torque, length in zip(at, tau, h[:, 0, :, None], strict=True):
            y = _step(system, now, torque, length, y)
            yield y


def _step(system: System, t: Array, tau: Array, h: Array, y: Array) -> Array:
    """The states (lanes, n) one step h (lanes, 1) later; t (13, lanes) and tau (13, lanes, nv)
    belong to the stages, the last to the end."""
    slopes = np.empty((len(_NODES), *y.shape))
    now = y
    for k, weights in enumerate(_WEIGHTS):
        if k:
            now = y + h * (weights @ slopes[:k].reshape(k, -1)).reshape(y.shape)
        slopes[k] = system.rate(t[k], now, tau[k])
    fifth, third = (
        (weights @ slopes.reshape(len(slopes), -1)).reshape(y.shape) / (1.0 + np.abs(y))
        for weights in (DOP853.E5, DOP853.E3)
    )
    size = np.linalg.norm(fifth, axis=-1) ** 2
    whole = size + 0.01 * np.linalg.norm(third, axis=-1) ** 2
    error = np.abs(h[:, 0]) * size / np.sqrt(np.where(whole > 0.0, whole, 1.0) * y.shape[-1])
    if not (error <= _STEP_ERROR).all():  # what is no number, too
        raise _TooLong
    return system.normalised(now)
