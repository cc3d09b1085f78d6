"""Solutions by a closed form: by a kernel of all branches side by side, with every candidate
checked for targets that it cannot decide; for arms of seven joints the solution of each branch
nearest to the reference, over their self-motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.near_reference import (
    ORTHOGONAL,
    JointRanges,
    solutions,
)
from freebody.arrays import Array
from freebody.elementary import absolute, less, where
from freebody.inverse.problem.closed_form import ClosedFormArm, over_arrays
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.problem import Found, InverseProblem, found_in_turn
from freebody.inverse.problem.solutions import ALIKE, turning_coordinates, verified
from freebody.inverse.problem.workspace import distances
from freebody.inverse.ways.many_starts import by_search
from freebody.model.model import Model
from freebody.program import Argument, trace
from freebody.spatial import identity
from freebody.targets import Kernel, compile_program

_NEARLY = 1e-6
"""How near (relative) a joint may be to standing anywhere, for a search of its other positions."""
_GRID = 33
"""Positions of the joint that are looked at first."""
_CLOSER = np.linspace(-1.0, 1.0, 9)
_ROUNDS = 6
"""How often the best of them are looked at closer, each time four times."""
_AT_ONCE = 500
"""Targets side by side, which bounds the memory."""


def by_closed_form(problem: InverseProblem, form: ClosedFormArm) -> Found:
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


def _by_steps(problem: InverseProblem, form: ClosedFormArm) -> tuple[Found, np.ndarray]:
    """Solutions from all candidates after forward kinematics, polishing and comparison; and flags
    of the joints (n,) that could stand anywhere."""
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
    form: ClosedFormArm, at_rest: Array, problem: InverseProblem
) -> tuple[Array, np.ndarray, Array]:
    """Unverified joint positions x (N, k, n) of the branches, NaN where there is none; flags (N, k,
    n) of joints that could stand anywhere and are at rest; margins of existence (N, k)."""
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


def notes(problem: InverseProblem, form: ClosedFormArm, free: np.ndarray) -> list[str]:
    """Notes on joints (n,) that could stand anywhere, and on joints that do not move the frame."""
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


def branch_kernel(
    solver: NumericalSolver, form: ClosedFormArm, in_front: bool = True
) -> Kernel | None:
    """(target, reference (nq,), rest (nq,), held?) -> (q (branches, nq), residual (branches,),
    within limits (branches,), count), compiled on first use; None for a form that gives
    candidates alone, or a coordinate that moves its joint by a multiple.

    target: the part that counts, see `ClosedFormArm.counted`. reference: next to it angles are
    wrapped; rest: of joints that do not move the frame. in_front: whether solutions stand before
    the branches there are none of, which are NaN; else each branch has its place. count: -1 where
    it is not clear which branches exist, or the target is no pose.
    """
    arm, model = form.branches, solver.model
    if not form.decides or (np.abs(arm.chain.ratio) != 1.0).any():
        return None
    key = ("solutions of inverse kinematics", solver.frame, arm.kind, in_front)
    found = model.compiled.get(key)
    if found is None:
        found = model.compiled[key] = _compiled(model, solver, form, in_front)
    return found


def _compiled(model: Model, solver: NumericalSolver, form: ClosedFormArm, in_front: bool) -> Kernel:
    arm, d, n = form.branches, form.branches.dim, model.nq
    low, high = (tuple(map(float, bound)) for bound in solver.bounds)
    known = JointRanges(low, high, tuple(map(bool, turning_coordinates(model))))

    def evaluate(target: Any, reference: Any, rest: Any, *held: Any) -> tuple[Any, ...]:
        R, p = form.of_counted(target)
        *found, count = solutions(arm, known, R, p, reference, rest, *held, in_front=in_front)
        if arm.kind == "pose":  # its last row too has to be a pose's
            for x, due in zip(target[d], identity(d + 1)[d], strict=True):
                count = where(less(absolute(x - due), 0.5 * ORTHOGONAL), count, -1.0)
        return (*found, count)

    inputs = [
        Argument("target", form.counted(np.eye(d + 1)).shape),
        Argument("reference", (n,)),
        Argument("rest", (n,)),
    ]
    if arm.held is not None:
        inputs.append(Argument("held", ()))
    B = arm.count
    outputs = [
        Argument("q", (B, n)),
        Argument("residual", (B,)),
        Argument("within", (B,)),
        Argument("count", ()),
    ]
    return compile_program(trace("inverse_kinematics", evaluate, inputs, outputs))


def by_self_motion(problem: InverseProblem, form: ClosedFormArm) -> Found | None:
    """The solution of each branch nearest to the reference along the arm's self-motion, the nearest
    first; None where there is no kernel of the branches."""
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
    """The search along an arm's self-motion for the solutions of some targets that are nearest to
    the reference."""

    def __init__(self, problem: InverseProblem, form: ClosedFormArm, kernel: Kernel):
        self.problem, self.form, self.kernel = problem, form, kernel
        assert form.held is not None  # of such a form
        self.held = form.held
        self.low, self.high = (float(bound[self.held]) for bound in problem.solver.bounds)

    def found(self) -> tuple[Array, Array]:
        """Solutions nearest to the reference, sorted: (q (N, branches, nq), miss)."""
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
        """Solutions nearest to the reference, sought about the best positions (N, branches) of a
        grid."""
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
        """(q (N, …, branches, nq), miss, distance from the reference, infinite where no solution is
        within the limits) with the held joint at `held` (N, …)."""
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
        """(q, miss, distance from the reference) of each branch at held positions of its own (N,
        branches, G), as from `_solved`."""
        q, miss, far = self._solved(held)
        b = np.arange(held.shape[1])
        q, miss, far = (np.moveaxis(x[:, b, :, b], 0, 1) for x in (q, miss, far))
        return q, miss, far

    def _vertex(self, tried: Array) -> Array:
        """The offset of the vertex of the parabola through the squares of three distances (N,
        branches, 1)."""
        _, _, far = self._own(tried)
        with np.errstate(invalid="ignore", divide="ignore"):
            a, b, c = np.moveaxis(far * far, -1, 0)
            shift = 0.5 * (a - c) / (a - 2.0 * b + c)
        shift = np.clip(np.nan_to_num(shift), -1.0, 1.0)
        return (tried[..., 1] + shift * (tried[..., 2] - tried[..., 1]))[..., None]

    def _sorted(self, q: Array, miss: Array, far: Array) -> tuple[Array, Array]:
        """Solutions sorted by distance from the reference, with repeated ones marked by NaN."""
        order = np.argsort(far, axis=-1, kind="stable")
        q = np.take_along_axis(q, order[..., None], axis=1)
        miss = np.take_along_axis(miss, order, axis=1)
        with np.errstate(invalid="ignore"):
            near = np.abs(q[:, :, None] - q[:, None]).max(axis=-1) < ALIKE
        again = np.tril(near, -1).any(axis=-1)
        return q, np.where(again, np.nan, miss)
