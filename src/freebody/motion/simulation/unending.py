"""Runs whose end is far or never comes: steps that friction or stiffness keeps short, so many steps
that they would take years, and rates that grow without hope; each found, and explained in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, warn
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.friction import smooth_friction
from freebody.motion.ranges import angular
from freebody.motion.simulation.arguments import Simulation
from freebody.motion.simulation.first_order_system import System, TorqueLaw, loads_over, system
from freebody.motion.simulation.lanes import some_of
from freebody.motion.simulation.one_step import Driving, LaneState
from freebody.motion.simulation.torques import CompiledTorque, drive_of, one_lane

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
_SHORT = 5e-4
"""Length of a step, as a part of the duration, below which it is looked at."""
_STABLE = 1.5
"""Step times decay rate from which stability, not accuracy, tells the step (5 is the most)."""
_BENT = 0.03
"""Step times decay rate from which the bends of smooth friction keep a step short, if it makes the
rate twice as fast."""
_SEEN, _LOOKS = 10, 500


@dataclass(eq=False)
class ShortSteps:
    """Looks now and then at the motion that makes the shortest step of a block."""

    run: Simulation
    driving: Driving
    text: str = ""
    """The sentence on what was found."""
    warned: bool = False
    looks: int = 0
    seen: int = 0

    def look(self, lane: int, t: float, state: LaneState, step: float) -> None:
        """Look at a motion at time t, q (nq,) and qd (nv,), after a step (s)."""
        if self.text or step > _SHORT * self.run.duration or self.looks >= _LOOKS:
            return
        self.looks += 1
        run, y = self.run, np.concatenate(state)
        torque = lane_drive(run, lane, self.driving)
        decay = lane_system(run, lane).fastest_decay(np.asarray(t), y, torque)
        smooth, friction = smooth_friction(run.model)
        rubs = friction.acts and decay * step > _BENT
        if rubs:
            without = lane_system(run, lane, smooth).fastest_decay(np.asarray(t), y, torque)
            rubs = decay > 2.0 * without
        self.seen += rubs or decay * step > _STABLE
        if self.seen < _SEEN:
            return
        here = f"{step:.1g} s at t = {t:.3g} s{at_sample(run.lanes.index(lane))}"
        self.text = (
            f"simulate: smooth dry friction keeps the steps of motions short, {here}: it changes "
            f"within friction_width = {run.width:g}. A larger tolerance= or friction_width=, or "
            f"method='implicit' with step=, takes fewer."
            if rubs
            else f"simulate: motions are stiff: stability, not accuracy, keeps their steps short, "
            f"{here}, where part of the motion decays within {1.0 / decay:.1g} s. "
            f"method='implicit' with step= takes fewer."
        )

    def tell(self) -> None:
        """Warn, once, of what was found."""
        if self.text and not self.warned:
            self.warned = True
            warn(self.text)

    def while_telling(self, tell: Callable[[float], None]) -> Callable[[float], None]:
        """A function that tells the part that is done, and warns as soon as there is reason to."""

        def both(done: float) -> None:
            self.tell()
            tell(done)

        return both


@dataclass(eq=False)
class RunPace:
    """The steps of one run so far, as far as they are too short ever to reach its end."""

    end: float
    slow: int = 0

    def endless(self, before: float, now: float) -> bool:
        """Whether, with one more step, there are too many of them."""
        self.slow = self.slow + 1 if (now - before) * MOST < self.end - now else 0
        return self.slow >= IN_A_ROW


class Growth:
    """How long motions take to double their rates, as far as they are fast."""

    def __init__(self, lanes: int, end: float):
        self.end = end
        self.size = np.full(lanes, _FAST / 16.0)
        self.times = np.full((lanes, 4), np.nan)

    def hopeless(self, lanes: NDArray[np.intp], now: Array, qd: Array) -> Array:
        """(k,): of motions that had the rates qd (k, n) at times now (k,), how long one that grows
        without hope took to double them (s), NaN of all others.

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
    """How the rates of motions grow from one call of a controller to the next."""

    calls: int
    sizes: list[Array] = field(default_factory=list)

    def hopeless(self, qd: Array) -> NDArray[np.bool_]:
        """(lanes,): whether, with one more call at rates qd (lanes, nv), they grow so that no step
        leads on to the end."""
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
    """The last step of a motion of which too many would follow: its times, and the rates (nv,)
    behind it; how long they took to double (s), where it is because they grow."""

    before: float
    now: float
    qd: Array
    doubling: float = np.nan


def endless(run: Simulation, last: GivenUp, lane: int = 0) -> str:
    """The reason for giving up a motion, as sentences."""
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
    """A sentence on times so large that steps do not count beside them; "" where they are not."""
    apart = float(np.spacing(np.abs(t).max()))
    if apart <= _COARSE * (t[-1] - t[0]):
        return ""
    return f"At t = {t[0]:g} s numbers are {apart:.1g} s apart: let the times begin at 0."


def hopeless(run: Simulation, now: float, qd: Array) -> str:
    """The reason for giving up a motion whose rates, qd (nv,) by now, grow from call to call."""
    why = why_sampled(run) or "The loop that the torque closes is unstable."
    return (
        f"simulate: the motion grows from one call of the torque to the next: at t = {now:.6g} s "
        f"{_moving(run, qd)}, and no step would lead on to the end. {why}"
    )


def _why_short(run: Simulation, qd: Array, step: float, lane: int) -> str:
    """The reason for the short steps of one motion, or for their number, as sentences."""
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
            "that it is called now and then, friction='dry' is Coulomb friction."
        )
    return "The motion may pass a state without finite acceleration, or be stiff."


def _moving(run: Simulation, qd: Array) -> str:
    """Words for the fastest coordinate and its rate."""
    k = int(np.argmax(np.abs(qd)))
    own = k % run.model.nv  # qd may be those of motions that step alike
    unit = "rad/s" if angular(run.model)[own] else "m/s"
    return f"{run.model.velocity_names[own]!r} moves at {abs(qd[k]):.3g} {unit}"


def why_sampled(run: Simulation, lane: int = 0) -> str:
    """Sentences on a motion that grows because its torque is sampled too seldom, with the sampling
    time up to which it would not; "" where it does not, or where that cannot be found."""
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
    """ẏ = A y + B u, u = K y, u being held from one instant to the next."""

    A: Array
    B: Array
    K: Array

    @staticmethod
    def at_start(run: Simulation, lane: int) -> _SampledLoop:
        """The loop of one motion, linearised at its start."""
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
        """The largest factor of growth from one instant to the next, and what grows."""
        n, m = self.B.shape
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:] = self.A, self.B
        moved = expm(sample_time * whole)
        factors, motions = np.linalg.eig(moved[:n, :n] + moved[:n, n:] @ self.K)
        k = int(np.argmax(np.abs(factors)))
        return float(np.abs(factors[k])), np.abs(motions[:, k])

    def stable(self, sample_time: float) -> bool:
        """Whether nothing grows but what would without sampling."""
        rate = float(np.linalg.eigvals(self.A + self.B @ self.K).real.max())
        most = (1.0 + _MARGIN) * np.exp(max(0.0, rate) * sample_time)
        return self.largest(sample_time)[0] <= most

    def longest(self, sample_time: float) -> float | None:
        """The longest stable sampling time (s) below one that is not; None where there is none."""
        shorter = sample_time / _FINER ** np.arange(1, round(_OCTAVES * np.log(2) / np.log(_FINER)))
        return next((float(x) for x in shorter if self.stable(float(x))), None)


def lane_system(run: Simulation, k: int, model: Model | None = None) -> System:
    """The system of one motion of a batch, perhaps of another model."""
    lanes, chosen = run.lanes, run.model if model is None else model
    loads = {n: some_of(lanes.each(w, 2), 2, k) for n, w in run.wrenches.items()}
    member = member_at(chosen, lanes.index(k))
    return system(member, run.width, *loads_over(run.t, loads))


def lane_drive(run: Simulation, k: int, driving: Driving) -> TorqueLaw:
    """Torque and forces of one motion, of a batch of its states; of what does not depend on them,
    0."""
    sampled = run.sample_time is not None
    pairs = (None if sampled else run.torque, driving.drive), (run.forces, driving.forces)
    acting = [
        one_lane(given, run.lanes, k) if isinstance(given, CompiledTorque) else _each(drive)
        for given, drive in pairs
        if callable(given) and drive is not None
    ]
    still = np.zeros(run.model.nv)
    return lambda now, q, qd: sum((drive(now, q, qd) for drive in acting), still)


def _each(drive: TorqueLaw) -> TorqueLaw:
    """A torque of one state at a time as one of a batch of states."""
    return lambda now, q, qd: np.stack([drive(now, *state) for state in zip(q, qd, strict=True)])
