"""Loads with limits as functions of the pace of a motion: torques and forces of drives, what brakes
hold, what bearings bear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.motion.intervals import Interval
from freebody.motion.ranges import CLOSE, Flags

PaceWays = list[tuple[list[Array], list[Array]]]
"""Pairs of coefficients (T, n): (a, b, c) of a load a k² + b k + c at the pace k, and those of a
polynomial that is positive where the first is valid."""


@dataclass(frozen=True, eq=False)
class LimitedLoads:
    """Loads (T, n) with limits (n,), all finite, as functions of the pace: at 0 those of slow
    motion; polynomials of it, or None where they are none."""

    names: tuple[str, ...]
    """Names of the joints that have the loads."""
    quantities: tuple[str, ...]
    units: tuple[str, ...]
    limits: Array
    time: Array
    at: Callable[[Any], Any]
    """Loads at a pace, or those that occur at the paces of an interval; (K, T, n) at K of them."""
    ways: PaceWays | None
    known: bool = True
    """Whether it is known what they are at other paces than 1."""

    @property
    def bound(self) -> Array:
        """The limits, with what rounding may exceed them by."""
        return self.limits * (1.0 + CLOSE)

    def kept(self, slow: Array, fast: Array) -> Flags:
        """Flags (K,) where the limits are surely kept at all paces from slow (K,) to fast (K,)."""
        loads = self.at(Interval(slow, fast))
        sizes = loads.size if isinstance(loads, Interval) else np.abs(loads)
        within = (sizes <= self.bound).all(axis=(-2, -1))
        return np.broadcast_to(within, slow.shape)

    def shares(self, pace: float) -> Array:
        """Shares (T, n) of the limits at a pace; of a limit of 0 infinite, of nothing 0."""
        size = np.abs(self.at(pace))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(size == 0.0, 0.0, size / self.limits)


def efforts_named(turns: Flags) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """(quantities, units) of the efforts of joints, by whether each turns."""
    of = [EFFORTS[bool(x)] for x in turns]
    return tuple(what for what, _ in of), tuple(unit for _, unit in of)


EFFORTS = {True: ("torque", "N m"), False: ("force", "N")}
"""Names of the effort of a joint, with its unit, by whether the joint turns."""


def constant(size: Array) -> PaceWays:
    """The polynomials of loads (T, n) that are the same at every pace."""
    nothing = 0.0 * size
    return [([nothing, nothing, size], [nothing, nothing, nothing + 1.0])]
