"""Many motions whose steps are short because of friction or stiffness: found, and told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freebody.arrays import at_sample
from freebody.errors import warn
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.friction import smooth_friction
from freebody.motion.simulation.compiled_torque import CompiledTorque, one_lane
from freebody.motion.simulation.driving import Driving
from freebody.motion.simulation.first_order_system import Drive, System, loads_over, system
from freebody.motion.simulation.motion_lanes import some_of
from freebody.motion.simulation.simulation import Simulation
from freebody.motion.simulation.steppers import State

_SHORT = 5e-4
"""Of the duration: steps shorter than this are looked at."""
_STABLE = 1.5
"""Step times decay rate from which stability, not accuracy, tells the step (5 is the most)."""
_BENT = 0.03
"""The same from which the bends of smooth friction do, if it makes the rate twice as fast."""
_SEEN, _LOOKS = 10, 500


@dataclass(eq=False)
class ShortSteps:
    """Looks now and then at the motion that makes the shortest step of a block."""

    asked: Simulation
    driving: Driving
    text: str = ""
    """What was found."""
    told: bool = False
    looks: int = 0
    seen: int = 0

    def look(self, lane: int, t: float, state: State, step: float) -> None:
        """At a motion at time t, q (nq,) and qd (nv,), after a step (s)."""
        if self.text or step > _SHORT * self.asked.duration or self.looks >= _LOOKS:
            return
        self.looks += 1
        asked, y = self.asked, np.concatenate(state)
        torque = lane_drive(asked, lane, self.driving)
        decay = lane_system(asked, lane).fastest_decay(np.asarray(t), y, torque)
        smooth, friction = smooth_friction(asked.model)
        rubs = friction.acts and decay * step > _BENT
        if rubs:
            without = lane_system(asked, lane, smooth).fastest_decay(np.asarray(t), y, torque)
            rubs = decay > 2.0 * without
        self.seen += rubs or decay * step > _STABLE
        if self.seen < _SEEN:
            return
        here = f"{step:.1g} s at t = {t:.3g} s{at_sample(asked.lanes.index(lane))}"
        self.text = (
            f"simulate: smooth dry friction keeps the steps of motions short, {here}: it changes "
            f"within friction_width = {asked.width:g}. A larger tolerance= or friction_width=, or "
            f"method='implicit' with step=, takes fewer."
            if rubs
            else f"simulate: motions are stiff: stability, not accuracy, keeps their steps short, "
            f"{here}, where part of the motion decays within {1.0 / decay:.1g} s. "
            f"method='implicit' with step= takes fewer."
        )

    def tell(self) -> None:
        """Warn, once, of what was found."""
        if self.text and not self.told:
            self.told = True
            warn(self.text)

    def while_telling(self, tell: Callable[[float], None]) -> Callable[[float], None]:
        """The same function of the part that is done, which warns as soon as there is reason to."""

        def both(done: float) -> None:
            self.tell()
            tell(done)

        return both


def lane_system(asked: Simulation, k: int, model: Model | None = None) -> System:
    """The system of one motion of a batch, perhaps of another model."""
    lanes, chosen = asked.lanes, asked.model if model is None else model
    loads = {n: some_of(lanes.each(w, 2), 2, k) for n, w in asked.wrenches.items()}
    member = member_at(chosen, lanes.index(k))
    return system(member, asked.width, *loads_over(asked.t, loads))


def lane_drive(asked: Simulation, k: int, driving: Driving) -> Drive:
    """Torque and forces of one motion, of a batch of its states; of what does not depend on them,
    0."""
    sampled = asked.sample_time is not None
    pairs = (None if sampled else asked.torque, driving.drive), (asked.forces, driving.forces)
    acting = [
        one_lane(given, asked.lanes, k) if isinstance(given, CompiledTorque) else _each(drive)
        for given, drive in pairs
        if callable(given) and drive is not None
    ]
    still = np.zeros(asked.model.nv)
    return lambda now, q, qd: sum((drive(now, q, qd) for drive in acting), still)


def _each(drive: Drive) -> Drive:
    """Of one state at a time, for a batch of them."""
    return lambda now, q, qd: np.stack([drive(now, *state) for state in zip(q, qd, strict=True)])
