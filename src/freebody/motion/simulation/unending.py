"""Runs that would never end or end too late: so many steps that they would take years, or rates
that grow without bound; how they are found and explained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.motion.ranges import angular
from freebody.motion.simulation.first_order_system import System, TorqueLaw
from freebody.motion.simulation.results import SimulationStopped
from freebody.motion.simulation.run import Simulation, drive_of, some_of
from freebody.motion.simulation.stiffness import lane_system

MOST = 1e8
"""Steps that Python makes one by one: more would take many hours, or days."""
IN_A_ROW = 2000
"""Steps that are all too short, before a run is called endless."""
_FAST = 1e3
"""rad/s, m/s: slower rates that grow are no reason to stop."""
_HOPELESS = 1e12  # rad/s, m/s: that growth leads to before the end
_GROWS = 1.2  # times from one instant to the next, twice in a row
_LOOKED_BACK = 3
_STEADY = 1.2  # how much longer one doubling may take than the one before
_COARSE = 1e-9  # of the duration: times farther apart than this leave steps no room
_MARGIN = 1e-3  # growth a sample of a loop that counts as stable
_FINER, _OCTAVES = 2.0**0.25, 40
_RESOLVED = 1e-3  # rad, m: a step that the motion itself asks for
_SHIFT = 1e-6  # of differences of the torque, relative to 1 + |y|


@dataclass(eq=False)
class RunPace:
    """A count of steps in a row that are too short ever to reach a run's end."""

    end: float
    slow: int = 0

    def endless(self, before: float, now: float) -> bool:
        """Whether, after one more step, too many steps in a row have been too short."""
        self.slow = self.slow + 1 if (now - before) * MOST < self.end - now else 0
        return self.slow >= IN_A_ROW


class Growth:
    """How long motions take to double their rates, watched while they are fast."""

    def __init__(self, lanes: int, end: float):
        self.end = end
        self.size = np.full(lanes, _FAST / 16.0)
        self.times = np.full((lanes, 4), np.nan)

    def hopeless(self, lanes: NDArray[np.intp], now: Array, qd: Array) -> Array:
        """The time (s) in which each of some motions (k,) last doubled its rates, if it grows
        without bound, NaN for others; qd (k, n): the rates at times now (k,).

        Rates that grow with a power of time take ever longer; of those that do not, the rest of the
        run is so many more doublings.
        """
        found = np.full(len(lanes), np.nan)
        speed = np.abs(qd).max(axis=-1, initial=0.0)
        twice = np.flatnonzero(speed > 2.0 * self.size[lanes])
        if not len(twice):
            return found
        rows, at = lanes[twice], now[twice]
        self.size[rows] = speed[twice]
        self.times[rows] = np.concatenate([self.times[rows, 1:], at[:, None]], axis=1)
        gaps = np.diff(self.times[rows], axis=1)
        with np.errstate(all="ignore"):
            steady = (gaps[:, 1:] <= _STEADY * gaps[:, :-1]).all(axis=1)
            ahead = np.log2(speed[twice]) + (self.end - at) / gaps[:, -1]
            lost = steady & (speed[twice] > _FAST) & (ahead > np.log2(_HOPELESS))
        found[twice[lost]] = gaps[lost, -1]
        return found


@dataclass(eq=False)
class SampledGrowth:
    """How the rates of motions grow from one controller call to the next."""

    calls: int
    sizes: list[Array] = field(default_factory=list)

    def hopeless(self, qd: Array) -> NDArray[np.bool_]:
        """Flags (lanes,) of the motions whose rates qd (lanes, nv), after one more call, grow so
        that no step can reach the end."""
        with np.errstate(all="ignore"):
            self.sizes.append(np.abs(qd).max(axis=-1, initial=0.0))
            if len(self.sizes) < _LOOKED_BACK:
                return np.zeros(len(qd), dtype=bool)
            last = np.stack(self.sizes[-_LOOKED_BACK:])
            growth = (last[1:] / last[:-1]).min(axis=0)
            left = self.calls - len(self.sizes)
            ahead = np.log(last[-1]) + left * np.log(growth)
            return (last[-1] > _FAST) & (growth > _GROWS) & (ahead > np.log(_HOPELESS))


class GivenUp(NamedTuple):
    """The last step of a motion that was given up: its times, the rates (nv,) after it, and, where
    rates grow without bound, the time they took to double (s)."""

    before: float
    now: float
    qd: Array
    doubling: float = np.nan


def endless(run: Simulation, last: GivenUp, lane: int = 0) -> str:
    """The reason for giving up a motion, in sentences."""
    step = last.now - last.before
    if not step:
        return too_late(run.t)
    if np.isfinite(last.doubling):
        fast = _moving(run, last.qd)
        why = why_sampled(run, lane) or "Check the torque, its sign and units."
        return (
            f"At t = {last.now:.6g} s {fast}, twice as fast every {last.doubling:.1g} s: the "
            f"motion diverges. {why}"
        )
    left = (run.t[-1] - last.now) / step
    return (
        f"At t = {last.now:.6g} s steps are {step:.1g} s long, {left:.1g} more to the end: this "
        f"run would not end. {_why_short(run, last.qd, step, lane)}"
    )


def too_late(t: Array) -> str:
    """A sentence on times so large that steps are lost in their rounding; "" for others."""
    apart = float(np.spacing(np.abs(t).max()))
    if apart <= _COARSE * (t[-1] - t[0]):
        return ""
    return f"At t = {t[0]:g} s numbers are {apart:.1g} s apart: let the times begin at 0."


def hopeless(run: Simulation, now: float, qd: Array) -> str:
    """The reason for giving up a motion whose rates qd (nv,) grow from one controller call to the
    next."""
    why = why_sampled(run) or "The loop that the torque closes is unstable."
    return (
        f"simulate: the motion grows from one call of the torque to the next: at t = {now:.6g} s "
        f"{_moving(run, qd)}, and no step would lead on to the end. {why}"
    )


def _why_short(run: Simulation, qd: Array, step: float, lane: int) -> str:
    """The reason for the short steps of one motion, or for their number, in sentences."""
    reason = why_sampled(run, lane) or too_late(run.t)
    if reason:
        return reason
    speed = float(np.abs(qd).max(initial=0.0))
    if speed > _FAST:
        return f"{_moving(run, qd)}: the motion diverges. Check the torque, its sign and units."
    if speed * step > _RESOLVED:
        return f"The times reach to {run.t[-1]:g} s: shorten them."
    if callable(run.torque) or callable(run.forces):
        return (
            "The motion itself asks for no such steps: a function that jumps, or that returns "
            "something else at each call, does. breakpoints= says where it jumps, sample_time= "
            "that it is called now and then, friction='dry' is friction that sticks."
        )
    return "The motion may pass a state without finite acceleration, or be stiff."


def _moving(run: Simulation, qd: Array) -> str:
    """A phrase on the fastest coordinate and its rate."""
    k = int(np.argmax(np.abs(qd)))
    own = k % run.model.nv  # qd may be those of motions that step alike
    unit = "rad/s" if angular(run.model)[own] else "m/s"
    return f"{run.model.velocity_names[own]!r} moves at {abs(qd[k]):.3g} {unit}"


def why_sampled(run: Simulation, lane: int = 0) -> str:
    """Sentences on a motion that grows because its torque is sampled too rarely, with the longest
    sampling time at which it would not; "" where it does not grow, or where that cannot be
    found."""
    if run.sample_time is None or run.model.loops or run.model.nq != run.model.nv:
        return ""
    try:
        with np.errstate(all="ignore"):
            loop = _SampledLoop.at_start(run, lane)
            size, motion = loop.largest(run.sample_time)
            if loop.stable(run.sample_time) or not np.isfinite(size):
                return ""
            name = run.model.velocity_names[int(np.argmax(np.abs(motion[run.model.nq :])))]
            longest = loop.longest(run.sample_time)
    except (FreebodyError, ArithmeticError, ValueError, np.linalg.LinAlgError):
        return ""
    known = (
        f"it is stable up to about sample_time = {longest:.1g} s"
        if longest
        else "it is not stable at any shorter sample_time either"
    )
    return (
        f"The torque is sampled too seldom: held for sample_time = {run.sample_time:g} s, it "
        f"makes the motion of {name!r} grow {size:.3g} times from one instant to the next; "
        f"linearised at the start, {known}. Sample it more often, lower its gains, or give it "
        f"without sample_time=."
    )


@dataclass(frozen=True, eq=False)
class _SampledLoop:
    """A linear closed loop with sampled feedback: ẏ = A y + B u, u = K y, with u held between
    instants."""

    A: Array
    B: Array
    K: Array

    @staticmethod
    def at_start(run: Simulation, lane: int) -> _SampledLoop:
        """The sampled loop of one motion, linearised at its start."""
        model, lanes = run.model, run.lanes
        whole, now = lane_system(run, lane), np.asarray(run.t[0])
        index, shape = lanes.index(lane), lanes.shape
        states = [np.array(np.broadcast_to(x, (*shape, x.shape[-1]))) for x in (run.q, run.qd)]
        every = np.concatenate(states, axis=-1)
        given = run.torque
        assert callable(given)
        drive = drive_of(model, run.t, given, shape)

        def torque(y: Array) -> Array:
            moved = every.copy()
            moved[index] = y
            found = drive(now, *whole.split(moved))
            return some_of(lanes.each(np.asarray(found), 1), 1, lane) if shape else found

        y = every[index]
        h = _SHIFT * (1.0 + np.abs(y))
        columns = [(torque(y + d) - torque(y - d)) / (2.0 * d.max()) for d in np.diag(h)]
        tau = torque(y)
        still = whole.rate(now, y, tau)
        pushed = whole.rate(now, np.tile(y, (model.nv, 1)), tau + np.eye(model.nv))
        return _SampledLoop(
            whole.jacobian(now, y, tau), (pushed - still).T, np.stack(columns, axis=-1)
        )

    def largest(self, sample_time: float) -> tuple[float, Array]:
        """The largest factor by which the loop grows between instants, and the growing combination
        of states."""
        n, m = self.B.shape
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:] = self.A, self.B
        moved = expm(sample_time * whole)
        factors, motions = np.linalg.eig(moved[:n, :n] + moved[:n, n:] @ self.K)
        k = int(np.argmax(np.abs(factors)))
        return float(np.abs(factors[k])), np.abs(motions[:, k])

    def stable(self, sample_time: float) -> bool:
        """Whether the sampled loop grows no faster than it would with continuous feedback."""
        rate = float(np.linalg.eigvals(self.A + self.B @ self.K).real.max())
        most = (1.0 + _MARGIN) * np.exp(max(0.0, rate) * sample_time)
        return self.largest(sample_time)[0] <= most

    def longest(self, sample_time: float) -> float | None:
        """The longest stable sampling time (s) below an unstable one; None where there is none."""
        shorter = sample_time / _FINER ** np.arange(1, round(_OCTAVES * np.log(2) / np.log(_FINER)))
        return next((float(x) for x in shorter if self.stable(float(x))), None)


def stopping_endless(run: Simulation, whole: System) -> Callable[[float, float, Array], None]:
    """A function of a step's two times and the state after it that raises an error where the run
    would never end."""
    end = float(run.t[-1])
    pace, growth, only = RunPace(end), Growth(1, end), np.zeros(1, dtype=int)

    def passed(before: float, now: float, y: Array) -> None:
        qd = whole.split(y)[1]
        doubling = float(growth.hopeless(only, np.array([now]), qd[None])[0])
        if pace.endless(before, now) or np.isfinite(doubling):
            reason = endless(run, GivenUp(before, now, qd, doubling))
            raise SimulationStopped(f"simulate: {reason}")

    return passed


def unless_hopeless(
    run: Simulation, edges: Array, begin: Callable[[int, Array, Array], TorqueLaw]
) -> Callable[[int, Array, Array], TorqueLaw]:
    """The function `begin` of a schedule with edges (k,) that also raises an error where the motion
    grows without bound between the controller's calls."""
    growth = SampledGrowth(len(edges) - 1)

    def begin_or_stop(k: int, q: Array, qd: Array) -> TorqueLaw:
        if growth.hopeless(qd[None])[0]:
            raise SimulationStopped(hopeless(run, float(edges[k]), qd))
        return begin(k, q, qd)

    return begin_or_stop
