"""Torques as step kernels take them: a line over each step from a table, a value that is held, or
the inputs of a compiled law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from freebody.arrays import Array
from freebody.motion.simulation.motion_lanes import MotionLanes, Some, some_of
from freebody.program import Program


class LaneTorque(Protocol):
    """What acts at the joints of many motions."""

    @property
    def law(self) -> Program | None:
        """What is compiled into the step; None where it takes the torques at both its ends."""
        ...

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """What the step kernel takes of some lanes for a step from one time to another, floats or
        one for each lane, between which no edge lies."""
        ...


@dataclass(frozen=True, eq=False)
class TableTorque:
    """Straight lines between the rows at the times t (T,); rows (T, nv), or (lanes, T, nv), or one
    row for all times."""

    t: Array
    rows: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The torques at both times."""
        rows = some_of(self.rows, 2, lanes)
        if self.rows.shape[-2] == 1:
            return rows[..., 0, :], rows[..., 0, :]
        middle = 0.5 * (start + end)
        k = np.clip(np.searchsorted(self.t, middle, side="right") - 1, 0, len(self.t) - 2)
        if np.ndim(k) and rows.ndim == 3:
            every = np.arange(len(rows))
            first, last = rows[every, k], rows[every, k + 1]
        else:
            first, last = rows[..., k, :], rows[..., k + 1, :]
        begun, slope = self.t[k], (last - first) / (self.t[k + 1] - self.t[k])[..., None]
        near, far = (first + np.asarray(x - begun)[..., None] * slope for x in (start, end))
        return near, far

    def given(self, t: Array) -> Array:
        """(lanes, nv) or (nv,) at a time of the table."""
        if self.rows.shape[-2] == 1:
            return self.rows[..., 0, :]
        return self.rows[..., int(np.searchsorted(self.t, t)), :]


@dataclass(eq=False)
class HeldTorque:
    """What a controller gave at its last instant (lanes, nv)."""

    tau: Array
    law: None = None

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """It twice."""
        return self.tau[lanes], self.tau[lanes]


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
        """With inputs of any batch shape."""
        each = tuple(lanes.each(x, core) for x, core in zip(more, cores, strict=True))
        return LawTorque(law, each, cores)

    def inputs(self, lanes: Some, start: Array | float, end: Array | float) -> tuple[Array, ...]:
        """The law's own inputs."""
        return tuple(some_of(x, core, lanes) for x, core in zip(self.more, self.cores, strict=True))
