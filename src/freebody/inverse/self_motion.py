"""Arms of seven joints of which six have a closed form: of each branch the solution nearest to the
reference, over the position of the joint that is left."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.inverse.branch_kernel import branch_kernel
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.many_starts import by_search
from freebody.inverse.problem import Found, Problem
from freebody.inverse.solutions import ALIKE
from freebody.inverse.workspace import distances
from freebody.targets import Kernel

_GRID = 33
"""Positions of the joint that are looked at first."""
_CLOSER = np.linspace(-1.0, 1.0, 9)
_ROUNDS = 6
"""How often the best of them are looked at closer, each time four times."""
_AT_ONCE = 500
"""Targets side by side, which bounds the memory."""


def by_self_motion(problem: Problem, form: ClosedFormArm) -> Found | None:
    """Of each branch the solution nearest to the reference, the nearest first; None where no kernel
    has the branches."""
    kernel = branch_kernel(problem.solver, form, in_front=False)
    if kernel is None:
        return None
    N = len(problem.target)
    parts = [
        _Nearest(problem.part(np.arange(at, min(at + _AT_ONCE, N))), form, kernel).found()
        for at in range(0, N, _AT_ONCE)
    ]
    q, miss = (np.concatenate([part[k] for part in parts]) for k in range(2))
    name = problem.solver.model.position_names[form.held or 0]
    notes = [
        f"The arm is redundant: of each branch the solution nearest to "
        f"{'q0' if problem.q0 is not None else 'the middle of the limits'}, nearest first; "
        f"redundancy= gives all branches for one position of {name!r}."
    ]
    found = Found(q, miss, form.names, form.method.replace("given", "chosen"), notes)
    lost = found.lost
    if len(lost):
        away, _ = distances(problem.part(lost), form)
        lost = lost[away == 0.0]
    return found.with_rows(lost, by_search(problem.part(lost))) if len(lost) else found


class _Nearest:
    """Some targets, and how far their solutions are from the reference."""

    def __init__(self, problem: Problem, form: ClosedFormArm, kernel: Kernel):
        self.problem, self.form, self.kernel = problem, form, kernel
        assert form.held is not None  # of such a form
        self.held = form.held
        self.low, self.high = (float(bound[self.held]) for bound in problem.solver.bounds)

    def found(self) -> tuple[Array, Array]:
        """(q (N, branches, nq), miss), sorted."""
        at, step = self._grid()
        N = len(self.problem.target)
        q, _, far = self._solved(np.broadcast_to(at, (N, len(at))))  # (N, G, branches)
        best = at[np.argmin(far, axis=1)]  # (N, branches)
        rows = np.flatnonzero(np.isfinite(far).any(axis=(1, 2)))
        q, miss = np.full((N, *q.shape[2:]), np.nan), np.full((N, q.shape[2]), np.nan)
        if len(rows):
            there = _Nearest(self.problem.part(rows), self.form, self.kernel)
            q[rows], miss[rows] = there._closer(best[rows], step)
        return q, miss

    def _closer(self, best: Array, step: float) -> tuple[Array, Array]:
        """The same from the best positions (N, branches) of a grid."""
        for _ in range(_ROUNDS):
            tried = best[..., None] + step * _CLOSER
            _, _, there = self._own(tried)
            nearest = np.argmin(there, axis=-1)[..., None]
            best = np.take_along_axis(tried, nearest, axis=-1)[..., 0]
            step /= 4.0
        tried = best[..., None] + step * np.array([-1.0, 0.0, 1.0])
        q, miss, there = self._own(np.concatenate([tried, self._vertex(tried)], axis=-1))
        chosen = np.argmin(there, axis=-1)[..., None]
        q = np.take_along_axis(q, chosen[..., None], axis=2)[:, :, 0]
        miss, far = (np.take_along_axis(x, chosen, axis=-1)[..., 0] for x in (miss, there))
        return self._sorted(q, np.where(np.isfinite(far), miss, np.nan), far)

    def _grid(self) -> tuple[Array, float]:
        middle = float(self.problem.reference[self.held])
        low = self.low if np.isfinite(self.low) else middle - np.pi
        high = self.high if np.isfinite(self.high) else middle + np.pi
        grid = np.linspace(low, high, _GRID)
        return np.append(grid, middle), float(grid[1] - grid[0])

    def _solved(self, held: Array) -> tuple[Array, Array, Array]:
        """(q (N, …, branches, nq), miss, distance from the reference, infinite where there is none
        within the limits) with the joint at held (N, …)."""
        problem = self.problem
        target = problem.target[(slice(None), *[None] * (held.ndim - 1))]
        q, miss, inside, _ = self.kernel(target, problem.reference, problem.rest, held)
        way = q - problem.reference
        far = np.sqrt(np.sum(way * way, axis=-1))
        good = np.isfinite(miss)
        if problem.limits != "ignore":
            good &= inside == 1.0
        return q, miss, np.where(good, far, np.inf)

    def _own(self, held: Array) -> tuple[Array, Array, Array]:
        """The same of each branch at its own positions (N, branches, G)."""
        q, miss, far = self._solved(held)
        b = np.arange(held.shape[1])
        q, miss, far = (np.moveaxis(x[:, b, :, b], 0, 1) for x in (q, miss, far))
        return q, miss, far

    def _vertex(self, tried: Array) -> Array:
        """Where the parabola through the squares of three distances has its vertex (N, branches,
        1)."""
        _, _, far = self._own(tried)
        with np.errstate(invalid="ignore", divide="ignore"):
            a, b, c = np.moveaxis(far * far, -1, 0)
            shift = 0.5 * (a - c) / (a - 2.0 * b + c)
        shift = np.clip(np.nan_to_num(shift), -1.0, 1.0)
        return (tried[..., 1] + shift * (tried[..., 2] - tried[..., 1]))[..., None]

    def _sorted(self, q: Array, miss: Array, far: Array) -> tuple[Array, Array]:
        """The nearest first, each once."""
        order = np.argsort(far, axis=-1, kind="stable")
        q = np.take_along_axis(q, order[..., None], axis=1)
        miss = np.take_along_axis(miss, order, axis=1)
        with np.errstate(invalid="ignore"):
            near = np.abs(q[:, :, None] - q[:, None]).max(axis=-1) < ALIKE
        again = np.tril(near, -1).any(axis=-1)
        return q, np.where(again, np.nan, miss)
