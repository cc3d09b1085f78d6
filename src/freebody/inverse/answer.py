"""What was found for each target as arrays, with a sentence where there is nothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from freebody.arrays import Array
from freebody.inverse.closed_form import ClosedFormSolver, Displacement
from freebody.inverse.problem import Found, Problem
from freebody.inverse.solutions import Solutions, Verified, within
from freebody.inverse.workspace import distances

Away = Callable[[Array], tuple[Array, list[str]]]
"""Targets (N, …) -> their distances (N,) from what can be reached, and a sentence for each."""


def gathered(
    problem: Problem,
    form: ClosedFormSolver | None,
    X: Displacement | None,
    found: Found,
    batch: tuple[int, ...],
    away: Away | None = None,
) -> Solutions:
    """The solutions of all targets in arrays of the batch, those out of reach with their distance
    and a sentence.

    away: how far targets are out of reach; by default as of an open chain.
    """
    solver, N = problem.solver, len(problem.target)
    fine = [within(solver, s.q) for s in found.solutions]
    chosen = [f if problem.limits == "drop" else np.ones(len(f), dtype=bool) for f in fine]
    k = max((int(c.sum()) for c in chosen), default=0)
    q, residual = np.full((N, k, solver.model.nq), np.nan), np.full((N, k), np.nan)
    branches = np.full((N, k), "", dtype=object)
    inside = np.zeros((N, k), dtype=bool)
    for i, (s, names, f, c) in enumerate(
        zip(found.solutions, found.branches, fine, chosen, strict=True)
    ):
        n = int(c.sum())
        q[i, :n], residual[i, :n], inside[i, :n] = (
            s.q[c],
            s.miss[c],
            f[c] | (problem.limits == "ignore"),
        )
        branches[i, :n] = [name for name, taken in zip(names, c, strict=True) if taken]
    notes = list(found.notes) if any(len(s.q) for s in found.solutions) else []
    lost = [i for i, s in enumerate(found.solutions) if not len(s.q)]
    distance = np.zeros(N)
    if lost:
        part = None if X is None else Displacement(X.R[lost], X.p[lost])
        goals = problem.target[lost]
        distance[lost], sentences = away(goals) if away else distances(solver, form, part, goals)
        notes += _each_once(sentences, lost, N)
    notes += _each_once(*_dropped(problem, found.solutions, chosen), N)
    return Solutions(
        q.reshape(*batch, k, -1) if k else q.reshape(*batch, 0, solver.model.nq),
        branches.astype(str).reshape(*batch, k),
        residual.reshape(*batch, k),
        inside.reshape(*batch, k),
        distance.reshape(batch),
        found.method,
        tuple(notes),
    )


def _dropped(
    problem: Problem, solutions: list[Verified], chosen: list[np.ndarray]
) -> tuple[list[str], list[int]]:
    """A sentence for each target all of whose solutions lie outside the limits."""
    sentences, rows = [], []
    low, high = problem.solver.bounds
    names = problem.solver.model.position_names
    for i, (s, c) in enumerate(zip(solutions, chosen, strict=True)):
        if len(s.q) and not c.any():
            bad = [
                names[k]
                for k in range(len(names))
                if ((s.q[:, k] < low[k] - 1e-9) | (s.q[:, k] > high[k] + 1e-9)).any()
            ]
            sentences.append(
                f"Within reach, but each of the {len(s.q)} solutions leaves a joint's limits "
                f"({', '.join(bad)}); "
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
