"""The planners of joint motions by name, each with the limits that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from freebody.motion.motion import Motion
from freebody.motion.optimal.time_optimal import time_optimal_through
from freebody.motion.planning.point_to_point import quintic, s_curve, trapezoid
from freebody.motion.planning.splines import spline


@dataclass(frozen=True)
class Planner:
    """plan: model, waypoints, times and by keyword `limits` and a step -> Motion."""

    plan: Callable[..., Motion]
    limits: tuple[str, ...]


PLANNERS = {
    "spline": Planner(spline, ("velocity", "acceleration")),
    "quintic": Planner(quintic, ("velocity", "acceleration", "jerk")),
    "trapezoid": Planner(trapezoid, ("velocity", "acceleration")),
    "s-curve": Planner(s_curve, ("velocity", "acceleration", "jerk")),
    "time-optimal": Planner(time_optimal_through, ("velocity", "acceleration", "torque")),
}
"""By name; the first is the command's default."""
