"""Stiffness that an explicit integrator meets on its way: seen by its steps, told, or answered by
another method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.errors import warn
from freebody.motion.simulation.first_order_system import Drive, System

EXPLICIT_METHODS = ("DOP853", "RK45")
_EVERY = 50  # steps between two looks, of which one costs as much as a step or two
# step times decay rate from which stability, not accuracy, tells the step: both methods are stable
# to about 3 and 6
_BOUND = 1.5


@dataclass
class StiffnessWatch:
    """Looks now and then whether the steps of an explicit method are as short as they are for
    stability alone (Hairer and Wanner 1996, IV.2)."""

    system: System
    duration: float
    switches: bool
    """Whether another method takes over; else a warning says that it should."""
    method: str = ""
    """That which took over."""
    since: float = -np.inf
    """When it was found (s)."""
    count: int = 0
    done: bool = False

    def steps(self, method: str) -> bool:
        """Whether it is time to look, after one more step of a method."""
        if self.done or method not in EXPLICIT_METHODS:
            return False
        self.count += 1
        return self.count % _EVERY == 0

    def look(self, drive: Drive, before: float, now: float, y: Array) -> None:
        """At the step from one time to the other, to the state y."""
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
