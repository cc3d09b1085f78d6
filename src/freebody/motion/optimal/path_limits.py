"""Limits of the speed along a path: velocities, accelerations and torques of a robot as rows over
the path; and, where they leave no motion, the limit and joint to blame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linprog

from freebody.arrays import Array
from freebody.errors import FreebodyError, MissingArgumentError, listed
from freebody.model.model import Model
from freebody.motion.optimal.geometric_path import PathSamples, sampled
from freebody.motion.optimal.robot_limits import LimitsReached, RobotLimits
from freebody.motion.optimal.speed_profile import PathRows, SpeedProfile, speed_limits
from freebody.motion.piecewise import PiecewisePolynomial
from freebody.motion.ranges import Flags, angular
from freebody.motion.smooth_friction import simple_friction, strut_damping
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import Index

_INSTANT = 1e-6
"""s: no path takes less time; what would be quicker has no limit."""
RESERVE = 2e-4
"""Part of a limit of torque or acceleration that is kept from it in the rows, for the motion
between points."""
_CUSHION = 5e-5
"""Part of a limit by which it is made stricter than what it was exceeded by."""
_PLACES = np.linspace(0.0, 1.0, 17)
"""Places in an interval, as parts of its way."""
_TURNED = 2.0
"""Most of a wave of a torque, in rad, within an interval."""
_SLIGHTLY = 0.01
"""Part of a squared speed that is given away at once rather than by computing the motion again."""


@dataclass(frozen=True, eq=False)
class PathProblem:
    """Limits of a robot along paths: `rows` with a reserve of `RESERVE` and without viscous
    friction, whose coefficients by ṡ are `viscous` (N + 1, P, m), or None."""

    limits: RobotLimits
    at: PathSamples
    between: PathSamples
    """Samples halfway in each interval."""
    rows: PathRows
    viscous: Array | None
    margin: tuple[Array, Array] | None = None
    """(N, P, m) by how much lower and upper limits of an interval are to be stricter."""

    def with_friction(self, x: Array) -> PathRows:
        """The rows with viscous torque replaced by its tangent at x = ṡ² (N + 1, P)."""
        if self.viscous is None:
            return self.rows
        speed = np.sqrt(x)[..., None]
        half = 0.5 * self.viscous
        slope = half / np.where(speed > 0.0, speed, np.inf)
        rest = half * speed
        (lo, lo_end), (hi, hi_end) = self.rows.lo, self.rows.hi
        return self.rows._replace(
            b=self.rows.b + slope,
            lo=(lo - rest[:-1], lo_end - rest[1:]),
            hi=(hi - rest[:-1], hi_end - rest[1:]),
        )

    def strict(self, x: Array) -> PathRows:
        """The rows reduced by their margins, with the friction of motions with x = ṡ² (N + 1,
        P)."""
        rows = self.with_friction(x)
        if self.margin is None:
            return rows
        below, above = self.margin
        (lo, lo_end), (hi, hi_end) = rows.lo, rows.hi
        return rows._replace(lo=(lo + below, lo_end + below), hi=(hi - above, hi_end - above))

    def tangent_error(self, x: Array, before: Array) -> Array:
        """The largest error (P,) at x of the tangents taken at `before`, as a fraction of the
        limits."""
        if self.viscous is None:
            return np.zeros(x.shape[1])
        was, speed = np.sqrt(before), np.sqrt(x)
        error = 0.5 * (speed - was) ** 2 / np.where(was > 0.0, was, 1.0)
        share = np.abs(self.viscous) * error[..., None] / self.limits.size
        return share.max(axis=(0, 2), initial=0.0)

    def reached(self, x: Array) -> LimitsReached:
        """How far motions with x = ṡ² (N + 1, P) exceed the limits: by a parabola in each interval,
        and where that might not be enough at `_PLACES` of it."""
        found = self.limits.reached(self.with_friction(x), x, self.at, self.between)
        interval, path = np.nonzero(found.near > 1.0)
        if len(interval):
            by = self._within(x, interval, path)
            found.by[interval, path] = by
            found.share[interval, path] = (np.abs(by) / self.limits.size).max(axis=-1)
        return found

    def _within(self, x: Array, interval: Index, path: Index) -> Array:
        """The amounts (k, m) by which the rows exceed their limits within k intervals; see
        `LimitsReached`."""
        at, size = self.at, self.limits.size
        start, end = x[interval, path], x[interval + 1, path]
        way = at.s[interval + 1, path] - at.s[interval, path]
        half = 0.5 * (end - start) / way  # s̈
        passed = way[:, None] * _PLACES
        q, first, second = (
            _taylor([order[interval, path] for order in at.orders[k:]], passed) for k in range(3)
        )
        # 0 at the end of a motion but for rounding
        square = np.maximum(start[:, None] + 2.0 * half[:, None] * passed, 0.0)
        qd = first * np.sqrt(square)[..., None]
        qdd = second * square[..., None] + first * half[:, None, None]
        values = self.limits.values(q, qd, qdd)
        top, bottom = (_highest(way * values) for way in (1.0, -1.0))
        return np.maximum(top - size, 0.0) - np.maximum(bottom - size, 0.0)

    def tightened(self, x: Array, reached: LimitsReached, paths: Flags) -> PathProblem:
        """The problem with limits of the chosen paths made stricter by the amounts by which motions
        with x = ṡ² (N + 1, P) exceed them."""
        by, speed = reached.by, reached.speed
        most = 0.25 * self.limits.size  # a grid so coarse is told, not mended
        by = by + np.sign(by) * _CUSHION * self.limits.size
        rows = np.clip(np.where(paths[:, None], by, 0.0), -most, most)
        below, above = self.margin or (0.0, 0.0)
        margin = below - np.minimum(rows, 0.0), above + np.maximum(rows, 0.0)
        fast = paths & (speed > 1.0)
        fastest = self.rows.most.copy()
        for points in (slice(None, -1), slice(1, None)):
            slower = np.where(fast, x[points] / speed, np.inf)
            fastest[points] = np.minimum(fastest[points], slower)
        return replace(self, margin=margin, rows=self.rows._replace(most=fastest))

    def without_reserve(self, paths: Flags) -> PathProblem:
        """The problem in which the chosen paths may use the limits without a reserve."""
        more = np.where(paths[:, None], RESERVE * self.limits.size, 0.0)
        (lo, lo_end), (hi, hi_end) = self.rows.lo, self.rows.hi
        lo, hi = (lo - more, lo_end - more), (hi + more, hi_end + more)
        return replace(self, rows=self.rows._replace(lo=lo, hi=hi))

    def only(self, paths: Flags) -> PathProblem:
        """The problem restricted to the chosen paths."""
        if paths.all():
            return self
        h, most, a, b, lo, hi = self.rows
        lo, hi = ((start[:, paths], end[:, paths]) for start, end in (lo, hi))
        grid = (x[:, paths] for x in (h, most, a, b))
        rows = PathRows(*grid, lo=lo, hi=hi)
        at, between = self.at.only(paths), self.between.only(paths)
        drag = None if self.viscous is None else self.viscous[:, paths]
        margin = self.margin and (self.margin[0][:, paths], self.margin[1][:, paths])
        return PathProblem(self.limits, at, between, rows, drag, margin)

    def coarse(self, every: int) -> PathProblem:
        """The problem on a grid of every `every`-th point; the number of intervals is a multiple of
        it."""
        rows, cut = self.rows, slice(None, None, every)
        starts, ends = cut, slice(every - 1, None, every)
        h = rows.h.reshape(-1, every, rows.h.shape[1]).sum(axis=1)
        lo, hi = ((x[0][starts], x[1][ends]) for x in (rows.lo, rows.hi))
        fewer = PathRows(h, rows.most[cut], rows.a[cut], rows.b[cut], lo, hi)
        drag = None if self.viscous is None else self.viscous[cut]
        return replace(self, rows=fewer, viscous=drag)


def _taylor(orders: Sequence[Array], beyond: Array) -> Array:
    """Values (k, n, nv) of Taylor polynomials with the derivatives (k, nv), orders without a gap,
    at distances `beyond` (k, n) from where they are taken."""
    found = np.zeros((*beyond.shape, orders[0].shape[-1]))
    for power in range(len(orders) - 1, -1, -1):
        found = found * (beyond[..., None] / (power + 1)) + orders[power][:, None]
    return found


def _highest(values: Array) -> Array:
    """The highest values (k, m) of curves with evenly spaced samples (k, n, m), by a parabola
    through the highest sample and its neighbours."""
    place = np.clip(values.argmax(axis=1), 1, values.shape[1] - 2)[:, None]
    before, middle, after = (
        np.take_along_axis(values, place + side, axis=1)[:, 0] for side in (-1, 0, 1)
    )
    bend, lean = 2.0 * middle - before - after, after - before
    inside = np.abs(lean) < 2.0 * bend
    peak = middle + np.divide(lean**2, 8.0 * bend, out=np.zeros_like(bend), where=inside)
    return np.maximum(peak, values.max(axis=1))


def path_problem(
    limits: RobotLimits, curves: Sequence[PiecewisePolynomial], s: Array
) -> PathProblem:
    """The limits along paths at a grid s (N + 1, P)."""
    found = sampled(curves, np.concatenate([s, 0.5 * (s[:-1] + s[1:])]))
    at, between = (found.part(part) for part in _parts(len(s)))
    viscous, dry = simple_friction("time_optimal", limits.model)
    _require_close_grid(limits.model, at.q)
    a, b, lo, hi = limits.rows(at, 1.0 - RESERVE)
    ends = [(lo[:-1], hi[:-1]), (lo[1:], hi[1:])]
    if dry.any():
        places = (at.q[:-1], at.first[:-1]), (between.q, between.first), (at.q[1:], at.first[1:])
        drag = np.stack(
            [
                limits.friction(q, dry * np.sign(first), limits.followed.friction(q, first)[1])
                for q, first in places
            ]
        )
        drag[0, 0] = drag[2, -1] = 0.0  # at rest, where no friction helps to brake
        ends = [(lo - drag.min(axis=0), hi - drag.max(axis=0)) for lo, hi in ends]
    (lo, hi), (lo_end, hi_end) = ends
    h = 2.0 * np.diff(s, axis=0)
    speed = _speed_limits(limits, found, len(s))
    rows = PathRows(h, speed, a, b, (lo, lo_end), (hi, hi_end))
    rated = viscous * at.first
    if limits.model.struts:
        rated = rated + strut_damping(limits.model, at.q, at.first)
    drag = None
    if rated.any():
        drag = limits.friction(at.q, rated, limits.followed.friction(at.q, at.first)[0])
    return PathProblem(limits, at, between, rows, drag)


def _require_close_grid(model: Model, q: Array) -> None:
    """Refuse a grid q (N + 1, P, nq) so coarse that a torque varying with position may rise and
    fall unseen between two points."""
    for body in model.tree.bodies:
        for x in () if body.drive is None else body.drive.laws:
            if x.law.waves is None or not np.any(x.p[0]):
                continue
            (position,) = body.coordinates.position(tuple(np.moveaxis(q, -1, 0)))
            turned = np.abs(np.diff(position, axis=0)).max() * x.law.waves(x.p)
            if turned > _TURNED:
                least = int(np.ceil((len(q) - 1) * turned / _TURNED)) + 1
                raise FreebodyError(
                    f"time_optimal: between two points of the grid the {x.law.term} of body "
                    f"{body.name!r} comes and goes; give {least} points or more, or plan without "
                    f"it, model.with_drive(joint, {x.law.strength}=0)."
                )


def _speed_limits(limits: RobotLimits, samples: PathSamples, count: int) -> Array:
    """The largest ṡ² (N + 1, P) allowed by limits of speed at a grid of `count` points, 0 at its
    end. samples: at the grid points, then halfway.

    In an interval ṡ² is a straight line, and the speed limit mostly a hollow curve over s: where
    the line through both ends is slightly above it, the line parallel to it through the middle is
    taken, which touches the curve. Where it is far above, what the motion reaches there decides.
    """
    most = np.minimum(speed_limits(samples.first, limits.velocity), _from_rest(samples.s, count))
    points, halfway = (most[part] for part in _parts(count))
    above = np.maximum(0.5 * (points[:-1] + points[1:]) - halfway, 0.0)
    above *= above <= _SLIGHTLY * np.minimum(points[:-1], points[1:])
    found = points.copy()
    found[:-1] -= above
    found[1:] = np.minimum(found[1:], points[1:] - above)
    found[-1] = 0.0
    return found


def _from_rest(s: Array, count: int) -> Array:
    """The values (T, P) at places s (T, P), grid points first, above which ṡ² counts as unlimited:
    `unlimited`, falling towards the resting ends, where it would swallow true speeds by
    rounding."""
    start, end = s[0], s[count - 1]
    way = np.maximum(np.minimum(s - start, end - s), 0.25 * (s[1] - start))
    return way * (2.0 * unlimited(s[:count]) / (end - start))


def _parts(count: int) -> tuple[slice, slice]:
    """Two slices of an array that holds `count` grid points first and then the intervals between
    them."""
    return slice(count), slice(count, None)


def unlimited(s: Array) -> Array:
    """The value (P,) of ṡ² above which a path's speed counts as unlimited."""
    return ((s[-1] - s[0]) / _INSTANT) ** 2


_BINDING = 1e-6
_FAST = 0.25  # of `unlimited`


def without_motion(problem: PathProblem, profile: SpeedProfile) -> Flags:
    """Flags (P,) of paths whose end cannot be reached from rest."""
    moves = profile.moves
    if problem.viscous is None:  # its tangent says nothing of rest
        moves &= profile.starts
    return ~moves


def refuse_unreachable(
    function: str, problem: PathProblem, profile: SpeedProfile, stuck: Flags, labels: list[str]
) -> None:
    """Raise FreebodyError for the first path without a motion, as `stuck` (P,) marks it, or without
    a limit of its speed; labels: names of the paths."""
    free = profile.x.max(axis=0) > _FAST * unlimited(problem.at.s)
    for path in map(int, np.flatnonzero(stuck | free)):
        start = f"{function}: {labels[path]}"
        if not stuck[path]:
            raise _without_limit(start, problem, profile, path)
        reason = _held_still(problem, path) or _excluded(problem, profile, path)
        raise FreebodyError(
            f"{start} cannot be followed: {reason}. Move the path, lighten the load, or give "
            f"larger limits."
        )


def _held_still(problem: PathProblem, path: int) -> str:
    """A sentence on the place of a path where the robot is most clearly too weak for its weight and
    dry friction alone; empty where it is strong enough."""
    ends = problem.rows.lo, problem.rows.hi
    (lo, lo_end), (hi, hi_end) = ((x[0][:, path], x[1][:, path]) for x in ends)
    size = problem.limits.size
    over = np.maximum(np.concatenate([lo, lo_end[-1:]]), -np.concatenate([hi, hi_end[-1:]]))
    i, row = np.unravel_index(np.argmax(over / size), over.shape)
    if over[i, row] <= 0.0:
        return ""
    name, unit, what = _row(problem.limits, int(row))
    needed, largest = compared(size[row] + over[i, row], size[row])
    return (
        f"{_at(problem, int(i), path)} {name} needs {needed} {unit} to move slowly, and its "
        f"largest {what} is {largest} {unit}"
    )


def _excluded(problem: PathProblem, profile: SpeedProfile, path: int) -> str:
    """A sentence on the limits that exclude each other in the first interval, counted from the
    path's end, where no motion is left."""
    rows, reachable = problem.rows, profile.reachable[:, path]
    lost = np.flatnonzero(np.isnan(reachable[:, 0]))
    stuck = np.flatnonzero(profile.x[1:-1, path] <= 0.0)
    if not len(lost) and not len(stuck):
        return f"it would have to be in motion already {_at(problem, 0, path)}"
    i = int(lost[-1]) if len(lost) else int(stuck[0])
    h, size = rows.h[i, path], problem.limits.size
    forms = []
    for end in (0, 1):
        a, b = rows.a[i + end, path], rows.b[i + end, path]
        for sign, bound in ((1.0, rows.hi[end][i, path]), (-1.0, -rows.lo[end][i, path])):
            x_part = sign * b
            u_part = sign * (a + (h * b if end else 0.0))
            forms.append(np.stack([x_part, u_part, -size, bound], axis=-1))
    limits = np.concatenate(forms)
    low, high = reachable[i + 1] if len(lost) else (_BINDING * rows.most[i, path], np.inf)
    ends = np.array([[1.0, h, 0.0, min(high, rows.most[i + 1, path])], [-1.0, -h, 0.0, -low]])
    every = np.concatenate([limits, ends])
    found = linprog(
        [0.0, 0.0, 1.0],
        A_ub=every[:, :3],
        b_ub=every[:, 3],
        bounds=[(0.0, rows.most[i, path]), (None, None), (0.0, None)],
    )
    place = f"between {_at(problem, i, path)[3:]} and s = {problem.at.s[i + 1, path]:.4g}"
    if not found.success:
        return f"{place} no speed is within all limits"
    close = found.slack[: len(limits)] <= _BINDING * np.tile(size, 4)
    if found.x[2] <= _BINDING or not close.any():
        return f"{place} no speed within all limits leads on to rest at its end"
    names = [_row(problem.limits, int(k) % len(size)) for k in np.flatnonzero(close)]
    texts = dict.fromkeys(f"the {what} of {name}" for name, _, what in names)
    return (
        f"{place} the limits exclude each other, above all {listed(texts, 3)}; they would have to "
        f"be {found.x[2] * 100:.2g} % larger"
    )


def _without_limit(
    start: str, problem: PathProblem, profile: SpeedProfile, path: int
) -> FreebodyError:
    i = int(np.argmax(profile.x[:, path]))
    names = list(_moving(problem.limits.model, problem.at.first[i, path]))
    if not names:
        return FreebodyError(f"{start} stands still {_at(problem, i, path)}; leave that piece out.")
    return MissingArgumentError(
        f"{start} has no quickest motion: {_at(problem, i, path)} nothing limits the speed of "
        f"{listed(names, 3)}",
        ("velocity", "acceleration", "torque"),
    )


def _moving(model: Model, first: Array) -> Iterator[str]:
    for k in np.flatnonzero(np.abs(first) > 1e-9 * np.abs(first).max(initial=0.0)):
        yield model.velocity_names[k]


def _row(limits: RobotLimits, row: int) -> tuple[str, str, str]:
    """The coordinate or follower, unit and quantity that a row of limits is about."""
    names, turns, followed = limits.model.velocity_names, angular(limits.model), limits.followed
    torques, accelerations = (
        np.flatnonzero(np.isfinite(x)) for x in (limits.torque, limits.acceleration)
    )
    every = [
        *((names[k], *_EFFORT[bool(turns[k])]) for k in torques),
        *((names[k], *_ACCELERATION[bool(turns[k])]) for k in accelerations),
        *(
            (name, *_EFFORT[bool(x)])
            for name, x in zip(followed.names, followed.turns, strict=True)
        ),
    ]
    return every[row]


_EFFORT = {True: ("N m", "torque"), False: ("N", "force")}
_ACCELERATION = {True: ("rad/s²", "acceleration"), False: ("m/s²", "acceleration")}
"""Units and quantities, by whether a joint turns."""


def _at(problem: PathProblem, i: int, path: int) -> str:
    """Words for a place on a path, such as "at s = 0.3", with the joint positions there."""
    s, q = problem.at.s[i, path], problem.at.q[i, path]
    some = ", ".join(f"{round(float(x), 9) + 0.0:.4g}" for x in q[:8])
    return f"at s = {s:.4g} (q = {some}{', …' if len(q) > 8 else ''})"
