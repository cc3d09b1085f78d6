"""What a simulation is asked for, its arguments checked, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.simulation.first_order_system import Drive
from freebody.motion.simulation.joint_contacts import JointContacts
from freebody.motion.simulation.motion_lanes import MotionLanes
from freebody.motion.simulation.torques import Given


@dataclass(frozen=True, eq=False)
class Simulation:
    """The arguments of `simulate`, as arrays of the right shapes.

    q (..., nq), qd (..., nv), wrenches by frame (..., T or 1, six), contacts (..., nv): their
    leading axes and the model's family broadcast to `lanes`. torque, and forces besides: tables
    (..., T or 1, nv), Python functions, or compiled. contacts: dry friction, which the model then
    is without, and stops.
    """

    model: Model
    q: Array
    qd: Array
    t: Array
    torque: Given
    forces: Given | None
    wrenches: Mapping[str, Array]
    lanes: MotionLanes
    contacts: JointContacts | None
    tolerance: float
    width: float
    max_step: float
    step: float | None
    breakpoints: Array
    sample_time: float | None
    every: int
    threads: int | None
    tell: Callable[[float], None]

    @property
    def duration(self) -> float:
        """In s."""
        return float(self.t[-1] - self.t[0])


@dataclass(eq=False)
class Simulated:
    """States at the times t (R,), NaN where there are none yet: q (..., R, nq), qd (..., R, nv);
    what was used, for the result's attributes.

    It is filled while the simulation runs, so that it holds what there is when that ends early.
    tau (..., R, nv): the torques, where they are found on the way. given: else, of t, q (..., nq)
    and qd, all motions at one time.
    """

    t: Array
    q: Array
    qd: Array
    used: dict[str, Any]
    tau: Array | None = None
    given: Drive | None = None

    def torques(self) -> Array:
        """(..., R, nv)."""
        if self.tau is not None or self.given is None:
            return np.full(self.qd.shape, np.nan) if self.tau is None else self.tau
        found = np.empty(self.qd.shape)
        for k, now in enumerate(self.t):
            found[..., k, :] = self.given(now, self.q[..., k, :], self.qd[..., k, :])
        return found

    def until_now(self) -> Simulated:
        """Without the times that no motion has reached."""
        reached = np.isfinite(self.qd).all(axis=-1).reshape(-1, len(self.t)).any(axis=0)
        last = int(np.flatnonzero(reached)[-1]) + 1 if reached.any() else 1
        tau = None if self.tau is None else self.tau[..., :last, :]
        states = self.q[..., :last, :], self.qd[..., :last, :]
        return Simulated(self.t[:last], *states, self.used, tau, self.given)
