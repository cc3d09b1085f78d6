"""Occasional checks whether stiffness, not accuracy, keeps steps short."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from freebody.arrays import Array, at_sample
from freebody.errors import warn
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import (
    EXPLICIT,
    System,
    TorqueLaw,
    loads_over,
    system,
)
from freebody.motion.simulation.one_step import Driving, LaneState
from freebody.motion.simulation.prepared_simulation import (
    CompiledTorque,
    MotionLanes,
    Simulation,
    one_lane,
    some_of,
)
from freebody.motion.smooth_friction import smooth_friction

_EVERY = 50  # steps between two looks, of which one costs as much as a step or two
# step times decay rate from which stability, not accuracy, tells the step: both methods are stable
# to about 3 and 6
_BOUND = 1.5
_SHORT = 5e-4
"""Length of a step, as a part of the duration, below which it is looked at."""
_STABLE = 1.5
"""Step times decay rate from which stability, not accuracy, tells the step (5 is the most)."""
_BENT = 0.03
"""Step times decay rate from which the bends of smooth friction keep a step short, if it makes the
rate twice as fast."""
_SEEN, _LOOKS = 10, 500
_BLOCK, _LOOKED_AT = 1000, 10
"""Steps of one motion between two looks at how many follow, and how many looks there are."""
_STEADY = 1.5
"""How much further a block of steps may lead than the one before, for the same pace."""
_LONG, _ENDLESS = 5e4, 1e7
"""Steps that take minutes, and those of runs that are given up anyway."""


@dataclass
class StiffnessWatch:
    """An occasional check whether the steps of an explicit method are kept short by stability alone
    (Hairer and Wanner 1996, IV.2)."""

    system: System
    duration: float
    switches: bool
    """Whether another method takes over; else a warning says that it should."""
    method: str = ""
    """Name of the method that took over."""
    since: float = -np.inf
    """Time at which stiffness was found (s)."""
    count: int = 0
    done: bool = False

    def steps(self, method: str) -> bool:
        """Whether stiffness is to be checked now, after one more step of a method."""
        if self.done or method not in EXPLICIT:
            return False
        self.count += 1
        return self.count % _EVERY == 0

    def look(self, drive: TorqueLaw, before: float, now: float, y: Array) -> None:
        """Check the step between two times that ended at the state y."""
        decay = self.system.fastest_decay(np.asarray(now), y, drive)
        step = now - before
        if decay * step < _BOUND:
            return
        self.done, self.since = True, now
        if self.switches:
            self.method = "LSODA"
        else:
            warn(
                f"simulate: the motion is stiff: at t = {now:.3g} s part of it decays within "
                f"{1.0 / decay:.1g} s. Explicit methods are stable only with steps as short as "
                f"{step:.1g} s, about {self.duration / step:.1g} in all. method='auto' or 'Radau' "
                f"takes far fewer.",
            )


@dataclass(eq=False)
class LongRun:
    """An occasional look at how many steps of one motion follow; a warning tells of very many at a
    pace that does not grow, as it does behind a transient."""

    run: Simulation
    steps: int = 0
    pace: float = np.nan
    """How far the block of steps before led, s; NaN: there is none."""
    reached: float = field(init=False)
    """The time at the last look."""

    def __post_init__(self) -> None:
        self.reached = float(self.run.t[0])

    def step(self, now: float) -> None:
        """Count a step that has reached the time `now`."""
        self.steps += 1
        if self.steps % _BLOCK or self.steps > _LOOKED_AT * _BLOCK:
            return
        pace = now - self.reached
        left = _BLOCK * (self.run.t[-1] - now) / pace
        if pace <= _STEADY * self.pace and _LONG < left < _ENDLESS:
            self.steps = _LOOKED_AT * _BLOCK  # said once
            warn(
                f"simulate: {_BLOCK} steps led from t = {self.reached:.6g} to {now:.6g} s, and at "
                f"this pace {left:.1g} more follow, which takes minutes. {self._remedy()}"
            )
        self.reached, self.pace = now, pace

    def _remedy(self) -> str:
        run = self.run
        _, friction = smooth_friction(run.model)
        if not friction.acts:
            return "A larger tolerance= takes fewer; so does method='rk4' with step=."
        compiled = not callable(run.torque) or isinstance(run.torque, CompiledTorque)
        steps = compiled or run.sample_time is not None
        equal = "method='implicit' with step=, " if steps else ""
        return (
            f"Smooth dry friction, which changes within friction_width = {run.width:g}, keeps "
            f"steps short: {equal}a larger tolerance= or a larger friction_width= takes fewer."
        )


@dataclass(eq=False)
class ShortSteps:
    """An occasional check of the motion that makes the shortest step of a block."""

    run: Simulation
    driving: Driving
    text: str = ""
    """The sentence on what was found."""
    warned: bool = False
    looks: int = 0
    seen: int = 0

    def look(self, lane: int, t: float, state: LaneState, step: float) -> None:
        """Check a motion at time t with q (nq,) and qd (nv,), after a step (s)."""
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
        """Warn of the findings, once."""
        if self.text and not self.warned:
            self.warned = True
            warn(self.text)

    def while_telling(self, tell: Callable[[float], None]) -> Callable[[float], None]:
        """A function that reports the fraction done, and warns as soon as there is something to
        warn of."""

        def both(done: float) -> None:
            self.tell()
            tell(done)

        return both


def lane_system(run: Simulation, k: int, model: Model | None = None) -> System:
    """The first-order system of one motion of a batch, perhaps of another model."""
    lanes, chosen = run.lanes, run.model if model is None else model
    loads = {n: some_of(lanes.each(w, 2), 2, k) for n, w in run.wrenches.items()}
    member = member_at(chosen, lanes.index(k))
    return system(member, run.width, *loads_over(run.t, loads))


def lane_drive(run: Simulation, k: int, driving: Driving) -> TorqueLaw:
    """The torque and forces on one motion for a batch of its states; 0 for those that do not depend
    on the state."""
    sampled = run.sample_time is not None
    pairs = (None if sampled else run.torque, driving.drive), (run.forces, driving.forces)
    acting = [
        one_lane(given, run.lanes, k)
        if isinstance(given, CompiledTorque)
        else _one_by_one(drive, run.lanes)
        for given, drive in pairs
        if callable(given) and drive is not None
    ]
    still = np.zeros(run.model.nv)
    return lambda now, q, qd: sum((drive(now, q, qd) for drive in acting), still)


def _one_by_one(drive: TorqueLaw, lanes: MotionLanes) -> TorqueLaw:
    """A Python function for a batch of a single motion, as a function of many states of that
    motion."""

    def each(now: Array, q: Array, qd: Array) -> Array:
        states = zip(*(x.reshape(-1, *lanes.shape, x.shape[-1]) for x in (q, qd)), strict=True)
        return np.stack([drive(now, *state).reshape(-1) for state in states])

    return each
