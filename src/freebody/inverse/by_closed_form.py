"""Solutions by a closed form.

Of many targets by the kernel that has all branches side by side; of few, and of those that are not
clear to it, with every step looked at.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from freebody.algorithms.closed_form_inverse.solve import branches
from freebody.arrays import Array
from freebody.inverse.branch_names import joined
from freebody.inverse.closed_form import ClosedFormSolver, Displacement
from freebody.inverse.numerical_solver import EXACT
from freebody.inverse.problem import Found, Problem, found_in_turn
from freebody.inverse.solutions import verified, wrapped
from freebody.kernels.formulas import Option
from freebody.kernels.lookup import fetch
from freebody.trees.states import neutral

MANY = 256
"""Targets from which on a kernel is worth its compiling."""

_CLEAR = 1e-6
"""By how much (relative) a branch must clear its bounds, to be one for sure or none."""


def by_closed_form(problem: Problem, form: ClosedFormSolver, X: Displacement) -> Found:
    """All solutions of a form for the displacements X of the problem's targets."""
    N = len(problem.target)
    found, rows = _by_kernel(problem, form) if N >= MANY else (None, np.arange(N))
    free = np.zeros(len(form.screws), dtype=bool)
    if found is None:
        found, free = _by_steps(problem, form, X)
    elif len(rows):
        some = replace(problem, target=problem.target[rows])
        closer, free = _by_steps(some, form, Displacement(X.R[rows], X.p[rows]))
        found = found.with_rows(rows, closer)
    return replace(found, notes=_notes(problem, form, free))


def _by_steps(
    problem: Problem, form: ClosedFormSolver, X: Displacement
) -> tuple[Found, np.ndarray]:
    """Every candidate put through forward kinematics, polished and compared with the others; which
    joints (n,) could stand anywhere."""
    solver, chain = problem.solver, form.chain
    rest = np.zeros(solver.model.nq) if problem.q0 is None else problem.q0
    with np.errstate(invalid="ignore"):
        candidates = form.solve(X, chain.positions(rest))
    q = chain.coordinates(candidates.x, _beside(problem))
    solutions = verified(solver, q, problem.target, problem.reference)
    free = np.zeros(len(form.screws), dtype=bool)
    for i, s in enumerate(solutions):
        free |= candidates.free[i][s.row].any(axis=0)
    nameless = [[""] * len(s.q) for s in solutions]
    found = found_in_turn(solutions, nameless, solver.model.nq, form.name(), [])
    return _named(form, found), free


def _by_kernel(problem: Problem, form: ClosedFormSolver) -> tuple[Found | None, np.ndarray]:
    """The branches of the formula, and the targets of which not all are clear; None where it has no
    recipe for this arm and task."""
    solver, target = problem.solver, problem.target
    known = branches(solver.model.tree, solver.frame, solver.task.rows)
    if known is None or known.held is not None:
        return None, np.arange(len(target))
    option = Option(solver.frame, rows=solver.task.rows)
    q, valid, clearance = fetch(solver.model, ("inverse_kinematics",), option)(target)
    there = valid == 1.0
    reached = q[there]
    beside = np.ones(solver.model.nq, dtype=bool)
    beside[known.chain.index] = False
    reached[:, beside] = _beside(problem)[beside]
    reached = wrapped(solver, reached, problem.reference)
    miss = np.full(there.shape, np.nan)
    miss[there] = solver.miss(reached, np.repeat(target, there.sum(axis=-1), axis=0))
    q[there] = reached
    clear = (np.abs(clearance) > _CLEAR) & ((clearance > 0) == there) & ~(miss > EXACT)
    found = Found(q, miss, np.full(there.shape, ""), form.name(), [])
    return _named(form, found), np.flatnonzero(~clear.all(axis=-1))


def _named(form: ClosedFormSolver, found: Found) -> Found:
    """With the branches' names."""
    there = np.isfinite(found.miss)
    names = joined(form.label(form.chain.positions(found.q[there])), (int(there.sum()),))
    whole = np.full(there.shape, "", dtype=names.dtype)
    whole[there] = names
    return replace(found, branches=whole)


def _beside(problem: Problem) -> Array:
    """q (nq,) of what does not move the frame."""
    solver = problem.solver
    if problem.q0 is not None:
        return problem.q0
    return np.clip(neutral(solver.model), *solver.bounds)


def _notes(problem: Problem, form: ClosedFormSolver, free: np.ndarray) -> list[str]:
    """Which joints (n,) could stand anywhere, and which do not matter."""
    solver, index = problem.solver, form.chain.index
    names = solver.model.position_names
    notes = [
        f"Joint {names[index[k]]!r} may take any angle at this target, the others compensate: "
        f"infinitely many solutions, of which one is given for each branch, with the joint's angle "
        f"in q0 (0 without q0)."
        for k in np.flatnonzero(free)
    ]
    idle = solver.moving.copy()
    idle[index] = False
    if idle.any():
        listed = ", ".join(repr(names[k]) for k in np.flatnonzero(idle))
        notes.append(f"Not changed, because they do not move the target point: {listed}.")
    return notes
