"""Waypoints of robots with quaternions: each move turns about one axis, and a free body's origin
goes straight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from freebody.arrays import Array
from freebody.errors import ShapeError
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial, hermite
from freebody.motion.planning.planned import sample_times, times_and_breaks
from freebody.motion.planning.planning_limits import PlanningLimits, refuse_beyond
from freebody.trees.position_rates import (
    CoordinateLayout,
    layout,
    normalised,
    position_acceleration,
    position_rate,
    state_of,
)
from freebody.trees.public_calls import check_quaternions, finite_vector


@dataclass(frozen=True, eq=False)
class TurningWaypoints:
    """q: (k, nv): plain positions, a free body's origin in world axes, and the angles turned so far
    about the axes of the moves, in body axes. start: (k, nq) as given."""

    q: Array
    given: Array

    def groups(self, where: CoordinateLayout) -> list[range]:
        """Columns of q that move in proportion."""
        found = [range(iv.start, iv.stop) for _, iv in where.turns]
        return found + [range(iv.start, iv.stop) for _, _, iv, _ in where.shifts]


def turning_waypoints(
    function: str, model: Model, given: Any, limits: PlanningLimits, one: str = ""
) -> TurningWaypoints:
    """Of waypoints (k, nq), k > 1. Raises FreebodyError."""
    where = layout(model)
    q = finite_vector(function, model, one or "waypoints", given)
    if q.ndim != 2 or len(q) < 2:
        name, shape = (one, q.shape[1:]) if one else ("waypoints", q.shape)
        rows = "" if one else "k, "
        raise ShapeError(function, name, shape, f"({rows}{model.nq})", "two rows at least")
    check_quaternions(function, model, q)
    q = normalised(where, q)
    iq, iv = where.plain
    refuse_beyond(function, model, q[:, iq], iv.tolist(), limits, one)
    found = np.empty((len(q), model.nv))
    found[:, iv] = q[:, iq]
    for ix, _, ivx, _ in where.shifts:
        found[:, ivx] = q[:, ix]
    for iw, ivw in where.turns:
        turns = Rotation.from_quat(q[:, iw], scalar_first=True)
        found[0, ivw] = 0.0
        found[1:, ivw] = np.cumsum((turns[:-1].inv() * turns[1:]).as_rotvec(), axis=0)
    return TurningWaypoints(found, q)


def along_turns(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    marks: Array,
    waypoints: TurningWaypoints,
    words: str,
    step: float | None,
) -> Motion:
    """The motion of coordinates as in `TurningWaypoints` that follow a curve (nv,) over time and
    pass the waypoints at the times `marks` (k,).

    Exact at 401 times and where the curve's polynomials meet, quintic between.
    """
    where, knots = layout(model), times_and_breaks(curve.breaks)
    value, rate, second = curve, curve.derivative(), curve.derivative(2)
    v, later, before = rate(knots), second(knots), second.before(knots)
    x = np.empty((len(knots), model.nq))
    x[:, where.plain[0]] = value(knots)[:, where.plain[1]]
    move = np.clip(np.searchsorted(marks, knots, side="right") - 1, 0, len(marks) - 2)
    for iq, iv in where.turns:
        turned = Rotation.from_rotvec(value(knots)[:, iv] - waypoints.q[move, iv])
        start = Rotation.from_quat(waypoints.given[move, iq], scalar_first=True)
        x[:, iq] = _continuous((start * turned).as_quat(scalar_first=True))
    for ix, _, iv, _ in where.shifts:
        x[:, ix] = value(knots)[:, iv]
    speed = position_rate(where, x, v)
    found = [position_acceleration(where, x, v, a) for a in (later, before)]
    for ix, _, iv, _ in where.shifts:  # of the origin in world axes
        speed[:, ix], found[0][:, ix], found[1][:, ix] = v[:, iv], later[:, iv], before[:, iv]
    pieces = hermite(knots, x, speed, *found)
    t = sample_times(function, curve.breaks, step)
    states = state_of(where, *(pieces.derivative(k)(t) if k else pieces(t) for k in range(3)))
    return Motion(t, *states, words, where, pieces=pieces)


def _continuous(quaternions: Array) -> Array:
    flips = np.cumsum(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0) % 2 == 1
    return np.where(np.append(False, flips)[:, None], -quaternions, quaternions)
