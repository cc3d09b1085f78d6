"""One step of many motions: by a step kernel, or by the stages of a method in NumPy where a torque
is a Python function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.kernels.structural import Bound
from freebody.motion.simulation.first_order_system import Drive, System
from freebody.motion.simulation.lane_torques import LaneTorque
from freebody.motion.simulation.motion_lanes import MotionLanes, Some, some_of
from freebody.targets import Kernel
from freebody.trees.position_rates import position_rate

State = tuple[Array, Array]
"""q (lanes, nq), q̇ (lanes, nv)."""


@dataclass(frozen=True, eq=False)
class LaneKernel:
    """What a kernel of `driven_steps` runs, with the arrays of a batch: wrenches (lanes, six) or
    (six,), the model's numbers (lanes, k) or (k,)."""

    run: Callable[..., tuple[Array, ...]]
    width: float
    wrenches: Sequence[Array]
    numbers: Array

    @staticmethod
    def of(
        kernel: Bound, width: float, lanes: MotionLanes, wrenches: Sequence[Array]
    ) -> LaneKernel:
        """With the wrenches and the model's numbers of a batch."""
        (numbers,) = kernel.numbers
        loads, numbers = [lanes.each(w, 1) for w in wrenches], lanes.each(numbers, 1)
        assert isinstance(kernel.kernel, Kernel)
        # what comes is checked, and blocks are short: a call as plain as there is
        own = kernel.kernel if numbers.ndim == 1 else kernel.kernel.per_sample
        return LaneKernel(own.ufunc, width, loads, numbers)

    def __call__(
        self,
        lanes: Some,
        state: State,
        h: Array | float,
        start: Array | float,
        given: tuple[Array, ...],
        out: State | None = None,
    ) -> Any:
        """Of some lanes; given: the torque, and what is held."""
        loads = [some_of(w, 1, lanes) for w in self.wrenches]
        p = some_of(self.numbers, 1, lanes)
        arrays = (*state, h, self.width, start, *given, *loads, p)
        return self.run(*arrays) if out is None else self.run(*arrays, out=out)


@dataclass(frozen=True, eq=False)
class KernelStepper:
    """By a step kernel. holding: torques that push besides, and what is held (lanes, nv), arrays
    that change between steps."""

    kernel: LaneKernel
    torque: LaneTorque
    rows: int
    holding: tuple[Array, Array] | None = None

    def step(
        self,
        lanes: Some,
        state: State,
        start: Array | float,
        h: Array | float,
        out: State | None = None,
    ) -> State:
        """The states of some lanes a step h (s) after `start`, floats or one for each lane."""
        given = self.torque.inputs(lanes, start, start + h)
        if self.holding is not None:
            given = (*given, *(x[lanes] for x in self.holding))
        return self.kernel(lanes, state, h, start, given, out)


@dataclass(frozen=True, eq=False)
class KernelRates:
    """Accelerations, what holds, and M, by a kernel of `driven_rates`."""

    kernel: LaneKernel
    torque: LaneTorque

    def __call__(
        self, lanes: Some, state: State, t: Array | float, push: Array, held: Array
    ) -> tuple[Array, Array, Array]:
        """(q̈, reaction, M) of some lanes, where some torques push besides and some coordinates are
        held."""
        given = (*self.torque.inputs(lanes, t, t), push, held)
        return self.kernel(lanes, state, 0.0, t, given)


@dataclass(frozen=True, eq=False)
class FunctionRates:
    """The same of one motion under a Python function."""

    kernel: LaneKernel
    drive: Drive

    def __call__(
        self, lanes: Some, state: State, t: Array | float, push: Array, held: Array
    ) -> tuple[Array, Array, Array]:
        """(q̈, reaction, M)."""
        pairs = zip(np.broadcast_to(t, len(state[0])), *state, strict=True)
        tau = np.stack([self.drive(*now) for now in pairs])
        return self.kernel(lanes, state, 0.0, t, (tau, tau, push, held))


@dataclass(frozen=True, eq=False)
class FunctionStepper:
    """By a Python function of all motions at once, which therefore take the same steps: one row.

    The stages of the classical Runge-Kutta method over q and q̇, or semi-implicit Euler; quaternions
    are brought back to unit length.
    """

    system: System
    drive: Drive
    shape: tuple[int, ...]
    classical: bool
    rows: int = 1

    def step(
        self,
        lanes: Some,
        state: State,
        start: Array | float,
        h: Array | float,
        out: State | None = None,
    ) -> State:
        """As of a `KernelStepper`; start and h are the same for all motions."""
        now, length = float(np.max(start)), float(np.max(h))
        y = np.concatenate([x.reshape(*self.shape, -1) for x in state], axis=-1)
        nq = self.system.layout.nq
        if self.classical:
            k1 = self._rate(now, y)
            k2 = self._rate(now + 0.5 * length, y + 0.5 * length * k1)
            k3 = self._rate(now + 0.5 * length, y + 0.5 * length * k2)
            k4 = self._rate(now + length, y + length * k3)
            end = y + length / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        else:
            qd1 = y[..., nq:] + length * self._rate(now, y)[..., nq:]
            end = np.concatenate([y[..., :nq], qd1], axis=-1)
            end[..., :nq] += length * position_rate(self.system.layout, y[..., :nq], qd1)
        q, qd = self.system.split(self.system.normalised(end))
        return q.reshape(1, -1), qd.reshape(1, -1)

    def _rate(self, now: float, y: Array) -> Array:
        return self.system.rate(
            np.asarray(now), y, self.drive(np.asarray(now), *self.system.split(y))
        )


Rates = KernelRates | FunctionRates
Stepper = KernelStepper | FunctionStepper
