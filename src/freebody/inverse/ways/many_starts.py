"""Solutions from many starts, for arms and tasks without a closed form."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.inverse.problem.problem import Found, InverseProblem, found_in_turn
from freebody.inverse.problem.solutions import ALIKE, APART, Verified, verified, within
from freebody.trees.states import random_state

_SHOWN = 8
"""Number of solutions that are returned of the infinitely many of a redundant arm."""
_AT_ONCE = 1024
"""Targets side by side, which bounds the memory."""


def by_search(problem: InverseProblem, known: Array | None = None) -> Found:
    """Solutions found from many starts: those within the limits, or those beyond where none is
    within.

    known: (N, k, nq), positions to be looked at besides, NaN where there is none.
    """
    solver, N = problem.solver, len(problem.target)
    redundant = solver.freedom > 0
    K = problem.starts or (32 if redundant else 96)
    starts = _starts(problem, K)
    solutions: list[Verified] = []
    for first in range(0, N, _AT_ONCE):
        rows = np.arange(first, min(first + _AT_ONCE, N))
        also = None if known is None else known[rows]
        solutions += _from_starts(problem.part(rows), starts, also)
    notes = (
        [f"The arm is redundant: at most {_SHOWN} of infinitely many solutions, nearest first."]
        if redundant
        else [
            f"No closed form is known for this arm and task: what {K} starts found, perhaps not "
            f"all."
        ]
    )
    return found_in_turn(
        solutions,
        [[""] * len(s.q) for s in solutions],
        solver.model.nq,
        f"Levenberg–Marquardt from {K} starts",
        notes,
    )


def _from_starts(problem: InverseProblem, starts: Array, known: Array | None) -> list[Verified]:
    """The verified solutions of each target from the given starts."""
    solver, N, K = problem.solver, len(problem.target), len(starts)
    goals = np.repeat(problem.target, K, axis=0)
    keep = problem.limits != "ignore"
    q, _ = solver.solve(goals, np.tile(starts, (N, 1)), within=keep)
    q = q.reshape(N, K, -1)
    if known is not None:
        q = np.concatenate([q, known], axis=1)
    solutions = _sorted_out(problem, q, keep)
    lost = np.array([i for i, s in enumerate(solutions) if not len(s.q)], dtype=int)
    if len(lost) and keep:  # perhaps beyond the limits
        again = problem.part(lost)
        goals = np.repeat(again.target, K, axis=0)
        q, _ = solver.solve(goals, np.tile(starts, (len(lost), 1)))
        found = _sorted_out(again, q.reshape(len(lost), K, -1), False)
        for i, s in zip(lost, found, strict=True):
            solutions[i] = s
    return solutions


def _starts(problem: InverseProblem, K: int) -> Array:
    """Starts (K, nq): q0, some near it, and the others random; all random within the limits where
    there is no q0."""
    model, solver = problem.solver.model, problem.solver
    q, noise, _ = random_state(model, problem.seed, K)
    if problem.q0 is not None:
        near = max(1, K // 2)
        spread = np.linspace(0.0, 0.5, near)[:, None]
        q[:near] = solver.moved(np.tile(problem.q0, (near, 1)), spread * noise[:near])
    return np.where(solver.moving, q, problem.reference)


def _sorted_out(problem: InverseProblem, q: Array, keep: bool) -> list[Verified]:
    """The verified solutions among positions (N, K, nq), nearest to the reference first; keep: only
    those within the limits."""
    solver, reference = problem.solver, problem.reference
    redundant = solver.freedom > 0
    if redundant and problem.q0 is not None and solver.model.nq == solver.model.nv:
        q = _settled(problem, q, problem.q0, keep)
    results = verified(solver, q, problem.target, reference, ALIKE if redundant else APART)
    for i, s in enumerate(results):
        fine = within(solver, s.q) if keep else np.ones(len(s.q), dtype=bool)
        order = np.argsort(np.linalg.norm(s.q - reference, axis=-1), kind="stable")
        order = order[fine[order]][: _SHOWN if redundant else None]
        results[i] = Verified(s.q[order], s.miss[order], s.row[order])
    return results


def _settled(problem: InverseProblem, q: Array, q0: Array, keep: bool) -> Array:
    """Positions (N, K, nq), where those that reached their target are moved along the redundant
    arm's solutions as near to q0 as possible."""
    flat, goals = q.reshape(-1, q.shape[-1]), np.repeat(problem.target, q.shape[1], axis=0)
    good = problem.solver.miss(flat, goals) < 1e-6
    if good.any():
        flat[good] = problem.solver.settled(flat[good], goals[good], q0, keep)
    return flat.reshape(q.shape)
