"""Why a robot cannot move along a path within its limits: where, which joint, which limit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import linprog

from freebody.arrays import Array
from freebody.errors import FreebodyError, MissingArgumentError, listed
from freebody.model.model import Model
from freebody.motion.optimal.path_limits import PathProblem, unlimited
from freebody.motion.optimal.robot_limits import RobotLimits
from freebody.motion.optimal.speed_profile import SpeedProfile
from freebody.motion.ranges import Flags, angular
from freebody.outputs.number_text import compared

_BINDING = 1e-6
_FAST = 0.25  # of `unlimited`


def without_motion(problem: PathProblem, profile: SpeedProfile) -> Flags:
    """(P,) whether a path's end is not reached from rest."""
    moves = profile.moves
    if problem.viscous is None:  # its tangent says nothing of rest
        moves &= profile.starts
    return ~moves


def refuse_unreachable(
    function: str, problem: PathProblem, profile: SpeedProfile, stuck: Flags, labels: list[str]
) -> None:
    """Raise FreebodyError for the first path without a motion, which are `stuck` (P,), or without a
    limit; `labels` name the paths."""
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
    """Where the robot is worst too weak for its weight and dry friction alone; empty if nowhere."""
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
    """The limits that exclude each other in the first interval, from the end, where nothing is
    left."""
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
    """(coordinate, unit, quantity) of a row."""
    torques = np.flatnonzero(np.isfinite(limits.torque))
    turns = angular(limits.model)
    if row < len(torques):
        k = torques[row]
        unit, what = ("N m", "torque") if turns[k] else ("N", "force")
    else:
        k = np.flatnonzero(np.isfinite(limits.acceleration))[row - len(torques)]
        unit, what = "rad/s²" if turns[k] else "m/s²", "acceleration"
    return limits.model.velocity_names[k], unit, what


def _at(problem: PathProblem, i: int, path: int) -> str:
    """`at s = 0.3`, with the position there."""
    s, q = problem.at.s[i, path], problem.at.q[i, path]
    some = ", ".join(f"{round(float(x), 9) + 0.0:.4g}" for x in q[:8])
    return f"at s = {s:.4g} (q = {some}{', …' if len(q) > 8 else ''})"
