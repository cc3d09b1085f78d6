"""Inverse kinematics of closed chains: the tip held at its target is one loop more, and every way
to close all of them is a working mode."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from freebody.arrays import Array
from freebody.inverse.problem.answer import gathered
from freebody.inverse.problem.numerical_solver import EXACT, NumericalSolver, descend
from freebody.inverse.problem.problem import Found, InverseProblem, found_in_turn
from freebody.inverse.problem.solutions import ALIKE, APART, Solutions, Verified, each_once, wrapped
from freebody.inverse.problem.workspace import Away, beyond_the_starts
from freebody.lazy import cached_property
from freebody.loops.dyad_decomposition import Decomposition, decomposed
from freebody.loops.equations import (
    closing,
    gaps,
    scaled_residual,
    within_tolerance,
)
from freebody.loops.scaled_equations import backward, length, rate_scale, shortest_way
from freebody.model.model import Model
from freebody.trees.states import integrate, random_state

_SHOWN = 8
"""Number of solutions that are returned of infinitely many."""
_CLOSED = 1e-11  # scaled loop equations of a solution
_ROUNDING = 1e-14
"""Rest of the scaled equations at which Newton's steps have nothing to gain."""
_SETTLING = (1.0, 30.0, 1e3, 1e4)
"""How much the loops count against the tip, one descent after the other, where the target is out of
reach."""


def of_closed_chain(
    problem: InverseProblem, batch: tuple[int, ...], away: Callable[[Array], Away] | None = None
) -> Solutions:
    """Working modes of a closed chain as solutions of inverse kinematics; away: the function that
    gives the distance of unreachable targets, by default a search."""
    work = _Held(problem)
    found = _searched(work) if work.plan is None else _by_dyads(work, work.plan)
    return gathered(problem, None, found, batch, away or work.away)


def _by_dyads(work: _Held, plan: Decomposition) -> Found:
    """Solutions in closed form by dyads, and from many starts where the pins of a dyad coincide."""
    problem = work.problem
    candidates, anywhere = plan.solve(np.tile(work.rest, (len(problem.target), 1)), problem.target)
    rows = np.flatnonzero(anywhere)
    if len(rows) < len(anywhere) or not len(anywhere):
        problem.refuse_search()
    solutions = work.verified(candidates, problem.target)
    nq = problem.solver.model.nq
    found = found_in_turn(solutions, work.named(solutions), nq, "dyads, in closed form", [])
    if not len(rows):
        return found
    searched = _searched(_Held(problem.part(rows)))
    if len(rows) == len(anywhere):
        return searched
    few = ", ".join(map(str, rows[:3])) + (", …" if len(rows) > 3 else "")
    notes = [f"Where pins of a dyad lie on one another (targets {few}): {searched.notes[0]}"]
    return replace(found.with_rows(rows, searched), notes=notes)


def unmeasured(target: Array) -> Away:
    """Distances NaN and a sentence for unreachable targets, where finding a distance would take
    longer than all solutions."""
    return np.full(len(target), np.nan), lambda _: "Out of reach."


def still_moves(problem: InverseProblem, q: Array) -> bool:
    """Whether the robot can move from a closed position q (nq,) while its tip stands still."""
    return _Held(problem).freedom(q) > 0


def _searched(work: _Held) -> Found:
    """Solutions found from many starts, the nearest to the reference first."""
    problem = work.problem
    starts = work.starts(problem.starts or 96)
    solutions = []
    for target in problem.target:
        goals = np.broadcast_to(target, (len(starts), *target.shape))
        q, _ = work.descend(goals, starts, 1.0, 80)
        solutions += work.verified(q[None], target[None], nearest_first=True)
    redundant = any(work.freedom(s.q[0]) for s in solutions if len(s.q))
    if redundant:
        solutions = [work.thinned(s) for s in solutions]
    notes = (
        [
            f"The robot can still move with its tip fixed: at most {_SHOWN} of infinitely many "
            f"solutions, nearest first."
        ]
        if redundant
        else [
            f"No closed form is known for this robot and task: what {len(starts)} starts found, "
            f"perhaps not all."
        ]
    )
    method = f"Levenberg–Marquardt from {len(starts)} starts, loops and tip together"
    names = [[""] * len(s.q) for s in solutions]
    return found_in_turn(solutions, names, problem.solver.model.nq, method, notes)


@dataclass(frozen=True, eq=False)
class _Held:
    """A closed chain whose tip is held at targets, as inverse kinematics of all its loops."""

    problem: InverseProblem

    @property
    def solver(self) -> NumericalSolver:
        """Numerical solver with frame and task."""
        return self.problem.solver

    @cached_property
    def plan(self) -> Decomposition | None:
        """Decomposition in dyads, for tasks that count a position in the plane, or a pose."""
        model, task = self.solver.model, self.solver.task
        if model.dim != 2 or task.rows not in ((0, 1), (0, 1, 2)):
            return None
        return decomposed(model, range(model.nq), self.solver.frame, oriented=len(task.rows) == 3)

    @cached_property
    def rest(self) -> Array:
        """The positions (nq,) from which coordinates start, and next to which they are wrapped."""
        return self.problem.reference

    def descend(
        self, target: Array, starts: Array, weight: float, iterations: int
    ) -> tuple[Array, Array]:
        """(q, remaining error) of descents from starts (N, nq) to targets (N, …)."""
        solver = self.solver

        def at(q: Array, rows: np.ndarray) -> tuple[Array, Array]:
            return solver.equations(q, target[rows], weight)

        def move(q: Array, step: Array) -> Array:
            return solver.moved(q, step * solver.rates)

        goal = 1e-14 if weight == 1.0 else 0.0
        return descend(at, starts, move, goal=goal, iterations=iterations)

    def starts(self, count: int) -> Array:
        """Starting positions (count, nq): the reference, some near it, and the others random."""
        model = self.solver.model
        q, noise, _ = random_state(model, self.problem.seed, count)
        if self.problem.q0 is not None:
            near = max(1, count // 2)
            spread = np.linspace(0.0, 0.5, near)[:, None]
            q[:near] = integrate(model, np.tile(self.problem.q0, (near, 1)), spread * noise[:near])
        return closing(model, q, range(model.nv))[0]

    # ------------------------------------------------------------ solutions
    def verified(self, q: Array, target: Array, *, nearest_first: bool = False) -> list[Verified]:
        """The solutions among candidates q (N, K, nq): those that reach their targets (N, …) with
        all loops closed, polished, wrapped, each once; in their order, or the nearest to the
        reference first."""
        model = self.solver.model
        rows = np.isfinite(q).all(axis=-1)
        q, miss, fine = q.copy(), np.full(rows.shape, np.inf), np.zeros(rows.shape, dtype=bool)
        if rows.any():
            goals = target[np.nonzero(rows)[0]]
            good = wrapped(self.solver, self._polished(q[rows], goals), self.rest)
            q[rows], miss[rows] = good, self.solver.miss(good, goals)
            fine[rows] = (miss[rows] <= EXACT) & self._closed(good)
        if nearest_first:
            far = np.where(fine, np.linalg.norm(q - self.rest, axis=-1), np.inf)
            order = np.argsort(far, axis=-1, kind="stable")
            q = np.take_along_axis(q, order[..., None], axis=1)
            miss, fine = (np.take_along_axis(x, order, axis=1) for x in (miss, fine))
        kept = each_once(fine, lambda rows, k: _apart(model, q[rows], q[rows, k][:, None]) <= APART)
        return [
            Verified(q[i, some], miss[i, some], some)
            for i, some in enumerate(map(np.flatnonzero, kept))
        ]

    def named(self, solutions: list[Verified]) -> list[list[str]]:
        """The branch names of each target's solutions, from the dyads."""
        assert self.plan is not None
        counts = [len(s.q) for s in solutions]
        every = np.concatenate([s.q for s in solutions]) if solutions else np.zeros((0, 0))
        if not len(every):
            return [[] for _ in solutions]
        names = self.plan.branches(every, np.repeat(self.problem.target, counts, axis=0))
        ends = np.cumsum([0, *counts])
        return [names[first:last] for first, last in pairwise(ends)]

    def _closed(self, q: Array) -> np.ndarray:
        model = self.solver.model
        if not len(q):
            return np.zeros(0, dtype=bool)
        left = np.abs(scaled_residual(model, q)).max(axis=-1, initial=0.0)
        closed = (left <= _CLOSED) & within_tolerance(model, q).all(axis=-1)
        return closed & ~backward(model, q).any(axis=-1)

    def _polished(self, q: Array, target: Array) -> Array:
        """Positions q after Newton steps, each kept only where it helped."""
        solver = self.solver
        q = q.copy()
        e, E = solver.equations(q, target)
        left = np.linalg.norm(e, axis=-1)
        for _ in range(4):
            rows = np.flatnonzero(left > _ROUNDING)
            if not len(rows):
                break
            step = (np.linalg.pinv(E[rows], rcond=1e-9) @ e[rows, :, None])[..., 0] * solver.rates
            trial = solver.moved(q[rows], step)
            errors, slopes = solver.equations(trial, target[rows])
            after = np.linalg.norm(errors, axis=-1)
            better = after < left[rows]
            kept = rows[better]
            q[kept], e[kept], E[kept] = trial[better], errors[better], slopes[better]
            left[kept] = after[better]
        return q

    def freedom(self, q: Array) -> int:
        """The number of motions that remain with the tip held."""
        _, E = self.solver.equations(q, self.solver.pose_and_jacobian(q)[0])
        return E.shape[-1] - int(np.linalg.matrix_rank(E, rtol=1e-8))

    def thinned(self, s: Verified) -> Verified:
        """A few well separated solutions out of infinitely many."""
        kept: list[int] = []
        for row in range(len(s.q)):
            if len(kept) < _SHOWN and all(
                _apart(self.solver.model, s.q[row], s.q[k]) > ALIKE for k in kept
            ):
                kept.append(row)
        return Verified(s.q[kept], s.miss[kept], s.row[kept])

    # ------------------------------------------------------------ out of reach
    def away(self, target: Array) -> Away:
        """Distances of targets (N, …) that cannot be reached, to the nearest closed position
        found."""
        near = 1e-7 * length(self.solver.model)
        found = [self._nearest(goal) for goal in target]
        sentences = []
        for goal, (distance, turned) in zip(target, found, strict=True):
            why = self.plan.obstacles(self.rest, goal[None]) if self.plan is not None else []
            sentences.append(" ".join([self._sentence(distance, turned, near), *why]))
        return np.array([d if d > near else 0.0 for d, _ in found]), sentences.__getitem__

    def _nearest(self, target: Array) -> tuple[float, float]:
        """The distance (m) and angle (rad) to a target that remain at the nearest closed position
        found."""
        model = self.solver.model
        q = self.starts(48)
        goals = np.broadcast_to(target, (len(q), *target.shape))
        for weight in _SETTLING:
            q, _ = self.descend(goals, q, weight, 60)
        q, _ = closing(model, q, range(model.nv))
        open_by = gaps(model, scaled_residual(model, q)).max(axis=-1)
        error = self.solver.task.error(self.solver.pose_and_jacobian(q)[0], goals)
        k = len(self.solver.task.linear)
        parts = [np.linalg.norm(part, axis=-1) for part in (error[:, :k], error[:, k:])]
        cost = np.where(open_by < 1e-9 * length(model), parts[0] + length(model) * parts[1], np.inf)
        best = int(np.argmin(cost))
        return float(parts[0][best]), float(parts[1][best])

    def _sentence(self, distance: float, turned: float, near: float) -> str:
        frame = f"frame {self.solver.frame!r} of {self.solver.model.name!r}"
        unseen = beyond_the_starts(self.solver)
        if unseen:
            return f"No solution was found for {frame}, at best {distance:.6g} m from it. {unseen}"
        if distance > near:
            return (
                f"Out of reach: the target is about {distance:.6g} m from the nearest point that "
                f"{frame} can reach with the loops closed."
            )
        if turned > 1e-6:
            return (
                f"Out of reach: at the target {frame} differs in orientation by at least about "
                f"{turned:.6g} rad."
            )
        return (
            f"No solution was found for {frame}, though the target lies at the edge of its reach."
        )


def _apart(model: Model, a: Array, b: Array) -> Array:
    """The largest difference (...) between positions (..., nq), as a rate, whole turns left out."""
    way = np.abs(rate_scale(model) * shortest_way(model, a, b))
    return np.asarray(way.max(axis=-1, initial=0.0))
