"""Solutions by a closed form: by the kernel that has all branches side by side, and of targets that
are not clear to it with every candidate looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.inverse.branch_kernel import branch_kernel
from freebody.inverse.closed_form import ClosedFormArm, over_arrays
from freebody.inverse.many_starts import by_search
from freebody.inverse.problem import Found, Problem, found_in_turn
from freebody.inverse.solutions import verified

_NEARLY = 1e-6
"""How near (relative) a joint may be to standing anywhere, for a search of its other positions."""


def by_closed_form(problem: Problem, form: ClosedFormArm) -> Found:
    """All solutions of a form for the problem's targets."""
    target = problem.target
    kernel = None if problem.alone else branch_kernel(problem.solver, form)
    free = np.zeros(len(form.chain.screws), dtype=bool)
    if kernel is None:
        found, free = _by_steps(problem, form)
    else:
        held = [] if problem.held is None else [problem.held]
        q, residual, _, count = kernel(form.counted(target), problem.reference, problem.rest, *held)
        found = Found(q, residual, form.names, form.method, [])
        rows = np.flatnonzero(count < 0)
        if len(rows):
            closer, free = _by_steps(problem.part(rows), form)
            found = found.with_rows(rows, closer)
    return replace(found, notes=notes(problem, form, free))


def _by_steps(problem: Problem, form: ClosedFormArm) -> tuple[Found, np.ndarray]:
    """Every candidate put through forward kinematics, polished and compared with the others; which
    joints (n,) could stand anywhere."""
    solver, chain = problem.solver, form.chain
    at_rest = chain.positions(np.zeros(solver.model.nq) if problem.q0 is None else problem.q0)
    x, free, clear = candidates(form, at_rest, problem)
    q = chain.coordinates(x, problem.rest)
    if form.held is not None and problem.held is not None:
        q[..., form.held] = problem.held[:, None]
    solutions = verified(solver, q, problem.target, problem.reference)
    loose = np.zeros(len(chain.screws), dtype=bool)
    for i, s in enumerate(solutions):
        loose |= free[i][s.row].any(axis=0)
    found = found_in_turn(solutions, None, solver.model.nq, form.method, [])
    found = replace(found, names=form.names)
    # with fewer joints than rows a joint that could stand anywhere, or nearly so, gives one member
    # of a family, of which another may have the rows that are left over
    if len(solver.task.rows) > len(chain.screws):
        rows = found.lost[(np.abs(clear[found.lost]) < _NEARLY).any(axis=1)]
        if len(rows):
            found = found.with_rows(rows, by_search(problem.part(rows)))
    return found, loose


def candidates(
    form: ClosedFormArm, at_rest: Array, problem: Problem
) -> tuple[Array, np.ndarray, Array]:
    """The branches' joint positions x (N, k, n), none of them verified, NaN where there is none;
    which joints could stand anywhere (N, k, n) and are at rest; how clear the branches are (N,
    k)."""
    N, held = len(problem.target), problem.held
    if not problem.alone:
        given = [] if held is None else [held]
        x, free, clear = form.candidates(form.counted(problem.target), at_rest, *given)
        return x, free != 0.0, clear
    with np.errstate(all="ignore"):
        R, p = form.branches.in_space(over_arrays(problem.target))
        ways = form.resting(at_rest.tolist(), R, p, held)
        x = [[np.broadcast_to(place.value(), N) for place in places] for places, _ in ways]
    free = [[np.broadcast_to(place.free, N) != 0.0 for place in places] for places, _ in ways]
    clear = [np.broadcast_to(clear, N) for _, clear in ways]
    x, free, clear = (np.moveaxis(np.array(part), -1, 0) for part in (x, free, clear))
    return x, free, clear


def notes(problem: Problem, form: ClosedFormArm, free: np.ndarray) -> list[str]:
    """Which joints (n,) could stand anywhere, and which do not matter."""
    solver, index = problem.solver, form.chain.index
    names = solver.model.position_names
    found = [
        f"Joint {names[index[k]]!r} may take any angle at this target, the others compensate: "
        f"infinitely many solutions, of which one is given for each branch, with the joint's angle "
        f"in q0 (0 without q0)."
        for k in np.flatnonzero(free)
    ]
    idle = solver.moving.copy()
    idle[index] = False
    if idle.any():
        listed = ", ".join(repr(names[k]) for k in np.flatnonzero(idle))
        found.append(f"Not changed, because they do not move the target point: {listed}.")
    return found
