"""Times of waypoints and samples for all planners, and a planned curve as a motion with samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats
from freebody.errors import FreebodyError, ShapeError
from freebody.model.model import Model
from freebody.motion.motion import NEAR, Motion
from freebody.motion.piecewise import PiecewisePolynomial
from freebody.motion.planning.planning_limits import PlanningLimits
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import layout

SAMPLES = 401
"""The number of samples of a motion whose step is not given."""
_BESIDE = 5e-4  # of the duration: times nearer to a break are left out; rounding in accelerations
_ROUNDED = 1e-12  # of the fastest rate


def read_times(function: str, given: ArrayLike, count: int) -> Array:
    """The times of waypoints (count,) in s, which must increase."""
    times = as_floats(function, "times", given)
    if times.shape != (count,):
        raise ShapeError(function, "times", times.shape, f"({count},)", "one time a waypoint")
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise FreebodyError(f"{function}: times must be finite and increase; got {times.tolist()}.")
    return times


def sample_times(function: str, breaks: Array, step: float | None) -> Array:
    """Times from the first to the last of breaks (k,), `step` apart, the last two closer where that
    does not fit. A time close to a break is replaced by it, so that rounding leaves no sample on
    the wrong side of a jump."""
    start, end = float(breaks[0]), float(breaks[-1])
    if step is None:
        t = np.linspace(start, end, SAMPLES)
    else:
        if above_zero(function, "step", step, "seconds") > (end - start) / 3.0:
            given, most = compared(step, (end - start) / 3.0)
            raise FreebodyError(
                f"{function}: step is {given} s, expected at most a third of the motion, {most} s."
            )
        count = int(np.ceil((end - start) / step - 1e-6))
        t = np.append(start + step * np.arange(count), end)
    nearest = breaks[np.searchsorted(0.5 * (breaks[1:] + breaks[:-1]), t)]
    return np.where(np.abs(t - nearest) <= NEAR * (end - start), nearest, t)


def times_and_breaks(breaks: Array) -> Array:
    """The breaks with 401 even times from the first to the last of them, without times close to a
    break."""
    even = np.linspace(breaks[0], breaks[-1], SAMPLES)
    nearest = breaks[np.searchsorted(0.5 * (breaks[1:] + breaks[:-1]), even)]
    beside = np.abs(even - nearest) <= _BESIDE * (breaks[-1] - breaks[0])
    return np.union1d(even[~beside], breaks)


def planned(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    words: str,
    limits: PlanningLimits,
    step: float | None,
) -> Motion:
    """The motion along a curve of the positions over time."""
    t = sample_times(function, curve.breaks, step)
    q, qd, qdd = curve(t), curve.derivative()(t), curve.derivative(2)(t)
    qd[np.abs(qd) <= _ROUNDED * np.abs(qd).max()] = 0.0  # else rest would feel dry friction
    notices = limits.allowed.notices
    return Motion(t, q, qd, qdd, words, layout(model), notices, pieces=curve)
