"""A check whether the rates given for a motion are the slopes of its positions, and the
accelerations those of its rates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import Flags, angular
from freebody.trees.states import difference

_DISAGREE = 0.05
"""Difference from a slope, as a part of the largest value, that is reported."""
_ROUNDED = 64.0 * float(np.finfo(float).eps)
"""Difference that rounding makes, as a part of the largest value."""


@dataclass(frozen=True, eq=False)
class GivenRates:
    """Given rates `start` and `end` (T - 1, n) at the ends of the intervals between samples, and
    the slopes of the values there; rounded: (T - 1, 1) the effect of rounding on a slope."""

    slopes: Array
    start: Array
    end: Array
    rounded: Array

    @staticmethod
    def of(t: Array, moved: Array, largest: float, start: Array, end: Array) -> GivenRates:
        """The rates compared with the slopes of values; moved: (T - 1, n) the change in each
        interval, of values that are `largest` at most."""
        step = np.diff(t)[:, None]
        return GivenRates(moved / step, start, end, _ROUNDED * largest / step)

    @property
    def unexplained(self) -> Array:
        """(T - 1, n) by how much a slope differs from the mean of both rates, or negative: beyond
        what curvature explains, a sixth of what the change of the rates differs by from one
        interval to the next (of a smooth curve it is a twelfth; a corner can make it an eighth)."""
        change = self.end - self.start
        bends = np.abs(np.diff(change, axis=0, prepend=change[:1], append=change[-1:]))
        curvature = np.maximum(bends[:-1], bends[1:]) / 6.0
        return np.abs(self.slopes - 0.5 * (self.start + self.end)) - curvature - self.rounded

    @property
    def contradicted(self) -> Array:
        """The deviation (T - 1, n) of slopes from the given rates as a fraction of each
        coordinate's largest rate; any slope between the rates at an interval's ends is accepted."""
        beyond = np.maximum(self.unexplained - 0.5 * np.abs(self.end - self.start), 0.0)
        largest = np.maximum(np.abs(self.start), np.abs(self.slopes)).max(axis=0)
        return beyond / np.where(largest > 0.0, largest, 1.0)


def contradictions(
    model: Model, motion: Motion, rates: Flags, accelerations: Flags, before: Array | None
) -> Iterator[str]:
    """A sentence each on given rates and accelerations of coordinates (flags (nv,)) that are not
    the slopes of the positions and rates; before: (T, nv) as in `given_motion`."""
    t, q, qd, qdd = motion.t, motion.q, motion.qd, motion.qdd
    arriving = qdd if before is None else before
    of_positions = GivenRates.of(
        t, difference(model, q[:-1], q[1:]), np.abs(q).max(), qd[:-1], qd[1:]
    )
    of_rates = GivenRates.of(t, np.diff(qd, axis=0), np.abs(qd).max(), qdd[:-1], arriving[1:])
    for what, of, per, found, given in (
        ("rates", "positions", "/s", of_positions, rates),
        ("accelerations", "rates", "/s²", of_rates, accelerations),
    ):
        share = np.where(given, found.contradicted, 0.0)
        i, j = np.unravel_index(np.argmax(share), share.shape)
        if not share[i, j] > _DISAGREE:
            continue
        others = int((share > _DISAGREE).any(axis=0).sum()) - 1
        more = f", and those of {others} more," if others else ""
        unit = ("rad" if angular(model)[j] else "m") + per
        yield (
            f"The {what} given for {model.velocity_names[j]!r}{more} are not the slope of the "
            f"{of}: between t = {t[i]:.5g} and {t[i + 1]:.5g} s the slope is "
            f"{found.slopes[i, j]:.4g} {unit}, but {found.start[i, j]:.4g} and "
            f"{found.end[i, j]:.4g} {unit} are given."
        )
