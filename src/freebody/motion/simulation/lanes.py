"""Motions side by side, one a lane: their batch shape flattened, and torques and wrenches as step
kernels take them: a line over each step from a table, a value that is held, or the inputs of a
compiled law."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.program import Program
from freebody.targets.in_turn import Placed


@dataclass(frozen=True)
class MotionLanes:
    """The shape of a batch, and its members one after another."""

    shape: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of lanes, one for each motion."""
        return prod(self.shape)

    def each(self, array: Array, core: int) -> Array:
        """(count, *core) of an array (..., *core); one without leading axes, which is the same for
        all lanes, as it is. core: number of its axes."""
        if array.ndim == core:
            return array
        own = array.shape[array.ndim - core :]
        return np.broadcast_to(array, (*self.shape, *own)).reshape(self.count, *own)

    def all(self, array: Array, core: int) -> Array:
        """A copy (count, *core) of an array for all lanes."""
        own = array.shape[array.ndim - core :]
        return np.array(np.broadcast_to(array, (*self.shape, *own))).reshape(self.count, *own)

    def index(self, lane: int) -> tuple[int, ...]:
        """The index of a lane in the batch."""
        return tuple(map(int, np.unravel_index(lane, self.shape))) if self.shape else ()


Some = int | slice | NDArray[np.intp]
"""A choice of lanes: one without its axis, or several."""


def some_of(array: Array, core: int, lanes: Some) -> Array:
    """The rows of some lanes of an array that `MotionLanes.each` returned."""
    return array if array.ndim == core else array[lanes]


class LaneTorque(Protocol):
    """A torque, or forces besides, at the joints of many motions."""

    @property
    def law(self) -> Program | None:
        """The law that is compiled into the step; None where that takes a line from one torque to
        another."""
        ...

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """Inputs of the step kernel for some lanes and a step from one time to another, floats or
        one for each lane, between which no edge lies."""
        ...

    def in_turn(self, lanes: slice, start: Array, end: Array) -> tuple[Array | Placed, ...]:
        """Inputs of the step kernel for steps that follow one another, from times to others
        (k,)."""
        ...


@dataclass(frozen=True, eq=False)
class TableTorque:
    """Straight lines between the rows at the times t (T,), of torques or of a wrench; rows (T, nv),
    or (lanes, T, nv), or one row for all times."""

    t: Array
    rows: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """Rows between which the times are, and where between them."""
        rows = some_of(self.rows, 2, lanes)
        if self.rows.shape[-2] == 1:
            return steady(rows[..., 0, :])
        k, parts = self._between(start, end)
        if np.ndim(k) and rows.ndim == 3:
            every = np.arange(len(rows))
            return rows[every, k], rows[every, k + 1], parts
        return rows[..., k, :], rows[..., k + 1, :], parts

    def in_turn(self, lanes: slice, start: Array, end: Array) -> tuple[Array | Placed, ...]:
        """Rows of the table for steps that follow one another, see `LaneTorque`."""
        if self.rows.shape[-2] == 1:
            return self.inputs(lanes, 0.0, 0.0)
        k, parts = self._between(start, end)
        rows, first = some_of(self.rows, 2, lanes), np.zeros_like(k)
        by_time = (rows[:, None] if rows.ndim == 2 else rows.swapaxes(0, 1),)
        return Placed(by_time, first, k), Placed(by_time, first, k + 1), parts[:, None]

    def _between(self, start: Array | float, end: Array | float) -> tuple[NDArray[np.intp], Array]:
        """The row before each of some steps, and which parts of the way to the next they begin and
        end at (..., 2)."""
        middle = 0.5 * (start + end)
        k = np.clip(np.searchsorted(self.t, middle, side="right") - 1, 0, len(self.t) - 2)
        begun, whole = self.t[k], self.t[k + 1] - self.t[k]
        return k, np.stack([(start - begun) / whole, (end - begun) / whole], axis=-1)

    def given(self, t: Array) -> Array:
        """The row (lanes, nv) or (nv,) at a time of the table."""
        if self.rows.shape[-2] == 1:
            return self.rows[..., 0, :]
        return self.rows[..., int(np.searchsorted(self.t, t)), :]


@dataclass(eq=False)
class HeldTorque:
    """The torque that a controller gave at its last instant (lanes, nv)."""

    tau: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The torque that is held, for some lanes."""
        return steady(self.tau[lanes])

    in_turn = inputs


@dataclass(frozen=True, eq=False)
class LawTorque:
    """A compiled law, and what it takes besides time and state: (lanes, *core), or one for all."""

    law: Program
    more: tuple[Array, ...]
    cores: tuple[int, ...]

    @staticmethod
    def of(
        law: Program, lanes: MotionLanes, more: tuple[Array, ...], cores: tuple[int, ...]
    ) -> LawTorque:
        """The law with inputs of any batch shape."""
        each = tuple(lanes.each(x, core) for x, core in zip(more, cores, strict=True))
        return LawTorque(law, each, cores)

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """Inputs of the law besides time and state, for some lanes."""
        return tuple(some_of(x, core, lanes) for x, core in zip(self.more, self.cores, strict=True))

    in_turn = inputs


@dataclass(frozen=True, eq=False)
class SteadyWrench:
    """A wrench that does not change (lanes, six), or (six,) for all."""

    value: Array

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The wrench of some lanes."""
        return (some_of(self.value, 1, lanes),)

    in_turn = inputs


def steady(tau: Array) -> tuple[Array, Array, Array]:
    """A torque that does not change, as the step kernel takes it."""
    return tau, tau, np.zeros(2)
