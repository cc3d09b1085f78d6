"""`inverse_kinematics`: joint positions that bring a frame to a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError
from freebody.model.model import Model
from freebody.numerics.calls import Vector, finite_vector
from freebody.numerics.inverse.closed import Displacement, Form
from freebody.numerics.inverse.fitting import can_serve, displacement, displacement_to_points, fitting
from freebody.numerics.inverse.seek import Seeker
from freebody.numerics.inverse.solutions import (
    ALIKE,
    Solutions,
    Verified,
    turning_coordinates,
    verified,
    within,
)
from freebody.numerics.inverse.task import read_target
from freebody.numerics.inverse.workspace import distances
from freebody.numerics.states import neutral, random_state

LIMITS = ("mark", "drop", "ignore")
_SHOWN = 8
"""How many of the infinitely many solutions of a redundant arm are returned."""


def inverse_kinematics(
    model: Model,
    target: ArrayLike,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    *,
    q0: Vector | None = None,
    limits: Literal["mark", "drop", "ignore"] = "mark",
    starts: int | None = None,
    seed: int = 0,
) -> Solutions:
    """All joint positions that bring a frame to a target where a closed form exists, else those found from many starts.

    target: a point (..., dim) in m, or a pose (..., dim + 1, dim + 1), world axes. frame: name, default the tip.
    task: what counts of the target: "position" (a point's default), "orientation", "pose" (a pose's default), or rows
    among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w").
    q0: (nq,), where joints stay that could stand anywhere, next to which angles are wrapped, and near which a redundant
    arm is sought. limits: "mark" says in `within_limits` which solutions keep to the joints' limits, "drop" leaves out
    the others, "ignore" takes no notice. starts, seed: of the numeric search (default: 32 for redundant arms, else 96).

    Returns Solutions. Out of reach: k = 0, the distance (m) to the workspace, and a sentence in `notes`. Every solution
    has been put through forward kinematics. Raises ShapeError, NotFiniteError, UnknownNameError, MissingValueError.

    Closed forms, whatever frames, base and tool: planar arms of up to three joints (2.14, 2.15, by atan2 and with both
    elbows), SCARA robots, three joints that place a point, three that orient, six with a spherical wrist (Pieper 1968)
    or with three parallel axes (Elias and Wen 2022). Else Levenberg–Marquardt.
    """
    model.require_values("inverse kinematics")
    if limits not in LIMITS:
        raise UnknownNameError("choice", limits, "inverse_kinematics: limits=", LIMITS)
    chosen, poses = read_target("inverse_kinematics", model, target, task)
    seeker = Seeker(model, model.frame(frame).name, chosen)
    flat = poses.reshape(-1, *poses.shape[-2:])
    start = None if q0 is None else finite_vector("inverse_kinematics", model, "q0", q0)
    if start is not None and start.ndim != 1:
        raise FreebodyError(f"inverse_kinematics: q0 has shape {start.shape}, expected ({model.nq},).")
    problem = _Problem(seeker, flat, start, limits, starts, seed)
    form = fitting(model, seeker.frame, chosen)
    X = None
    if form is not None:
        X = (displacement if chosen.angular else displacement_to_points)(form.chain, flat)
        if not can_serve(form, chosen, X):
            form = X = None
    found = _by_form(problem, form, X) if form is not None and X is not None else _by_search(problem)
    return _gathered(problem, form, X, found, poses.shape[:-2])


@dataclass(frozen=True, eq=False)
class _Problem:
    """What was asked for: targets (N, …) of a frame and task."""

    seeker: Seeker
    target: Array
    q0: Array | None
    limits: str
    starts: int | None
    seed: int

    @property
    def reference(self) -> Array:
        """q (nq,) next to which angles are wrapped: q0, else the middle of the limits, else 0."""
        if self.q0 is not None:
            return self.q0
        low, high = self.seeker.bounds
        both = np.isfinite(low) & np.isfinite(high)
        middle = np.where(
            both, (np.where(both, low, 0.0) + np.where(both, high, 0.0)) / 2, neutral(self.seeker.model)
        )
        return np.clip(middle, low, high)


@dataclass(frozen=True, eq=False)
class _Found:
    """Per target its solutions and their branches; the method, and notes."""

    solutions: list[Verified]
    branches: list[list[str]]
    method: str
    notes: list[str]


# ---------------------------------------------------------------- in closed form
def _by_form(problem: _Problem, form: Form, X: Displacement) -> _Found:
    seeker, chain = problem.seeker, form.chain
    rest = np.zeros(seeker.model.nq) if problem.q0 is None else problem.q0
    base = np.clip(neutral(seeker.model), *seeker.bounds) if problem.q0 is None else problem.q0
    with np.errstate(invalid="ignore"):
        candidates = form.solve(X, chain.positions(rest))
    q = chain.coordinates(candidates.x, base)
    solutions = verified(seeker, q, problem.target, problem.reference)
    branches = [[", ".join(filter(None, form.label(chain.positions(row)))) for row in s.q] for s in solutions]
    free = np.zeros(len(chain.screws), dtype=bool)
    for i, s in enumerate(solutions):
        free |= candidates.free[i][s.row].any(axis=0)
    names = [_joint_at(seeker.model, int(chain.index[k])) for k in np.flatnonzero(free)]
    notes = [_free_note(name) for name in names]
    idle = seeker.moving.copy()
    idle[chain.index] = False
    if idle.any():
        names = ", ".join(repr(_joint_at(seeker.model, int(k))) for k in np.flatnonzero(idle))
        notes.append(f"Left alone, as they do not move the target's point: {names}.")
    return _Found(solutions, branches, form.name(), notes)


def _joint_at(model: Model, index: int) -> str:
    return model.position_names[index]


def _free_note(joint: str) -> str:
    return (
        f"Joint {joint!r} may take any angle at this target, the others make up for it: a whole family of solutions, "
        "of which one is given for each branch, that with the angle of q0 (0 without q0)."
    )


# ---------------------------------------------------------------- from many starts
def _by_search(problem: _Problem) -> _Found:
    seeker, N = problem.seeker, len(problem.target)
    redundant = seeker.freedom > 0
    K = problem.starts or (32 if redundant else 96)
    starts = _starts(problem, K)
    goals = np.repeat(problem.target, K, axis=0)
    keep = problem.limits != "ignore"
    q, _ = seeker.seek(goals, np.tile(starts, (N, 1)), within=keep)
    solutions = _sorted_out(problem, q.reshape(N, K, -1), keep)
    lost = [i for i, s in enumerate(solutions) if not len(s.q)]
    if lost and keep:  # perhaps beyond the limits
        q, _ = seeker.seek(np.repeat(problem.target[lost], K, axis=0), np.tile(starts, (len(lost), 1)))
        again = _Problem(seeker, problem.target[lost], problem.q0, problem.limits, K, problem.seed)
        for i, s in zip(lost, _sorted_out(again, q.reshape(len(lost), K, -1), False), strict=True):
            solutions[i] = s
    notes = (
        [f"The arm is redundant: {_SHOWN} at most of infinitely many solutions, nearest first."]
        if redundant
        else [f"No closed form is known for this arm and task: what {K} starts found, perhaps not all."]
    )
    return _Found(
        solutions, [[""] * len(s.q) for s in solutions], f"Levenberg–Marquardt from {K} starts", notes
    )


def _starts(problem: _Problem, K: int) -> Array:
    """(K, nq): q0, some near it, and some anywhere; without q0 all anywhere within the limits."""
    model, seeker = problem.seeker.model, problem.seeker
    q, noise, _ = random_state(model, problem.seed, K)
    if problem.q0 is not None:
        near = max(1, K // 2)
        spread = np.linspace(0.0, 0.5, near)[:, None]
        q[:near] = seeker.moved(np.tile(problem.q0, (near, 1)), spread * noise[:near])
    return np.where(seeker.moving, q, problem.reference)


def _sorted_out(problem: _Problem, q: Array, keep: bool) -> list[Verified]:
    """Solutions among what was found (N, K, nq), nearest to the reference first."""
    seeker, reference = problem.seeker, problem.reference
    settle = problem.q0 is not None and seeker.model.nq == seeker.model.nv and seeker.freedom > 0
    if settle:
        assert problem.q0 is not None
        N, K, nq = q.shape
        flat, goals = q.reshape(-1, nq), np.repeat(problem.target, K, axis=0)
        good = seeker.miss(flat, goals) < 1e-6
        if good.any():
            flat[good] = seeker.settled(flat[good], goals[good], problem.q0, keep)
        q = flat.reshape(N, K, nq)
    apart = {"apart": ALIKE} if seeker.freedom > 0 else {}
    results = verified(seeker, q, problem.target, reference, **apart)
    most = _SHOWN if seeker.freedom > 0 else None
    turning = turning_coordinates(seeker.model)
    for i, s in enumerate(results):
        fine = within(seeker, s.q) if keep else np.ones(len(s.q), dtype=bool)
        way = s.q - reference
        way[:, turning] = (
            (way[:, turning] + np.pi) % (2 * np.pi) - np.pi if problem.q0 is None else way[:, turning]
        )
        order = np.argsort(np.linalg.norm(way, axis=-1) + np.where(fine, 0.0, np.inf), kind="stable")
        order = order[fine[order]][:most]
        results[i] = Verified(s.q[order], s.miss[order], s.row[order])
    return results


# ---------------------------------------------------------------- the answer
def _gathered(
    problem: _Problem, form: Form | None, X: Displacement | None, found: _Found, batch: tuple[int, ...]
) -> Solutions:
    seeker, N = problem.seeker, len(problem.target)
    fine = [within(seeker, s.q) for s in found.solutions]
    chosen = [f if problem.limits == "drop" else np.ones(len(f), dtype=bool) for f in fine]
    k = max((int(c.sum()) for c in chosen), default=0)
    q, residual = np.full((N, k, seeker.model.nq), np.nan), np.full((N, k), np.nan)
    branches = np.full((N, k), "", dtype=object)
    inside = np.zeros((N, k), dtype=bool)
    for i, (s, names, f, c) in enumerate(zip(found.solutions, found.branches, fine, chosen, strict=True)):
        n = int(c.sum())
        q[i, :n], residual[i, :n], inside[i, :n] = s.q[c], s.miss[c], f[c] | (problem.limits == "ignore")
        branches[i, :n] = [name for name, taken in zip(names, c, strict=True) if taken]
    notes = list(found.notes) if any(len(s.q) for s in found.solutions) else []
    lost = [i for i, s in enumerate(found.solutions) if not len(s.q)]
    distance = np.zeros(N)
    if lost:
        part = None if X is None else Displacement(X.R[lost], X.p[lost])
        distance[lost], sentences = distances(seeker, form, part, problem.target[lost])
        notes += _each_once(sentences, lost, N)
    notes += _each_once(*_dropped(problem, found.solutions, chosen), N)
    return Solutions(
        q.reshape(*batch, k, -1) if k else q.reshape(*batch, 0, seeker.model.nq),
        branches.astype(str).reshape(*batch, k),
        residual.reshape(*batch, k),
        inside.reshape(*batch, k),
        distance.reshape(batch),
        found.method,
        tuple(notes),
    )


def _dropped(
    problem: _Problem, solutions: list[Verified], chosen: list[np.ndarray]
) -> tuple[list[str], list[int]]:
    """A sentence for each target all of whose solutions lie outside the limits."""
    sentences, rows = [], []
    low, high = problem.seeker.bounds
    names = problem.seeker.model.position_names
    for i, (s, c) in enumerate(zip(solutions, chosen, strict=True)):
        if len(s.q) and not c.any():
            bad = [
                names[k]
                for k in range(len(names))
                if ((s.q[:, k] < low[k] - 1e-9) | (s.q[:, k] > high[k] + 1e-9)).any()
            ]
            sentences.append(
                f"Within reach, but each of the {len(s.q)} solutions leaves a joint's limits ({', '.join(bad)}); "
                'limits="mark" returns them.'
            )
            rows.append(i)
    return sentences, rows


def _each_once(sentences: list[str], rows: list[int], N: int) -> list[str]:
    """Sentences, with their samples where there are several targets; three of them at most."""
    if N == 1 or not sentences:
        return sentences
    shown = [f"Target {row}: {text}" for text, row in zip(sentences[:3], rows, strict=False)]
    return [*shown, f"… and {len(sentences) - 3} more targets."] if len(sentences) > 3 else shown
