"""The fastest motion along a path that a robot's speeds, accelerations and torques allow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly

from freebody.any_chain.effort_limits import followers
from freebody.arrays import Array, as_floats, is_count, refuse_not_finite
from freebody.errors import FreebodyError, listed, shown
from freebody.labels import is_labelled
from freebody.model.doubt_rules.aspects import DYNAMIC, EFFORTS, SPEEDS
from freebody.model.doubts import Doubt, doubts_on, doubts_used
from freebody.model.model import Model
from freebody.model.shafts import shaft_names
from freebody.motion.motion import Motion
from freebody.motion.optimal.geometric_path import (
    grid,
    motions_along,
    path_curve,
    refuse_out_of_range,
)
from freebody.motion.optimal.path_limits import (
    PathProblem,
    path_problem,
    refuse_unreachable,
    without_motion,
)
from freebody.motion.optimal.robot_limits import LimitsReached, RobotLimits
from freebody.motion.optimal.speed_profile import quickest_profile
from freebody.motion.piecewise import PiecewisePolynomial
from freebody.motion.planning.planned import sample_times
from freebody.motion.planning.planning_limits import Limit, PlanningLimits, planning_limits
from freebody.outputs.number_text import rounded_up
from freebody.trees.public_calls import FrameWrenchTable, wrenches_by_frame

PathArgument = ArrayLike | Motion | PPoly

_NAME = "time_optimal"
_BLOCK = 16  # paths computed side by side: what is known of them stays in the processor's cache
_ROUNDS = 12
_TANGENT = 1e-4  # of a limit: error of the viscous torque
_HELD = 1e-6  # of a limit: what it may be exceeded by between two points of the grid
_FAST = 2e-4  # of a limit of speed: more is not slowed down to, but computed again
_MISSED = 1e-6  # of the squares of speeds: what parabolas may miss of them
_FAR_FROM_HELD = 0.05
_COARSE = (10, 8, 5, 4, 3, 2)
_SOURCE = "the quickest along a path within the limits"


def time_optimal(
    model: Model,
    path: PathArgument | Sequence[Motion | PPoly],
    *,
    velocity: Limit = None,
    acceleration: Limit = None,
    torque: Limit = None,
    wrenches: FrameWrenchTable = None,
    points: int = 1001,
) -> Motion | tuple[Motion, ...]:
    """The time-optimal motion along a path, from rest to rest, within limits of speed, acceleration
    and torque.

    Parameters
    ----------
    model
        The robot.
    path : (k, nq), rad or m; many: (P, k, nq), or a list of motions or PPolys
        Waypoints, or a motion, of which the positions count: the natural cubic spline through them,
        s from 0 to 1 along its chords; or a path of your own, q(s) as a scipy PPoly of nq values
        with a continuous first derivative. Of a closed chain, waypoints of the driven joints
        (k, n), closed positions or a motion: the driven joints follow the spline, the loops lead
        the others; torques are those of the drives.
    velocity, acceleration, torque : one number or (nv,); rad/s, rad/s², N m; m/s, m/s², N
        Limits. The model's own apply too (zero means not given, see `Limits`), of open chains also
        those of joints that follow others. Torques contain friction (viscous, dry), rotors, springs
        and the payload.
    wrenches
        Constant ones by frame, world axes.
    points
        Points of the grid over s, to which 20 are added in its first and last interval; at least
        one interval in each piece of the path; s̈ is constant in an interval.

    Returns
    -------
    Motion, of many paths a tuple
        With its exact curve, and samples at the grid. Limits are kept within each interval too, or
        else notices say by how much torques or accelerations exceed theirs. What is doubtful about
        the robot's masses, drives and limits stands in its `doubts`.

    Raises
    ------
    FreebodyError
        The path leaves the joints' ranges, the robot cannot hold or move it, or a limit is exceeded
        by more than 5 % between points: at which s, which joint, which limit.
    LoopError, SingularError
        The loops block the path, or the drives do not hold it.

    References
    ----------
    Bobrow, Dubowsky and Gibson 1985; Pham and Pham 2018 ("TOPP-RA").
    """
    limits = planning_limits(_NAME, model, velocity, acceleration, torque=torque)
    loads = wrenches_by_frame(_NAME, model, wrenches, single=True)
    for frame, load in loads.items():
        refuse_not_finite(_NAME, f"wrenches[{frame!r}]", load, 1)
    limits.torque[list(model.passive)] = np.inf  # what nothing drives has no torque
    robot = RobotLimits(model, limits.velocity, limits.acceleration, limits.torque, loads)
    if not is_count(points, 2):
        raise FreebodyError(
            f"{_NAME}: points is {shown(points)}, expected a whole number from 2 up."
        )
    if model.loops:
        model.require_values("a motion")
        robot.refuse_shared()
    given, many = _each(path)
    curves = [
        path_curve(_NAME, model, one, limits, f"path {k}" if many else "path")
        for k, one in enumerate(given)
    ]
    if model.passive and not model.loops:
        hint = ", such as model.without('shafts') has" if shaft_names(model) else ""
        raise FreebodyError(
            f"{_NAME}: nothing drives {listed(model.passive_names, 4)} of {model.name!r}; a "
            f"motion along a path needs a drive in every joint{hint}."
        )
    motions = [
        motion
        for block in _blocks(curves, points)
        for motion in _motions(robot, limits, curves, block)
    ]
    return tuple(motions) if many else motions[0]


def time_optimal_through(
    model: Model,
    waypoints: ArrayLike,
    times: ArrayLike | None = None,
    *,
    velocity: Limit = None,
    acceleration: Limit = None,
    torque: Limit = None,
    wrenches: FrameWrenchTable = None,
    step: float | None = None,
) -> Motion:
    """`time_optimal` as a planner of motions through waypoints, with samples `step` s apart."""
    if times is not None:
        raise FreebodyError(
            f"{_NAME}: the times of waypoints are what it finds; leave them out, or take a spline."
        )
    limits: dict[str, Any] = {"velocity": velocity, "acceleration": acceleration, "torque": torque}
    motion = time_optimal(model, waypoints, **limits, wrenches=wrenches)
    assert isinstance(motion, Motion)
    if step is None:
        return motion
    t = sample_times(_NAME, motion.t, step)
    q, qd, qdd = motion.at(t)
    return replace(motion, t=t, q=q, qd=qd, qdd=qdd)


def _each(path: Any) -> tuple[Sequence[Any], bool]:
    """The paths as a sequence, and whether the argument held several."""
    several = isinstance(path, list | tuple) and len(path) > 0
    if several and all(isinstance(one, Motion | PPoly) for one in path):
        return path, True
    if isinstance(path, Motion | PPoly) or is_labelled(path):
        return [path], False
    array = as_floats(_NAME, "path", path)
    return (list(array), True) if array.ndim == 3 else ([array], False)


class _PathBlock(NamedTuple):
    """Paths that are computed side by side, and the intervals of each."""

    paths: list[int]
    intervals: int


def _blocks(curves: Sequence[PiecewisePolynomial], points: int) -> Iterator[_PathBlock]:
    """Blocks of all paths in order; the paths of a block have equally many intervals."""
    counts = [max(points - 1, len(curve.breaks) - 1) for curve in curves]
    for intervals, group in groupby(range(len(curves)), key=counts.__getitem__):
        paths = list(group)
        for start in range(0, len(paths), _BLOCK):
            yield _PathBlock(paths[start : start + _BLOCK], intervals)


def _motions(
    robot: RobotLimits,
    limits: PlanningLimits,
    curves: Sequence[PiecewisePolynomial],
    block: _PathBlock,
) -> Iterator[Motion]:
    """The motions along the paths of a block."""
    own = [curves[k] for k in block.paths]
    grids = np.stack([grid(curve, block.intervals) for curve in own], axis=1)
    problem = path_problem(robot, own, grids)
    doubts = _doubts(robot.model, limits)
    labels = ["the path"] if len(curves) == 1 else [f"path {k}" for k in block.paths]
    for k, curve in enumerate(own):
        refuse_out_of_range(_NAME, robot.model, curve, problem.at, k, limits, labels[k])
    found = _solved(problem, labels)
    bulge = np.maximum(found.fastest - 1.0 + _MISSED, 0.0)
    found.x[:] /= 1.0 + 2.0 * bulge  # slower by some millionths
    motions = motions_along(robot.model, problem.at, found.x, _SOURCE)
    for label, over, motion in zip(labels, found.over, motions, strict=True):
        if over > _FAR_FROM_HELD:
            raise FreebodyError(
                f"{_NAME}: between points of the grid {label} exceeds a limit by "
                f"{rounded_up(100 * over, 2)} %; give more points than {block.intervals + 1}, or "
                f"larger limits."
            )
        notices = (*(_excess_notice(over) if over > _HELD else ()), *_unheeded(robot.model))
        yield replace(motion, notices=notices, doubts=doubts)


def _doubts(model: Model, limits: PlanningLimits) -> tuple[Doubt, ...]:
    """The doubts on which the motion rests, with those about missing limits: of speed on drives
    without one, of torque where acceleration is not limited either."""
    unlimited = {
        EFFORTS: np.isinf(limits.torque) & np.isinf(limits.acceleration),
        SPEEDS: np.isinf(limits.velocity),
    }
    driven = list(model.driven)
    lacking = doubts_on(
        model, *(aspect for aspect, free in unlimited.items() if free[driven].any())
    )
    efforts = () if followers(model) is None else (EFFORTS,)
    used = doubts_used(model, *DYNAMIC, *dict.fromkeys((*limits.rests, *efforts)))
    return (*(doubt for doubt in lacking if doubt.of.absent), *used)


class _Quickest(NamedTuple):
    """The result for some paths: x = ṡ² (N + 1, P), the fraction by which torque or acceleration
    exceeds a limit within intervals (P,), and the square of the largest speed as a fraction of its
    limit (P,)."""

    x: Array
    over: Array
    fastest: Array

    @property
    def worst(self) -> Array:
        """The largest fraction (P,) by which any limit of each path is exceeded."""
        return np.maximum(self.over, np.sqrt(self.fastest) - 1.0)


def _solved(problem: PathProblem, labels: list[str]) -> _Quickest:
    """The fastest speeds along each path, found repeatedly: for tangents of viscous friction, then
    with stricter limits where limits are exceeded between grid points, unless these leave no
    motion. Paths do not influence each other."""
    before = _first_guess(problem)
    profile = quickest_profile(problem.strict(before))
    stuck = without_motion(problem, profile)
    if stuck.any():
        problem = problem.without_reserve(stuck)
        profile = quickest_profile(problem.strict(before))
        stuck = without_motion(problem, profile)
    refuse_unreachable(_NAME, problem, profile, stuck, labels)
    reached = problem.reached(profile.x)
    found = now = _quickest(profile.x, reached)
    moves, left = ~stuck, np.arange(len(labels))
    turning = problem.tangent_error(profile.x, before) > _TANGENT
    settled = ~turning
    for _ in range(1, _ROUNDS):
        beyond = (now.over > _HELD) | (now.fastest > (1.0 + _FAST) ** 2)
        again = moves & (turning | beyond)
        if not again.any():
            break
        problem = problem.tightened(profile.x, reached, again & ~turning).only(again)
        before, left = profile.x[:, again], left[again]
        profile = quickest_profile(problem.strict(before))
        reached, moves = problem.reached(profile.x), profile.moves
        now = _quickest(profile.x, reached)
        turning = problem.tangent_error(profile.x, before) > _TANGENT
        gains = (now.worst < found.worst[left]) & (turning <= ~settled[left])
        better = moves & (gains | (settled[left] < ~turning))
        settled[left[better]] = ~turning[better]
        for kept, new in zip(found, now, strict=True):
            kept[..., left[better]] = new[..., better]
    return found


def _quickest(x: Array, reached: LimitsReached) -> _Quickest:
    return _Quickest(x, reached.share.max(axis=0), reached.speed.max(axis=0))


def _first_guess(problem: PathProblem) -> Array:
    """A first guess of x = ṡ² (N + 1, P) for the tangents of viscous friction, from a coarse grid;
    0 without viscous friction.

    A tangent lies above the friction, by more than the drives have where it is taken at twice the
    speed that they hold: there the speed is halved. From below, x rises to where it stays.
    """
    count = len(problem.rows.h)
    guess = np.zeros_like(problem.rows.most)
    if problem.viscous is None:
        return guess
    every = next((k for k in _COARSE if count % k == 0), 1)
    coarse = problem.coarse(every)
    x = guess[::every]
    settled = np.zeros(x.shape[1], dtype=bool)
    for _ in range(_ROUNDS):
        profile = quickest_profile(coarse.with_friction(x))
        found, lost = profile.x, ~profile.moves
        close = coarse.tangent_error(found, x) <= _TANGENT
        x = np.where(settled, x, np.where(lost, 0.25 * x, found))
        settled |= close | (lost & ~x.any(axis=0))  # said of the fine grid, or found there
        if settled.all():
            break
    place = np.arange(count + 1) / every
    for k in range(x.shape[1]):
        guess[:, k] = np.interp(place, np.arange(len(x)), x[:, k])
    return guess


def _unheeded(model: Model) -> tuple[str, ...]:
    """The sentence on followers of a closed chain, whose limits of torque are not heeded."""
    own = followers(model) if model.loops else None
    if own is None:
        return ()
    return (
        f"What the loops bring to {listed(own.names, 4)} is not held within its own limit of "
        f"torque or force; a study of the motion judges it.",
    )


def _excess_notice(worst: float) -> tuple[str, ...]:
    return (
        f"Between two points of the grid a limit is exceeded by {rounded_up(100 * worst, 2)} %; "
        f"more points keep it more closely.",
    )
