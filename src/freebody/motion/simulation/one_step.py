"""The step of many motions: what drives them, as step kernels take it (a line over each step from a
table, a value that is held, or the inputs of a compiled law), and how a step is made, by a kernel
or, where a torque is a Python function, by the stages of a method in NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.kernels.structural import Bound
from freebody.motion.simulation.first_order_system import System, TorqueLaw
from freebody.motion.simulation.run import (
    CompiledTorque,
    MotionLanes,
    Simulation,
    Some,
    drive_of,
    function_of,
    some_of,
)
from freebody.motion.simulation.step_kernels import both_laws
from freebody.program import Program
from freebody.targets import Kernel
from freebody.targets.in_turn import Placed, in_turn
from freebody.trees.position_rates import position_rate
from freebody.trees.special_joints import all_driven

LaneState = tuple[Array, Array]
"""Positions q (lanes, nq) and rates q̇ (lanes, nv)."""
_SLICE = 400  # of what a thread is woken for: some 20 ms


class LaneTorque(Protocol):
    """A torque, or additional forces, at the joints of many motions in the form that step kernels
    take."""

    @property
    def law(self) -> Program | None:
        """The law that is compiled into the step; None for kernels that take a straight line
        between two torques."""
        ...

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The inputs of the step kernel for some lanes and a step between two times (numbers, or
        one for each lane) with no edge in between."""
        ...

    def in_turn(self, lanes: slice, start: Array, end: Array) -> tuple[Array | Placed, ...]:
        """The inputs of the step kernel for consecutive steps with the start and end times (k,)."""
        ...


@dataclass(frozen=True, eq=False)
class TableTorque:
    """Torques or a wrench in straight lines between rows at the times t (T,); rows (T, nv), or
    (lanes, T, nv), or one row for all times."""

    t: Array
    rows: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The inputs of the step kernel from the table: the two rows around a step, and where
        between them the step begins and ends."""
        rows = some_of(self.rows, 2, lanes)
        if self.rows.shape[-2] == 1:
            return steady(rows[..., 0, :])
        k, parts = self._between(start, end)
        if np.ndim(k) and rows.ndim == 3:
            every = np.arange(len(rows))
            return rows[every, k], rows[every, k + 1], parts
        return rows[..., k, :], rows[..., k + 1, :], parts

    def in_turn(self, lanes: slice, start: Array, end: Array) -> tuple[Array | Placed, ...]:
        """The inputs of the step kernel from the table for consecutive steps; see `LaneTorque`."""
        if self.rows.shape[-2] == 1:
            return self.inputs(lanes, 0.0, 0.0)
        k, parts = self._between(start, end)
        rows, first = some_of(self.rows, 2, lanes), np.zeros_like(k)
        by_time = (rows[:, None] if rows.ndim == 2 else rows.swapaxes(0, 1),)
        return Placed(by_time, first, k), Placed(by_time, first, k + 1), parts[:, None]

    def _between(self, start: Array | float, end: Array | float) -> tuple[NDArray[np.intp], Array]:
        """The index of the row before each step, and the fractions (..., 2) of the way to the next
        row at which the step begins and ends."""
        middle = 0.5 * (start + end)
        k = np.clip(np.searchsorted(self.t, middle, side="right") - 1, 0, len(self.t) - 2)
        begun, whole = self.t[k], self.t[k + 1] - self.t[k]
        return k, np.stack([(start - begun) / whole, (end - begun) / whole], axis=-1)

    def given(self, t: Array) -> Array:
        """The row (lanes, nv) or (nv,) at one of the table's times."""
        if self.rows.shape[-2] == 1:
            return self.rows[..., 0, :]
        return self.rows[..., int(np.searchsorted(self.t, t)), :]


@dataclass(eq=False)
class HeldTorque:
    """The torque (lanes, nv) that a controller returned at its last call."""

    tau: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The inputs of the step kernel for some lanes from the torque that is held."""
        return steady(self.tau[lanes])

    in_turn = inputs


@dataclass(frozen=True, eq=False)
class LawTorque:
    """A compiled torque law, with its inputs besides time and state: (lanes, *core), or one for
    all."""

    law: Program
    more: tuple[Array, ...]
    cores: tuple[int, ...]

    @staticmethod
    def of(
        law: Program, lanes: MotionLanes, more: tuple[Array, ...], cores: tuple[int, ...]
    ) -> LawTorque:
        """The compiled law for a batch of motions, from inputs of any batch shape."""
        each = tuple(lanes.each(x, core) for x, core in zip(more, cores, strict=True))
        return LawTorque(law, each, cores)

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The inputs of the law besides time and state, for some lanes."""
        return tuple(some_of(x, core, lanes) for x, core in zip(self.more, self.cores, strict=True))

    in_turn = inputs


@dataclass(frozen=True, eq=False)
class SteadyWrench:
    """A constant wrench (lanes, six), or (six,) for all lanes."""

    value: Array

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The inputs of the step kernel for some lanes from the constant wrench."""
        return (some_of(self.value, 1, lanes),)

    in_turn = inputs


def steady(tau: Array) -> tuple[Array, Array, Array]:
    """A constant torque in the form of a table's inputs to the step kernel."""
    return tau, tau, np.zeros(2)


LaneWrench = TableTorque | SteadyWrench


@dataclass(frozen=True, eq=False)
class LaneKernel:
    """A kernel of `step_kernels` with the inputs of a batch: wrenches, and the model's numbers
    (lanes, k) or (k,)."""

    kernel: Kernel
    width: Array
    wrenches: Sequence[LaneWrench]
    numbers: Array

    @staticmethod
    def of(
        kernel: Bound, width: float, lanes: MotionLanes, wrenches: Sequence[LaneWrench]
    ) -> LaneKernel:
        """The kernel with the wrenches and the model's numbers of a batch."""
        (numbers,) = kernel.numbers
        numbers = lanes.each(numbers, 1)
        assert isinstance(kernel.kernel, Kernel)
        own = kernel.kernel if numbers.ndim == 1 else kernel.kernel.per_sample
        return LaneKernel(own, np.asarray(width), wrenches, numbers)

    @property
    def at_once(self) -> int:
        """The number of steps (of one lane each) in one call of the kernel that keeps an interrupt
        from waiting long."""
        return _SLICE * self.kernel.samples_of_a_thread if self.kernel.loop else 1

    def __call__(
        self,
        lanes: Some,
        state: LaneState,
        h: Array | float,
        start: Array | float,
        given: tuple[Array, ...],
    ) -> Any:
        """The kernel's outputs for some lanes; given: the inputs for the torque, and for what is
        held."""
        loads = [x for w in self.wrenches for x in w.inputs(lanes, start, start + h)]
        p = some_of(self.numbers, 1, lanes)
        # what comes is checked, and blocks are short: a call as plain as there is
        return self.kernel.ufunc(*state, h, self.width, start, *given, *loads, p)

    def in_turn(
        self,
        lanes: slice,
        places: Sequence[Placed],
        start: Array,
        h: Array,
        given: Sequence[Array | Placed],
    ) -> None:
        """Run consecutive steps of lengths h (k,) from the times `start` (k,); places: of q and q̇
        before and after each step."""
        before, after, times = places[:2], places[2:], (h[:, None], self.width, start[:, None])
        loads = (x for w in self.wrenches for x in w.in_turn(lanes, start, start + h))
        arrays = (*before, *times, *given, *loads, some_of(self.numbers, 1, lanes), *after)
        in_turn(self.kernel, arrays, len(h), lanes.stop - lanes.start)


@dataclass(frozen=True, eq=False)
class KernelStepper:
    """A stepper that runs a step kernel. added: forces besides the torque. holding: the senses that
    replace the signs of rates in friction, and flags of held coordinates, arrays (lanes, nv) that
    change between steps."""

    kernel: LaneKernel
    torque: LaneTorque
    rows: int
    added: LaneTorque | None = None
    holding: tuple[Array, Array] | None = None

    def step(
        self, lanes: Some, state: LaneState, start: Array | float, h: Array | float
    ) -> LaneState:
        """The states of some lanes a step h (s) after `start`; both are numbers, or one for each
        lane."""
        given = self.torque.inputs(lanes, start, start + h)
        if self.added is not None:
            given = (*given, *self.added.inputs(lanes, start, start + h))
        if self.holding is not None:
            given = (*given, *(x[lanes] for x in self.holding))
        return self.kernel(lanes, state, h, start, given)

    def in_turn(self, lanes: slice, places: Sequence[Placed], start: Array, h: Array) -> None:
        """Run consecutive steps, see `LaneKernel`; no coordinate is held."""
        given = self.torque.in_turn(lanes, start, start + h)
        if self.added is not None:
            given = (*given, *self.added.in_turn(lanes, start, start + h))
        self.kernel.in_turn(lanes, places, start, h, given)


@dataclass(frozen=True, eq=False)
class FunctionStepper:
    """A stepper for a Python function of all motions at once, which therefore all take the same
    steps as a single row.

    The stages of the classical Runge-Kutta method over q and q̇, or semi-implicit Euler; quaternions
    are brought back to unit length.
    """

    system: System
    drive: TorqueLaw
    shape: tuple[int, ...]
    classical: bool
    rows: int = 1

    def step(
        self, lanes: Some, state: LaneState, start: Array | float, h: Array | float
    ) -> LaneState:
        """The states a step h (s) after `start`, both the same for all motions."""
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


Stepper = KernelStepper | FunctionStepper


@dataclass(frozen=True, eq=False)
class KernelRates:
    """Accelerations, holding torques and the mass matrix by a kernel of `driven_rates`."""

    kernel: LaneKernel
    torque: LaneTorque
    added: LaneTorque | None = None

    def __call__(
        self, lanes: Some, state: LaneState, t: Array | float, senses: Array, held: Array
    ) -> tuple[Array, Array, Array, Array]:
        """(q̈, reaction, M, drag) of some lanes, with given senses of friction and held
        coordinates."""
        more = () if self.added is None else self.added.inputs(lanes, t, t)
        given = (*self.torque.inputs(lanes, t, t), *more, senses, held)
        return self.kernel(lanes, state, 0.0, t, given)


@dataclass(frozen=True, eq=False)
class FunctionRates:
    """Accelerations, holding torques and the mass matrix of one motion under a Python function."""

    kernel: LaneKernel
    drive: TorqueLaw

    def __call__(
        self, lanes: Some, state: LaneState, t: Array | float, senses: Array, held: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Accelerations, holding torques, mass matrix and size of dry friction in some states."""
        pairs = zip(np.broadcast_to(t, len(state[0])), *state, strict=True)
        tau = np.stack([self.drive(*now) for now in pairs])
        return self.kernel(lanes, state, 0.0, t, (*steady(tau), senses, held))


Rates = KernelRates | FunctionRates


@dataclass(frozen=True, eq=False)
class Driving:
    """Everything that drives the motions of a batch: their torque at the times of the result,
    additional forces at any time, and the sum of both as steps in Python take it.

    torque, added: as step kernels take them, None where a Python function acts within the steps, or
    nothing is added. held: what a controller gave, where there is one.
    """

    drive: TorqueLaw
    forces: TorqueLaw | None
    acting: TorqueLaw
    torque: LaneTorque | None
    added: LaneTorque | None = None
    held: HeldTorque | None = None

    @property
    def adds(self) -> bool:
        """Whether step kernels take forces besides the torque."""
        return self.added is not None


def driving_of(run: Simulation) -> Driving:
    """The torques and forces of a simulation in the forms that its steps take."""
    drive, torque = _torque(run)
    held = torque if isinstance(torque, HeldTorque) else None
    if run.forces is None:
        return Driving(drive, None, drive, torque, held=held)
    model, lanes, given = run.model, run.lanes, run.forces
    forces = drive_of(all_driven(model), run.t, given, lanes.shape, "forces")
    whole = (*lanes.shape, model.nv)
    table = isinstance(run.torque, np.ndarray)
    own = drive_of(model, run.t, run.torque, lanes.shape) if table else drive

    def acting(now: Array, q: Array, qd: Array) -> Array:
        tau = own(now, q, qd) if held is None else held.tau.reshape(whole)
        return tau + forces(now, q, qd)

    if torque is None or not isinstance(given, np.ndarray | CompiledTorque):
        return Driving(drive, forces, acting, None, held=held)
    if isinstance(given, np.ndarray):
        added = TableTorque(run.t, lanes.each(given, 2))
        return Driving(drive, forces, acting, torque, added, held)
    if isinstance(torque, LawTorque):
        both = LawTorque(both_laws(torque.law, given.law), torque.more, torque.cores)
        return Driving(drive, forces, acting, both, held=held)
    return Driving(drive, forces, acting, LawTorque.of(given.law, lanes, (), ()), torque, held)


def _torque(run: Simulation) -> tuple[TorqueLaw, LaneTorque | None]:
    """The torque of all motions as a function of time and state, and in the form that step kernels
    take; None for the latter with a Python function that acts within steps."""
    torque, lanes, nv = run.torque, run.lanes, run.model.nv
    if isinstance(torque, np.ndarray):
        table = TableTorque(run.t, lanes.each(torque, 2))
        whole = (*lanes.shape, nv)
        return lambda now, q, qd: np.broadcast_to(_shaped(table.given(now), whole), whole), table
    drive = function_of(run.model, torque, lanes.shape)
    if run.sample_time is not None:
        return drive, HeldTorque(np.zeros((lanes.count, nv)))
    if isinstance(torque, CompiledTorque):
        return drive, LawTorque.of(torque.law, lanes, torque.more, torque.cores)
    return drive, None


def _shaped(tau: Array, whole: tuple[int, ...]) -> Array:
    """Torques as a single row where all motions share one, else in the batch's shape."""
    return tau if tau.ndim == 1 else tau.reshape(whole)
