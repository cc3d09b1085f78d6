"""The joints that a planner moves: all of an open chain, the driven ones of a closed chain, whose
loops move the others; with quaternions each move turns about one axis, and a free body's origin
moves straight."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from freebody.arrays import Array
from freebody.errors import FreebodyError, ShapeError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial, hermite
from freebody.motion.planning.planned import planned, sample_times, times_and_breaks
from freebody.motion.planning.planning_limits import (
    SAME,
    SLACK,
    PlanningLimits,
    checked_waypoints,
    refuse_beyond,
    slowed,
    within_limits,
)
from freebody.motion.planning.through_loops import DrivenWaypoints, driven_waypoints, through_loops
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
class PlannedJoints:
    """Coordinates with the waypoints (k, n) that they shall pass. driven: the waypoints of all
    coordinates of a closed chain; turning: the meaning of the coordinates of a robot with
    quaternions; limits: those of all coordinates."""

    function: str
    model: Model
    limits: PlanningLimits
    waypoints: Array
    driven: DrivenWaypoints | None = None
    turning: TurningWaypoints | None = None

    @staticmethod
    def of(
        function: str,
        model: Model,
        given: Any,
        limits: PlanningLimits,
        one: str = "",
        straight: bool = False,
    ) -> PlannedJoints:
        """The joints of waypoints as a user gives them; one: whether a single position is enough;
        straight: whether the planner moves straight between waypoints, as quaternions require."""
        model.require_values("a motion")
        if model.loops:
            driven = driven_waypoints(function, model, given, limits, one)
            return PlannedJoints(function, model, limits, driven.q, driven=driven)
        if model.nq != model.nv and straight:
            turning = _turning_waypoints(function, model, given, limits, one)
            _refuse_twisting(function, model, turning.q)
            return PlannedJoints(function, model, limits, turning.q, turning=turning)
        q = checked_waypoints(function, model, given, limits, one)
        _refuse_twisting(function, model, q)
        return PlannedJoints(function, model, limits, q)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates (n,)."""
        return self.model.velocity_names if self.driven is None else self.model.driven_names

    @cached_property
    def together(self) -> dict[int, range]:
        """For each coordinate that moves in proportion with others, the range of these
        coordinates."""
        groups = [] if self.turning is None else self.turning.groups(layout(self.model))
        return {k: group for group in groups for k in group}

    @cached_property
    def own(self) -> PlanningLimits:
        """The limits of rates of the planned coordinates, (n,) each."""
        if self.driven is None:
            return self.limits
        k = list(self.model.driven)
        rates = ("velocity", "acceleration", "jerk", "torque")
        return replace(self.limits, **{name: getattr(self.limits, name)[k] for name in rates})

    def motion(
        self,
        curve: PiecewisePolynomial,
        marks: Array,
        words: str,
        step: float | None,
        paced: bool,
    ) -> Motion:
        """The motion that follows a curve (n,) over time and passes the waypoints at times `marks`
        (k,); refused where a joint's limit is exceeded. paced: at given times, else slowed down
        where a joint moved by the loops requires it."""
        motion = self._along(curve, marks, words, step)
        if not paced and (self.driven or self.turning):
            factor = slowed(motion, self.limits)
            if factor < 1.0 - 0.45 * SLACK:  # the square of it is within the slack of limits
                motion = self._along(curve.scaled(factor), marks / factor, words, step)
        motion = replace(motion, notices=self.limits.allowed.notices)
        return within_limits(self.function, self.model, motion, self.limits)

    def _along(
        self, curve: PiecewisePolynomial, marks: Array, words: str, step: float | None
    ) -> Motion:
        if self.driven is not None:
            return through_loops(self.function, self.model, curve, self.driven, words, step)
        if self.turning is not None:
            return _along_turns(self.function, self.model, curve, marks, self.turning, words, step)
        return planned(self.function, self.model, curve, words, self.limits, step)


def _refuse_twisting(function: str, model: Model, q: Array) -> None:
    """Refuse waypoints (k, nv) between which the shaft of a flexible joint twists."""
    for k in shaft_entries(model):
        away = np.abs(q[:, k] - q[0, k])
        if away.max() > SAME:
            there = int(np.argmax(away))
            raise FreebodyError(
                f"{function}: from waypoint 0 to {there} {model.velocity_names[k]} goes from "
                f"{q[0, k]:g} to {q[there, k]:g}; it is a shaft, which twists by what it carries "
                f"and by no plan: give it the same twist in all, such as 0."
            )


@dataclass(frozen=True, eq=False)
class TurningWaypoints:
    """Waypoints of a robot with quaternions as plain coordinates q (k, nv): positions, a free
    body's origin in world axes, and accumulated angles about the axes of the moves, in body axes.
    given: (k, nq) as given."""

    q: Array
    given: Array

    def groups(self, where: CoordinateLayout) -> list[range]:
        """Ranges of columns of q that move in proportion."""
        found = [range(iv.start, iv.stop) for _, iv in where.turns]
        return found + [range(iv.start, iv.stop) for _, _, iv, _ in where.shifts]


def _turning_waypoints(
    function: str, model: Model, given: Any, limits: PlanningLimits, one: str = ""
) -> TurningWaypoints:
    """Waypoints (k, nq), k > 1, as plain coordinates, between which each move turns about one axis.
    Raises FreebodyError."""
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


def _along_turns(
    function: str,
    model: Model,
    curve: PiecewisePolynomial,
    marks: Array,
    waypoints: TurningWaypoints,
    words: str,
    step: float | None,
) -> Motion:
    """The motion of coordinates as in `TurningWaypoints` that follow a curve (nv,) over time and
    pass the waypoints at times `marks` (k,).

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
