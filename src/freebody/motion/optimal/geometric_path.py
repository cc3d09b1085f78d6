"""Paths without timing: curves q(s) through positions, their derivatives at many points by one
kernel, grids over them, and the motion along a path at a known speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from freebody.algorithms import path_timing
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.errors import FreebodyError
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.optimal.speed_profile import timed_pieces
from freebody.motion.piecewise import PiecewisePolynomial, interpolated
from freebody.motion.planning.planning_limits import SLACK, PlanningLimits, checked_waypoints
from freebody.motion.planning.through_loops import driven_waypoints, through_loops
from freebody.motion.ranges import Flags, position_columns
from freebody.outputs.number_text import compared
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program, result_memory
from freebody.trees.position_rates import layout

_SAME = 1e-9  # of the length of a path: positions nearer to each other are one
_PARTS = 11  # into which the first and the last interval of a grid are divided
_WAY = (np.arange(1, _PARTS) / _PARTS) ** 2


class PathSamples(NamedTuple):
    """Samples of P paths at points s (T, P). orders: q and its derivatives by s (T, P, nv), as many
    as are not 0 in some path, at least two."""

    s: Array
    orders: tuple[Array, ...]

    @property
    def q(self) -> Array:
        """Positions along the paths (T, P, nv)."""
        return self.orders[0]

    @property
    def first(self) -> Array:
        """First derivatives q' (T, P, nv)."""
        return self.orders[1]

    @property
    def second(self) -> Array:
        """Second derivatives q'' (T, P, nv)."""
        return self.orders[2]

    def part(self, points: slice) -> PathSamples:
        """The samples at some of the points."""
        return PathSamples(self.s[points], tuple(x[points] for x in self.orders))

    def only(self, paths: Flags) -> PathSamples:
        """The samples of the chosen paths alone."""
        return PathSamples(self.s[:, paths], tuple(x[:, paths] for x in self.orders))


def sampled(curves: Sequence[PiecewisePolynomial], s: Array) -> PathSamples:
    """Samples of each path at its own points s (T, P)."""
    n = curves[0].coefficients.shape[-1]
    highest = max(len(curve.coefficients) for curve in curves) - 1
    kernel = _values(n, highest)
    orders = tuple(result_memory.empty((*s.shape, n)) for _ in kernel.program.outputs)
    own = result_memory.empty((len(s), highest + 1, n))
    for k, curve in enumerate(curves):
        powers = np.zeros((len(curve.breaks) - 1, highest + 1, n))
        powers[:, highest + 1 - len(curve.coefficients) :] = curve.coefficients.swapaxes(0, 1)
        piece = np.searchsorted(curve.breaks[1:-1], s[:, k], side="right")
        beyond = s[:, k] - curve.breaks.take(piece)
        powers.take(piece, axis=0, out=own, mode="clip")  # other modes make a copy of `own`
        kernel(own, beyond, out=tuple(x[:, k] for x in orders))
    return PathSamples(s, orders)


@lru_cache(maxsize=8)
def _values(n: int, degree: int) -> Kernel:
    """The kernel of `path_timing.curve_values` for n coordinates and polynomials of a degree."""

    def values(powers: Scalar, beyond: Scalar) -> tuple[Scalar, ...]:
        return tuple(path_timing.curve_values(powers, beyond))

    inputs = [Argument("powers", (degree + 1, n)), Argument("beyond", ())]
    outputs = [Argument(f"d{k}", (n,)) for k in range(max(degree, 2) + 1)]
    return compile_program(trace("path_values", values, inputs, outputs))


def path_curve(
    function: str, model: Model, given: Any, limits: PlanningLimits, name: str = "path"
) -> PiecewisePolynomial:
    """The curve of one path: a piecewise polynomial as it is; for waypoints (k, nq) or a motion's
    positions the natural cubic spline over the distance s along the chords, 1 in all. For a closed
    chain the curve of all joints, led by the driven ones."""
    if isinstance(given, PPoly) and model.loops:
        raise FreebodyError(
            f"{function}: {_label(name)} is a PPoly, and the positions of {model.name!r}, a closed "
            f"chain, must satisfy its loops; give waypoints of the driven joints, or a motion."
        )
    if isinstance(given, PPoly):
        return _of_scipy(function, model, given, _label(name))
    positions = given.q if isinstance(given, Motion) else given
    if model.loops:
        return _led(function, model, positions, limits, name)
    q = checked_waypoints(function, model, positions, limits, name=name)
    return _along_chords(function, q, name)


def _led(
    function: str, model: Model, positions: Any, limits: PlanningLimits, name: str
) -> PiecewisePolynomial:
    """The curve of a closed chain's joints, which its driven joints lead."""
    if model.nq != model.nv:
        raise FreebodyError(
            f"{function}: {model.name!r} has joints whose positions are quaternions, for which "
            f"this is not available."
        )
    waypoints = driven_waypoints(function, model, positions, limits)
    curve = _along_chords(function, waypoints.q, name)
    motion = through_loops(function, model, curve, waypoints, name, None, "s = {:.4g}")
    assert motion.pieces is not None
    return motion.pieces


def _along_chords(function: str, q: Array, name: str) -> PiecewisePolynomial:
    """The natural cubic spline through positions (k, n)."""
    length = np.linalg.norm(np.diff(q, axis=0), axis=1)
    moves = length > _SAME * length.sum()
    if not moves.any():
        raise FreebodyError(
            f"{function}: {_label(name)} has {len(q)} positions, all the same; give at least two."
        )
    points = q[np.concatenate([[True], moves])]
    s = np.concatenate([[0.0], np.cumsum(length[moves])]) / length[moves].sum()
    s[-1] = 1.0
    return interpolated(s, points, 3, "natural").resting()


def _label(name: str) -> str:
    return "the path" if name == "path" else name


def _of_scipy(function: str, model: Model, given: PPoly, label: str) -> PiecewisePolynomial:
    breaks, coefficients = np.array(given.x), np.array(given.c)
    if coefficients.shape[2:] != (model.nq,):
        raise FreebodyError(
            f"{function}: {label} has values of shape {coefficients.shape[2:]}, expected "
            f"({model.nq},): model {model.name!r} has nq = {model.nq}."
        )
    if not (np.isfinite(coefficients).all() and np.isfinite(breaks).all()):
        raise FreebodyError(f"{function}: {label} has a coefficient that is not finite.")
    if not (np.diff(breaks) > 0.0).all():
        raise FreebodyError(f"{function}: the breaks of {label} must increase.")
    curve = PiecewisePolynomial(breaks, coefficients)
    _refuse_jump(function, model, curve, label, "itself")
    _refuse_jump(function, model, curve.derivative(), label, "its first derivative")
    if not coefficients[:-1].any():
        raise FreebodyError(f"{function}: {label} does not move: all its derivatives are 0.")
    return curve.resting()


def _refuse_jump(
    function: str, model: Model, curve: PiecewisePolynomial, label: str, what: str
) -> None:
    """Refuse a path with a jump in its positions or slopes, along which nothing can move."""
    starts = curve.coefficients[-1]
    gap = np.abs(starts[1:] - curve.at_ends[:-1])
    if gap.size and gap.max() > 1e-6 * (1e-6 + np.abs(starts).max()):
        k, j = np.unravel_index(np.argmax(gap), gap.shape)
        raise FreebodyError(
            f"{function}: {label} jumps at s = {curve.breaks[k + 1]:.6g}: {what} of "
            f"{model.position_names[j]} by {gap[k, j]:.3g}; it must be continuous, and its first "
            f"derivative too."
        )


def refuse_out_of_range(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    samples: PathSamples,
    path: int,
    limits: PlanningLimits,
    label: str,
) -> None:
    """Refuse a path that leaves the range of a joint, between its waypoints and samples too."""
    iq, iv = position_columns(model)
    low, high = limits.allowed.lower[iv], limits.allowed.upper[iv]
    q, step = samples.q[:, path], np.diff(samples.s[:, path]).max()
    beyond = 0.25 * step**2 * np.abs(samples.second[:, path]).max()  # what lies between samples
    least, most = q.min(axis=0)[iq] - beyond, q.max(axis=0)[iq] + beyond
    if (least >= low).all() and (most <= high).all():
        return
    of = curve.extremes
    for way, value, limit, s in (
        (-1.0, of.low[iq], low, of.low_at[iq]),
        (1.0, of.high[iq], high, of.high_at[iq]),
    ):
        for k in np.flatnonzero(way * (value - limit) > SLACK * np.maximum(1.0, np.abs(value))):
            there, least, most = compared(value[k], low[k], high[k], digits=5)
            raise FreebodyError(
                f"{function}: at s = {s[k]:.4g} of {label} {model.velocity_names[iv[k]]} is at "
                f"{there}, outside its range from {least} to {most}; move the path, or give more "
                f"waypoints."
            )


def grid(curve: PiecewisePolynomial, intervals: int) -> Array:
    """Points of s that include all breaks and are even in each piece; there are at least as many
    intervals as pieces.

    The first and the last interval are divided into `_PARTS`, which take equal times of constant
    acceleration from rest: (intervals + 2 `_PARTS` - 1,) in all. On the way from rest one interval
    could otherwise last as long as many others together.
    """
    breaks = curve.breaks
    count = len(breaks) - 1
    place = (breaks - breaks[0]) / (breaks[-1] - breaks[0]) * intervals
    index = np.arange(count + 1)
    at = np.maximum.accumulate(np.rint(place) - index) + index  # one interval each at least
    at = np.minimum(at, intervals - count + index)
    even = np.interp(np.arange(intervals + 1), at, breaks)
    start, end = even[0] + _WAY * (even[1] - even[0]), even[-1] - _WAY * (even[-1] - even[-2])
    if intervals == 1:
        return np.sort(np.concatenate([even, start, end]))
    return np.concatenate([even[:1], start, even[1:-1], end[::-1], even[-1:]])


def motions_along(
    model: Model,
    at: PathSamples,
    x: Array,
    source: str,
) -> Iterator[Motion]:
    """The exact motions of paths with ṡ² = x (N + 1, P) at the grid, 0 at its end, and s̈ constant
    between: q(t) are polynomials of twice the curve's degree."""
    h = 2.0 * np.diff(at.s, axis=0)
    polynomials, durations = timed_pieces([order[:-1] for order in at.orders], x, h)
    braking = at.first[-1] * ((x[-1] - x[-2]) / h[-1])[:, None]  # at the end, at rest
    for k, powers in enumerate(polynomials):
        t = np.zeros(len(x))
        np.add.accumulate(durations[:, k], out=t[1:])
        qd = np.concatenate([powers[-2], np.zeros_like(braking[k : k + 1])])
        qdd = np.concatenate([2.0 * powers[-3], braking[k : k + 1]])
        for array in (t, qd, qdd):
            array.flags.writeable = False  # else a motion copies it
        pieces = PiecewisePolynomial(t, powers)
        yield Motion(t, at.q[:, k], qd, qdd, source, layout(model), pieces=pieces)
