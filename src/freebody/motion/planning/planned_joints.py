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
from freebody.motion.planning.turning_waypoints import (
    TurningWaypoints,
    along_turns,
    turning_waypoints,
)
from freebody.trees.position_rates import layout


@dataclass(frozen=True, eq=False)
class PlannedJoints:
    """Coordinates with the waypoints (k, n) that they shall pass; of a closed chain `driven` has
    those of all its coordinates, of a robot with quaternions `turning` says what they are. limits:
    of all coordinates."""

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
        """Of waypoints as a user gives them; `one`: of one position, where they are the same;
        straight: the planner moves straight from each to the next, as quaternions can."""
        model.require_values("a motion")
        if model.loops:
            driven = driven_waypoints(function, model, given, limits, one)
            return PlannedJoints(function, model, limits, driven.q, driven=driven)
        if model.nq != model.nv and straight:
            turning = turning_waypoints(function, model, given, limits, one)
            return PlannedJoints(function, model, limits, turning.q, turning=turning)
        q = checked_waypoints(function, model, given, limits, one)
        return PlannedJoints(function, model, limits, q)

    @property
    def names(self) -> tuple[str, ...]:
        """(n,)."""
        return self.model.velocity_names if self.driven is None else self.model.driven_names

    @cached_property
    def together(self) -> dict[int, range]:
        """Coordinates that move in proportion: of each of them, which."""
        groups = [] if self.turning is None else self.turning.groups(layout(self.model))
        return {k: group for group in groups for k in group}

    @cached_property
    def own(self) -> PlanningLimits:
        """The limits of rates of these coordinates, (n,) each."""
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
        """The motion in which they follow a curve (n,) over time, past the waypoints at times
        `marks` (k,); refused where a limit of some joint is not kept. paced: at given times, else
        slower where a joint that is led asks for it."""
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
            return along_turns(self.function, self.model, curve, marks, self.turning, words, step)
        return planned(self.function, self.model, curve, words, self.limits, step)
