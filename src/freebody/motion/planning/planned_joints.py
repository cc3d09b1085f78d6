"""What a planner moves: all joints of an open chain, the driven ones of a closed chain, whose loops
lead the others."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from freebody.arrays import Array
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial
from freebody.motion.planning.driven_waypoints import DrivenWaypoints, driven_waypoints
from freebody.motion.planning.planned import planned
from freebody.motion.planning.planning_limits import (
    SLACK,
    PlanningLimits,
    checked_waypoints,
    slowed,
    within_limits,
)
from freebody.motion.planning.through_loops import through_loops


@dataclass(frozen=True, eq=False)
class PlannedJoints:
    """Joints with the waypoints (k, n) that they shall pass; of a closed chain `driven` has those
    of all its coordinates. limits: of all coordinates."""

    function: str
    model: Model
    limits: PlanningLimits
    waypoints: Array
    driven: DrivenWaypoints | None

    @staticmethod
    def of(
        function: str, model: Model, given: Any, limits: PlanningLimits, one: str = ""
    ) -> PlannedJoints:
        """Of waypoints as a user gives them; `one`: of one position, where they are the same."""
        model.require_values("a motion")
        if not model.loops:
            q = checked_waypoints(function, model, given, limits, one)
            return PlannedJoints(function, model, limits, q, None)
        driven = driven_waypoints(function, model, given, limits, one)
        return PlannedJoints(function, model, limits, driven.q, driven)

    @property
    def names(self) -> tuple[str, ...]:
        """(n,)."""
        return self.model.position_names if self.driven is None else self.model.driven_names

    @cached_property
    def own(self) -> PlanningLimits:
        """The limits of rates of these joints, (n,) each."""
        if self.driven is None:
            return self.limits
        k = list(self.model.driven)
        rates = ("velocity", "acceleration", "jerk", "torque")
        return replace(self.limits, **{name: getattr(self.limits, name)[k] for name in rates})

    def motion(
        self, curve: PiecewisePolynomial, words: str, step: float | None, paced: bool
    ) -> Motion:
        """The motion in which they follow a curve (n,) over time; refused where a limit of some
        joint is not kept. paced: at given times, else slower where a led joint asks for it."""
        if self.driven is None:
            motion = planned(self.function, self.model, curve, words, self.limits, step)
            return within_limits(self.function, self.model, motion, self.limits)
        motion = through_loops(self.function, self.model, curve, self.driven, words, step)
        factor = 1.0 if paced else slowed(motion, self.limits)
        if factor < 1.0 - 0.45 * SLACK:  # the square of it is within the slack of limits
            slower = curve.scaled(factor)
            motion = through_loops(self.function, self.model, slower, self.driven, words, step)
        motion = replace(motion, notices=self.limits.allowed.notices)
        return within_limits(self.function, self.model, motion, self.limits)
