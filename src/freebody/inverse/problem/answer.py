"""Solutions of all targets as arrays, with a sentence where a target has none."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from freebody.algorithms.closed_form_inverse.near_reference import LOOSE
from freebody.arrays import Array
from freebody.inverse.problem.closed_form import ClosedFormArm
from freebody.inverse.problem.problem import Found, InverseProblem
from freebody.inverse.problem.solutions import Solutions, within
from freebody.inverse.problem.workspace import Away, distances


class Numbered(NamedTuple):
    """Row numbers (N,) of some targets among `count`, for messages."""

    rows: np.ndarray
    count: int

    def sentences(self, sentence: Callable[[int], str], of: np.ndarray) -> list[str]:
        """Sentences on some of these targets, preceded by the target's number where there are
        several; at most three."""
        if self.count == 1:
            return [sentence(k) for k in range(len(of))]
        shown = [f"Target {row}: {sentence(k)}" for k, row in enumerate(self.rows[of[:3]])]
        return [*shown, f"… and {len(of) - 3} more targets."] if len(of) > 3 else shown


def gathered(
    problem: InverseProblem,
    form: ClosedFormArm | None,
    found: Found,
    batch: tuple[int, ...],
    away: Callable[[Array], Away] | None = None,
    numbered: Numbered | None = None,
) -> Solutions:
    """The solutions of all targets in arrays of the batch, those out of reach with their distance
    and a sentence.

    away: how far targets are out of reach; by default as of an open chain. numbered: as which the
    targets are spoken of, where they are some of more.
    """
    solver, N = problem.solver, len(problem.target)
    numbered = Numbered(np.arange(N), N) if numbered is None else numbered
    there = np.isfinite(found.miss)
    fine = there & within(solver, found.q)
    chosen = fine if problem.limits == "drop" else there
    k = int(chosen.sum(axis=-1).max(initial=0))
    first = np.argsort(~chosen, axis=-1, kind="stable")[:, :k]
    taken = np.take_along_axis(chosen, first, axis=-1)
    q = np.where(taken[..., None], np.take_along_axis(found.q, first[..., None], axis=1), np.nan)
    residual = np.where(taken, np.take_along_axis(found.miss, first, axis=1), np.nan)
    inside = taken & (np.take_along_axis(fine, first, axis=1) | (problem.limits == "ignore"))
    lost = found.lost
    notes = list(found.notes) if len(lost) < N else []
    distance = np.zeros(N)
    if len(lost):
        part = problem.part(lost)
        distance[lost], sentence = away(part.target) if away else distances(part, form)
        notes += numbered.sentences(sentence, lost)
    notes += numbered.sentences(*_dropped(problem, found, there, chosen))
    fields: dict[str, Any] = {
        "q": q.reshape(*batch, k, solver.model.nq),
        "residual": residual.reshape(*batch, k),
        "within_limits": inside.reshape(*batch, k),
        "distance": distance.reshape(batch),
        "method": found.method,
        "notes": tuple(notes),
    }
    if callable(found.names):
        return Solutions.lazily_named(found.names, **fields)
    branches = np.where(taken, np.take_along_axis(found.names, first, axis=1), "")
    return Solutions(branches=branches.reshape(*batch, k), **fields)


def _dropped(
    problem: InverseProblem, found: Found, there: np.ndarray, chosen: np.ndarray
) -> tuple[Callable[[int], str], np.ndarray]:
    """A function that gives a sentence for each target whose solutions are all outside the limits,
    and the rows of these targets."""
    low, high = problem.solver.bounds
    names = problem.solver.model.position_names
    rows = np.flatnonzero(there.any(axis=-1) & ~chosen.any(axis=-1))

    def sentence(k: int) -> str:
        i = rows[k]
        q = found.q[i][there[i]]
        bad = [
            names[k]
            for k in range(len(names))
            if ((q[:, k] < low[k] - LOOSE) | (q[:, k] > high[k] + LOOSE)).any()
        ]
        return (
            f"Within reach, but each of the {len(q)} solutions leaves a joint's limits "
            f'({", ".join(bad)}); limits="mark" returns them.'
        )

    return sentence, rows
