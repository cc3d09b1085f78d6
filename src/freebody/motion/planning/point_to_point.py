"""Motions that stop at each of their waypoints: quintic, trapezoid, s_curve; and dwell.

The quickest curve from rest to rest under limits, of each family. Trapezoid: constant acceleration,
constant speed, constant deceleration; without the middle where the way is short. S-curve: constant
jerk, in up to seven phases (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines
and Robots, 2008, section 3.4). Quintic: rate and acceleration zero at both ends, jerk least in the
mean square (Flash and Hogan 1985).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import factorial, sqrt

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero
from freebody.errors import FreebodyError
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial, side_by_side
from freebody.motion.planning.planned import read_times
from freebody.motion.planning.planned_joints import PlannedJoints
from freebody.motion.planning.planning_limits import (
    SAME,
    Limit,
    PlanningLimits,
    pace_unknown,
    planning_limits,
)
from freebody.outputs.number_text import compared, rounded_up
from freebody.trees.public_calls import JointVector

_LIMITS = ("velocity", "acceleration", "jerk")


def quintic(
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None = None,
    *,
    velocity: Limit = None,
    acceleration: Limit = None,
    jerk: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion in straight lines of joint space between waypoints, at rest in each, by
    polynomials of degree 5.

    With quaternions each move turns about one axis; the origin of a free body moves in a straight
    line. Accelerations are continuous, and zero at the waypoints.

    Parameters
    ----------
    model
        The robot.
    waypoints : (k, nq), k > 1, rad or m
        Of a closed chain positions of its driven joints, (k, number of them), on the branch of its
        home, or closed positions of all.
    times : (k,), s
        Times of the waypoints; None: as fast as the limits allow.
    velocity, acceleration, jerk : one number for all joints, or (nv,); rad/s, rad/s², rad/s³ (m)
        Limits, of a closed chain those of the driven joints; the model's limits of position and
        speed apply too.
    step : s
        Time between samples; None: 1/400 of the motion.

    Returns
    -------
    Motion
        With its exact curve.

    Raises
    ------
    FreebodyError
        A limit is not kept: with joint and time.
    """
    limits = planning_limits("quintic", model, velocity, acceleration, jerk)
    return _stopping("quintic", "quintic", model, waypoints, times, limits, step)


def trapezoid(
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None = None,
    *,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion between waypoints, at rest in each, with constant acceleration, constant speed,
    constant deceleration.

    All joints start and stop together: the slowest moves as quickly as its limits allow, the others
    run their own quickest motion slowed to its duration. The accelerations jump.

    Parameters
    ----------
    acceleration : one number for all joints, or (nv,), rad/s² or m/s²
        Needed, unless the limit of each joint that moves is in it.
    model, waypoints, times, velocity, step
        As in `quintic`, with what it returns and raises.
    """
    limits = planning_limits("trapezoid", model, velocity, acceleration)
    return _stopping("trapezoid", "trapezoid", model, waypoints, times, limits, step)


def s_curve(
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None = None,
    *,
    jerk: Limit = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion between waypoints, at rest in each, with limited jerk: accelerations rise and fall
    in ramps.

    All joints start and stop together: the slowest moves as quickly as its limits allow, the others
    run their own quickest motion slowed to its duration.

    Parameters
    ----------
    jerk : one number for all joints, or (nv,), rad/s³ or m/s³
        Needed.
    model, waypoints, times, velocity, acceleration, step
        As in `quintic`, with what it returns and raises.
    """
    limits = planning_limits("s_curve", model, velocity, acceleration, jerk)
    return _stopping("s_curve", "s-curve", model, waypoints, times, limits, step)


def dwell(model: Model, q: JointVector, duration: float, *, step: float | None = None) -> Motion:
    """A rest of `duration` s at q (nq,), or with the driven joints of a closed chain there, for use
    between other motions: `a.then(pause).then(b)`.

    step: s between samples, by default a tenth of it.
    """
    duration = above_zero("dwell", "duration", duration, "seconds")
    limits, ends = planning_limits("dwell", model), np.array([0.0, duration])
    joints = PlannedJoints.of("dwell", model, [q, q], limits, "q", straight=True)
    still = PiecewisePolynomial(ends, joints.waypoints[None, :1])
    words, tenth = f"at rest for {duration:g} s", 0.1 * duration
    return joints.motion(still, ends, words, tenth if step is None else step, paced=True)


def _stopping(
    function: str,
    name: str,
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None,
    limits: PlanningLimits,
    step: float | None,
) -> Motion:
    joints = PlannedJoints.of(function, model, waypoints, limits, straight=True)
    count = len(joints.waypoints)
    given = None if times is None else read_times(function, times, count)
    whole, marks = None, np.zeros(count)
    for k in range(count - 1):
        wanted = None if given is None else float(given[k + 1] - given[k])
        move = _move(joints, name, k, wanted)
        whole = move if whole is None else whole.then(move)
        marks[k + 1] = whole.breaks[-1]
    assert whole is not None
    if given is not None:
        marks += given[0]
        whole = PiecewisePolynomial(whole.breaks + given[0], whole.coefficients)
    words = f"{PROFILES[name].words} through {count} waypoints, at rest in each"
    return joints.motion(whole, marks, words, step, paced=given is not None)


def _move(joints: PlannedJoints, name: str, k: int, wanted: float | None) -> PiecewisePolynomial:
    """The curve of the k-th move, from one waypoint to the next; wanted: its duration."""
    function, ends = joints.function, joints.waypoints[k : k + 2]
    way = ends[1] - ends[0]
    if not (np.abs(way) > SAME).any():
        raise FreebodyError(
            f"{function}: waypoints {k} and {k + 1} are the same; leave one out, and to wait there "
            f"use fb.dwell."
        )
    curves = _quickest(joints, name, way, wanted)
    slowest = max(curves, key=lambda i: curves[i].breaks[-1])
    shortest = float(curves[slowest].breaks[-1])
    if wanted is not None and wanted < shortest * (1.0 - 1e-9):
        needed, given = compared(float(rounded_up(shortest, 5)), wanted, digits=5)
        raise FreebodyError(
            f"{function}: from waypoint {k} to {k + 1} {joints.names[slowest]} needs "
            f"{needed} s within its limits, times give {given} s."
        )
    duration = shortest if wanted is None else wanted
    columns = []
    for i, start in enumerate(ends[0]):
        others = [k for k in joints.together.get(i, (i,)) if k in curves]
        # what hardly moves goes along
        like = max(others, key=lambda k: curves[k].breaks[-1], default=slowest)
        curve = curves[like].scaled(float(curves[like].breaks[-1]) / duration)
        powers = curve.coefficients * (way[i] / abs(way[like]))
        powers[-1] += start
        columns.append(PiecewisePolynomial(np.append(curve.breaks[:-1], duration), powers))
    return side_by_side(columns)


def _quickest(
    joints: PlannedJoints, name: str, way: Array, wanted: float | None
) -> dict[int, PiecewisePolynomial]:
    """The fastest curve of each joint that moves, by its index, from 0 to the size of its move,
    regardless of the other joints."""
    profile = PROFILES[name]
    curves = {}
    for i in map(int, np.flatnonzero(np.abs(way) > SAME)):
        own = {x: float(getattr(joints.own, x)[i]) for x in _LIMITS}
        missing = [x for x in profile.needs if not np.isfinite(own[x])]
        if missing or not any(map(np.isfinite, own.values())):
            if wanted is None or profile.needs:
                needed = missing or ("times", *_LIMITS)
                raise pace_unknown(joints.function, joints.model, *needed)
            own["velocity"] = 2.0 * abs(way[i]) / wanted  # any: it is run in the wanted duration
        curves[i] = profile.quickest(abs(float(way[i])), *own.values())
    return curves


@dataclass(frozen=True)
class Profile:
    """A family of rest-to-rest curves, such as trapezoids of velocity.

    needs: the limits without which nothing bounds its accelerations, or its jerk. quickest: the
    curve from 0 over a way > 0 under limits of velocity, acceleration, jerk, which may be infinite.
    """

    words: str
    needs: tuple[str, ...]
    quickest: Callable[[float, float, float, float], PiecewisePolynomial]


def _quintic(way: float, velocity: float, acceleration: float, jerk: float) -> PiecewisePolynomial:
    # largest rate 15/8, acceleration 10/√3 and jerk 60 of the way over the duration and its powers
    T = max(
        1.875 * way / velocity,
        sqrt(10.0 / sqrt(3.0) * way / acceleration),
        np.cbrt(60.0 * way / jerk),
    )
    powers = np.array([6.0 / T**5, -15.0 / T**4, 10.0 / T**3, 0.0, 0.0, 0.0])
    return PiecewisePolynomial(np.array([0.0, T]), way * powers[:, None, None])


def _trapezoid(
    way: float, velocity: float, acceleration: float, jerk: float
) -> PiecewisePolynomial:
    a = acceleration
    ramp = min(velocity / a, sqrt(way / a))
    cruise = max(way / (a * ramp) - ramp, 0.0)
    return _phases([(ramp, a), (cruise, 0.0), (ramp, -a)], order=2)


def _s_curve(way: float, velocity: float, acceleration: float, jerk: float) -> PiecewisePolynomial:
    j = jerk
    bend = np.cbrt(way / (2.0 * j))  # as if nothing but the jerk were limited
    v, a = min(velocity, j * bend**2), min(acceleration, j * bend)
    bend = min(a / j, sqrt(v / j))
    a = j * bend
    ramp = min(bend + v / a, 0.5 * bend + sqrt(0.25 * bend**2 + way / a))
    hold = max(ramp - 2.0 * bend, 0.0)
    cruise = max(way / (a * (bend + hold)) - 2.0 * bend - hold, 0.0)
    up = [(bend, j), (hold, 0.0), (bend, -j)]
    down = [(bend, -j), (hold, 0.0), (bend, j)]
    return _phases([*up, (cruise, 0.0), *down], order=3)


PROFILES = {
    "quintic": Profile("polynomials of degree 5", (), _quintic),
    "trapezoid": Profile("trapezoids of speed", ("acceleration",), _trapezoid),
    "s-curve": Profile("curves of limited jerk", ("jerk",), _s_curve),
}
"""The families of curves by name."""


def _phases(phases: Sequence[tuple[float, float]], order: int) -> PiecewisePolynomial:
    """The curve that begins at rest at 0 and has in each phase (duration, value) a constant
    derivative of the given order; phases of no duration are left out."""
    state = np.zeros(order)  # value, first derivative, …
    breaks, pieces = [0.0], []
    for duration, top in phases:
        if duration <= 1e-12 * breaks[-1]:
            continue
        powers = np.append(state, top) / [factorial(k) for k in range(order + 1)]
        p = np.polynomial.Polynomial(powers)
        pieces.append(powers[::-1])
        state = np.array([p.deriv(k)(duration) if k else p(duration) for k in range(order)])
        breaks.append(breaks[-1] + duration)
    return PiecewisePolynomial(np.array(breaks), np.array(pieces).T[:, :, None])
