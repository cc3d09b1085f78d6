"""Motions in which the tip follows a path: line, arc, and blend of several lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from freebody.arrays import Array, above_zero, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, MissingArgumentError, ShapeError, UnknownNameError
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.task import TASKS, Task, read_target, row_names
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.piecewise import PiecewisePolynomial, of_spline
from freebody.motion.planning.planned import SAMPLES, sample_times
from freebody.motion.planning.planned_joints import PlannedJoints
from freebody.motion.planning.planning_limits import (
    Limit,
    PlanningLimits,
    planning_limits,
    quickest,
    within_limits,
)
from freebody.motion.planning.through_loops import DrivenWaypoints, through_loops
from freebody.motion.planning.tip_following import TipFollower
from freebody.motion.planning.tip_mobility import TipPosture
from freebody.motion.planning.tip_paths import TipPath, arc_path, rounded_lines
from freebody.outputs.number_text import compared, rounded_up
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.kinematics import velocity as tip_velocity
from freebody.trees.position_rates import continuous, layout, normalised, state_of
from freebody.trees.public_calls import JointVector
from freebody.trees.states import difference

NEAR = 1e-6
"""m, rad: the tip is nearer to its path than this, between samples too."""
REACHABLE = "reachable"
"""A task: the whole position, and of the orientation what the joints can do."""
_NODES, _DOUBLINGS = 24, 4  # of each stretch of a path
_AGREE = 3e-8  # rad, m: by this joints may be off halfway between nodes, which then are nodes too


def line(
    model: Model,
    q0: JointVector,
    target: ArrayLike,
    duration: float | None = None,
    *,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    speed: float | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion in which a frame moves straight from rest at q0 to a target, to rest, on the
    branch of q0.

    The way over time is a polynomial of degree 5. A redundant arm moves its joints least. With
    fewer joints than the task has rows, as of a SCARA or a delta, the path must ask for nothing
    that they cannot do.

    Parameters
    ----------
    model
        The robot.
    q0 : (nq,), rad or m
        The position at the start; of a closed chain closed, or positions of the driven joints, on
        the branch of its home.
    target : (dim,), m, or (dim + 1, dim + 1), world axes
        A point, or a pose, whose orientation is reached about a fixed axis.
    duration : s
        None: as fast as the limits allow.
    frame
        Name of the frame; None: the tip.
    task
        What counts, as in `inverse_kinematics`, of a point its position; with "pose" a point keeps
        the orientation at q0; "reachable" is the whole position, and of a pose's orientation what
        the joints can do.
    speed : m/s
        Limit of the frame's speed.
    velocity, acceleration : one number for all joints, or (nv,); rad/s and rad/s², m/s and m/s²
        Limits, of a closed chain those of the driven joints; the model's limits of position and
        speed apply too.
    step : s
        Time between samples; None: a 400th of the duration.

    Returns
    -------
    Motion
        The tip stays within 1e-6 m and rad of its path, else `notices` say how far off, and which
        motions of a "reachable" task the joints cannot do.

    Raises
    ------
    FreebodyError
        The path asks for a motion that the joints cannot do, is out of reach, the arm is singular,
        or a joint at its limit: with the place, and in which direction and how much.
    """
    plan = _TipPlan("line", model, q0, frame, task, velocity, acceleration)
    poses = plan.poses(target, 0)
    path = rounded_lines("line", [plan.start, poses], 0.0, plan.solver.length)
    return plan.motion(path, duration, speed, step)


def arc(
    model: Model,
    q0: JointVector,
    via: ArrayLike,
    target: ArrayLike,
    duration: float | None = None,
    *,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    speed: float | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion in which a frame moves from rest at q0 on a circle through a point to a target, to
    rest.

    Parameters
    ----------
    via : (dim,), m, world axes
        A point of the circle between the start and the target.
    model, q0, target, duration, frame, task, speed, velocity, acceleration, step
        As in `line`, with what it returns and raises.
    """
    plan = _TipPlan("arc", model, q0, frame, task, velocity, acceleration)
    point = as_floats("arc", "via", via)
    if point.shape != (model.dim,):
        raise ShapeError("arc", "via", point.shape, f"({model.dim},)", "a point in m")
    refuse_not_finite("arc", "via", point, 1)
    pose = plan.poses(target, 0)
    if not plan.solver.task.places:
        raise FreebodyError("arc: the task must count the whole position.")
    path = arc_path("arc", plan.start, point, pose, plan.solver.length)
    return plan.motion(path, duration, speed, step)


def blend(
    model: Model,
    q0: JointVector,
    targets: ArrayLike,
    radius: float,
    duration: float | None = None,
    *,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    speed: float | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    step: float | None = None,
) -> Motion:
    """The motion in which a frame moves from rest at q0 along lines from target to target without a
    stop, the corners rounded.

    Parameters
    ----------
    targets : (k, dim), m, or (k, dim + 1, dim + 1), world axes
        Points or poses.
    radius : m
        Distance from a corner at which the rounding begins and ends; the path passes the corner at
        up to 3/8 of it.
    model, q0, duration, frame, task, speed, velocity, acceleration, step
        As in `line`, with what it returns and raises.
    """
    plan = _TipPlan("blend", model, q0, frame, task, velocity, acceleration)
    radius = above_zero("blend", "radius", radius, "m")
    poses = plan.poses(targets, 1)
    path = rounded_lines("blend", [plan.start, *poses], radius, plan.solver.length)
    return plan.motion(path, duration, speed, step)


class _TipPlan:
    """The planning of a tip motion: its limits, its start and its task."""

    def __init__(
        self,
        function: str,
        model: Model,
        q0: JointVector,
        frame: str | None,
        task: str | Sequence[str] | None,
        velocity: Limit,
        acceleration: Limit,
    ):
        self.function, self.model = function, model
        self.limits: PlanningLimits = planning_limits(function, model, velocity, acceleration)
        names = (*TASKS, REACHABLE, *row_names(model.dim))
        if isinstance(task, str) and task not in names:
            raise UnknownNameError("task", task, function, names)
        self.nearest = isinstance(task, str) and task == REACHABLE
        self.task = "pose" if self.nearest else task
        joints = PlannedJoints.of(function, model, [q0, q0], self.limits, "q0")
        self.q0 = joints.waypoints[0] if joints.driven is None else joints.driven.start
        self.columns = [model.position_names.index(name) for name in joints.names]
        self.frame = model.frame(frame).name
        self.start = forward_kinematics(model, self.q0, self.frame)

    def poses(self, target: Any, axes: int) -> Array:
        """The target as one pose, or several along `axes` axes; the task is settled on the way."""
        model, d = self.model, self.model.dim
        given = as_floats(self.function, "target", target)
        point = given.shape[-1:] == (d,) and given.shape[-2:] != (d + 1, d + 1)
        if point and self.task is not None:
            whole = np.broadcast_to(self.start, (*given.shape[:-1], d + 1, d + 1)).copy()
            whole[..., :d, d] = given
            given = whole
        task, poses = read_target(self.function, model, given, self.task)
        if poses.ndim != 2 + axes or not poses.size:
            wanted = f"{'(k, ' if axes else '('}{d}) or {'(k, ' if axes else '('}{d + 1}, {d + 1})"
            name = "targets" if axes else "target"
            raise ShapeError(self.function, name, given.shape, wanted, "points or poses")
        self.start = self.start.copy()
        if not task.angular:
            self.start[:d, :d] = np.eye(d)
            poses[..., :d, :d] = np.eye(d)
        free = [row for row in range(d) if row not in task.linear]
        poses[..., free, d] = self.start[free, d]
        self.solver = NumericalSolver(model, self.frame, Task(d, task.rows))
        return poses

    def motion(
        self, path: TipPath, duration: float | None, speed: float | None, step: float | None
    ) -> Motion:
        """The motion along a path from rest to rest."""
        if duration is not None:
            duration = above_zero(self.function, "duration", duration, "seconds")
        if speed is not None:
            speed = above_zero(self.function, "speed", speed, "m/s")
        curve = self._followed(path)
        for doubling in range(_DOUBLINGS + 1):
            found = self._along(curve, duration, speed, step, (SAMPLES - 1) * 2**doubling + 1)
            off = self._off(found, path)
            if off <= NEAR:
                break
        text = "" if off <= NEAR else (
            f"The tip leaves its path by up to {off:.2g} between samples; a smaller step follows "
            f"it more closely."
        )  # fmt: skip
        return replace(found, notices=(*found.notices, *([text] if text else [])))

    def _along(
        self,
        curve: _JointCurve,
        duration: float | None,
        speed: float | None,
        step: float | None,
        samples: int,
    ) -> Motion:
        unit = curve.motion(1.0, np.linspace(0.0, 1.0, samples))
        T = self._duration(unit, duration, speed)
        t = unit.t * T if step is None else sample_times(self.function, np.array([0.0, T]), step)
        return within_limits(self.function, self.model, curve.motion(T, t), self.limits)

    def _followed(self, path: TipPath) -> _JointCurve:
        """The joints' curve along a path, on the branch of q0."""
        follower = TipFollower(self.function, self.solver, path, self.q0, self.nearest)
        ways = _nodes(path.marks, _NODES)
        found, where = follower.along(ways), layout(self.model)
        for doubling in range(_DOUBLINGS):
            guess = _spline(path.marks, ways, continuous(where, _positions(found)))
            halfway = normalised(where, guess(0.5 * (ways[1:] + ways[:-1])))
            between = follower.between(found, ways, halfway)
            off = np.abs(difference(self.model, halfway, _positions(between))).max()
            ways = _nodes(path.marks, _NODES * 2 ** (doubling + 1))
            found = [*(at for pair in zip(found, between, strict=False) for at in pair), found[-1]]
            if off <= _AGREE:
                break
        notices = follower.notices(found, ways)
        curve = _spline(path.marks, ways, _positions(found)[:, self.columns]).resting()
        words = f"the tip along {path.words}"
        if self.model.loops:
            ends = DrivenWaypoints(curve(curve.breaks[[0, -1]]), self.q0, None)
            when = "a way of {:.4g} m"
            motion = through_loops(self.function, self.model, curve, ends, words, None, when)
            assert motion.pieces is not None
            curve, words = motion.pieces.resting(), motion.source
        return _JointCurve(self.model, path, curve, words, (*self.limits.allowed.notices, *notices))

    def _duration(self, unit: Motion, duration: float | None, speed: float | None) -> float:
        """The duration: the given one, else the shortest within the limits, from a motion that
        takes 1 s; refuses one in which the tip is too fast."""
        allowed = np.inf if speed is None else speed / self._fastest(unit)
        if duration is not None:
            if allowed < 1.0 / duration:
                given, needed = compared(duration, float(rounded_up(1.0 / allowed, 5)), digits=5)
                raise FreebodyError(
                    f"{self.function}: in {given} s the tip is faster than {speed:g} m/s; give at "
                    f"least {needed} s."
                )
            return duration
        sizes = unit.peaks.velocity.size, unit.peaks.acceleration.size
        try:
            by_joints = quickest(
                self.function, self.model, *sizes, self.limits, "duration", "speed"
            )
        except MissingArgumentError:
            if speed is None:
                raise
            by_joints = np.inf  # nothing else limits it
        return 1.0 / min(allowed, by_joints)

    def _fastest(self, motion: Motion) -> float:
        """The largest speed of the frame, m/s."""
        V = tip_velocity(self.model, motion.q, motion.qd, self.frame)
        return float(np.linalg.norm(V[:, : self.model.dim], axis=-1).max())

    def _off(self, motion: Motion, path: TipPath) -> float:
        """The largest distance of the tip from its path halfway between samples, in m or rad."""
        t = 0.5 * (motion.t[1:] + motion.t[:-1])
        goal = path.at(np.clip(_way(path.length, motion.duration, t)[0], 0.0, path.length))
        task = self.solver.task
        kept = Task(task.dim, task.linear) if self.nearest else task
        return float(kept.miss(self.solver.pose_and_jacobian(motion.at(t)[0])[0], goal).max())


@dataclass(frozen=True, eq=False)
class _JointCurve:
    """The joint positions over the path length of the tip (m, or rad where it only turns)."""

    model: Model
    path: TipPath
    curve: PiecewisePolynomial
    words: str
    notices: tuple[str, ...]

    def motion(self, T: float, t: Array) -> Motion:
        """The motion along the path from rest to rest in T seconds, with samples at times t."""
        s, sd, sdd = (x[:, None] for x in _way(self.path.length, T, t))
        curves = self.curve, self.curve.derivative(), self.curve.derivative(2)
        x, slope, bend = (curve(s[:, 0]) for curve in curves)
        where = layout(self.model)
        states = state_of(where, x, slope * sd, bend * sd**2 + slope * sdd)
        return Motion(t, *states, self.words, where, self.notices)


def _nodes(marks: Array, count: int) -> Array:
    """Path lengths from mark to mark, with `count` steps in each stretch."""
    steps = [np.linspace(a, b, count + 1)[:-1] for a, b in pairwise(marks)]
    return np.append(np.concatenate(steps), marks[-1])


def _positions(found: Sequence[TipPosture]) -> Array:
    return np.array([at.q for at in found])


def _spline(marks: Array, ways: Array, x: Array) -> PiecewisePolynomial:
    """The spline of degree 5 through x (N, n) at path lengths `ways` (N,); its third derivative may
    jump at the marks."""
    stretches = np.split(ways[:-1], len(marks) - 1)
    # every way but those beside ends is a knot
    inner = [np.concatenate([np.repeat(x[0], 3), x[2:-1]]) for x in stretches]
    own = np.concatenate([inner[0][4:], *inner[1:]])[:-1]
    knots = np.concatenate([np.repeat(marks[0], 6), own, np.repeat(marks[-1], 6)])
    return of_spline(make_interp_spline(ways, x, k=5, t=knots))


def _way(length: float, T: float, t: Array) -> tuple[Array, Array, Array]:
    """The path length over time from rest to rest in T seconds, and its first two derivatives."""
    x = t / T
    s = length * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    sd = length / T * 30.0 * x**2 * (1.0 - x) ** 2
    sdd = length / T**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
    return s, sd, sdd
