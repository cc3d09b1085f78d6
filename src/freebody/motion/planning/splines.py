"""Splines through waypoints: motions that do not stop on the way."""

from __future__ import annotations

from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.piecewise import Degree, Ends, interpolated
from freebody.motion.planning.planned import read_times
from freebody.motion.planning.planned_joints import PlannedJoints
from freebody.motion.planning.planning_limits import (
    SAME,
    Limit,
    PlanningLimits,
    planning_limits,
    quickest,
)


def spline(
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None = None,
    ends: Ends = "rest",
    *,
    degree: Degree = 5,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion along a spline through waypoints, which does not stop at them.

    Parameters
    ----------
    model
        The robot.
    waypoints : (k, nq), k > 1, rad or m
        As for `quintic`.
    times : (k,), s
        Times of the waypoints; None: in proportion to the way of the slowest joint, as fast as the
        limits allow.
    ends
        "rest", rate zero at both, of degree 5 acceleration too; "natural", acceleration zero (of
        degree 5 the third and fourth derivative); "periodic", the end joined smoothly to the start.
    degree
        5, or 3, which oscillates less between waypoints, but whose acceleration jumps at the ends.
    velocity, acceleration : one number for all joints, or (nv,); rad/s and rad/s², m/s and m/s²
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
        A limit is not kept, between waypoints too: with joint and time.
    """
    if ends not in get_args(Ends):
        raise UnknownNameError("choice", ends, "spline: ends=", get_args(Ends))
    if degree not in get_args(Degree):
        raise FreebodyError(f"spline: degree is {degree}, expected 3 or 5.")
    limits = planning_limits("spline", model, velocity, acceleration)
    joints = PlannedJoints.of("spline", model, waypoints, limits)
    q, own = joints.waypoints, joints.own
    if ends == "periodic" and (len(q) < degree + 1 or (q[0] != q[-1]).any()):
        raise FreebodyError(
            f"spline: a periodic one needs at least {degree + 1} waypoints, the last equal to the "
            f"first."
        )
    given = None if times is None else read_times("spline", times, len(q))
    knots = _proportional(q, own) if given is None else given
    curve = interpolated(knots, q, degree, ends).resting()
    if given is None:
        rate, second = (curve.derivative(order).extremes.size for order in (1, 2))
        factor = quickest("spline", model, rate, second, own, "times")
        curve, knots = curve.scaled(factor), knots / factor
    words = f"a spline of degree {degree} through {len(q)} waypoints"
    return joints.motion(curve, knots, words, step, paced=given is not None)


def _proportional(q: Array, limits: PlanningLimits) -> Array:
    """Times (k,) from 0 on whose differences are proportional to the move of the joint that needs
    longest for it."""
    pace = np.where(np.isfinite(limits.velocity), limits.velocity, np.sqrt(limits.acceleration))
    pace = np.where(np.isfinite(pace), pace, 1.0)
    gaps = (np.abs(np.diff(q, axis=0)) / pace).max(axis=1)
    same = np.abs(np.diff(q, axis=0)).max(axis=1) <= SAME
    if same.any():
        k = int(np.argmax(same))
        raise FreebodyError(
            f"spline: waypoints {k} and {k + 1} are the same; leave one out, or give times."
        )
    return np.concatenate([[0.0], np.cumsum(gaps)])
