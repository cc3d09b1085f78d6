"""The planners of joint motions by name: a module of its own, since the planners' folders do not
know each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from freebody.motion.motion import Motion
from freebody.motion.optimal.time_optimal import time_optimal_through
from freebody.motion.planning.point_to_point import quintic, s_curve, trapezoid
from freebody.motion.planning.splines import spline


@dataclass(frozen=True)
class JointPlanner:
    """A planner, plan(model, waypoints, times, *, step, and limits by keyword) -> Motion, and the
    names of the limits that it takes."""

    plan: Callable[..., Motion]
    limits: tuple[str, ...]


PLANNERS = {
    "spline": JointPlanner(spline, ("velocity", "acceleration")),
    "quintic": JointPlanner(quintic, ("velocity", "acceleration", "jerk")),
    "trapezoid": JointPlanner(trapezoid, ("velocity", "acceleration")),
    "s-curve": JointPlanner(s_curve, ("velocity", "acceleration", "jerk")),
    "time-optimal": JointPlanner(time_optimal_through, ("velocity", "acceleration", "torque")),
}
"""The planners by name; the first is the command's default."""
