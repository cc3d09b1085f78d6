"""Inverse kinematics of the members of a family, side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.answer import gathered
from freebody.inverse.descent_kernel import descent_kernel
from freebody.inverse.from_nearby import (
    Follow,
    NearbyForm,
    difference,
    farther,
    followed,
    form_near,
)
from freebody.inverse.problem import Problem
from freebody.inverse.solutions import Solutions
from freebody.kernels import structural
from freebody.kernels.formulas import Option
from freebody.model.families import Members
from freebody.model.model import Model
from freebody.trees.states import random_state

_MOST = 0.05
"""How far (rad, arm lengths) members may be from the first to be followed from there."""

One = Callable[[Problem], Solutions]
"""What solves a problem of one member."""


def of_family(model: Model, given: Problem, batch: tuple[int, ...], one: One) -> Solutions:
    """See `fb.inverse_kinematics`; given: the problem for the first member, whose targets are of a
    batch that broadcasts with the family."""
    try:
        whole = np.broadcast_shapes(batch, model.family)
    except ValueError:
        raise FreebodyError(
            f"inverse_kinematics: the batch shapes do not broadcast together: target {batch}, "
            f"model.family {model.family}."
        ) from None
    core = given.target.shape[-2:]
    target = np.broadcast_to(given.target.reshape(*batch, *core), (*whole, *core))
    problem = replace(given, target=target.reshape(-1, *core))
    count = int(np.prod(model.family))
    member = np.broadcast_to(np.arange(count).reshape(model.family), whole).reshape(-1)
    pieces, rows = _side_by_side(model, problem, member)
    notes = [note for _, s in pieces for note in s.notes]
    for k in np.unique(member[rows]):
        own = rows[member[rows] == k]
        index = tuple(map(int, np.unravel_index(k, model.family)))
        solver = replace(problem.solver, model=model[index])
        pieces.append((own, one(replace(problem.part(own), solver=solver, alone=True))))
    lost = sum(int((s.count == 0).sum()) for _, s in pieces)
    if lost:
        notes.append(f"{lost} of {len(member)} have no solution, see distance.")
    return _joined(pieces, whole, model.nq, tuple(notes))


Piece = tuple[np.ndarray, Solutions]
"""Rows of the batch, and what was found for them."""


def _side_by_side(
    model: Model, problem: Problem, member: np.ndarray
) -> tuple[list[Piece], np.ndarray]:
    """What is sure for all members at once; the rows for which nothing is."""
    every = np.arange(len(problem.target))
    solver, task = problem.solver, problem.solver.task
    limits = [body.joint.limits for body in model.bodies]
    differ = any(isinstance(x, Members) for one in limits for x in (one.lower, one.upper))
    if model.loops or problem.searched or differ:
        return [], every
    known = form_near(solver.model, solver.frame, task)
    if known is None or not len(every):
        return [], every
    names = ("forward_kinematics", "jacobian")
    bound = structural.fetch(model, names, Option(solver.frame))
    numbers = bound.numbers[0].reshape(-1, bound.numbers[0].shape[-1])

    def poses(q: Array, rows: np.ndarray) -> tuple[Array, Array]:
        T, J = bound.kernel(q, numbers[member[rows]])
        return T, J[..., list(task.rows), :]

    q, _, _ = random_state(solver.model, 2, 16)
    T, _ = bound.kernel(q[:, None], numbers)
    apart = np.array([difference(known.form, solver, q, T[:, k]) for k in range(len(numbers))])
    near = np.flatnonzero(apart < _MOST)
    some = np.flatnonzero(np.isin(member, near))
    if not len(some):
        return [], every
    known = farther(known, float(apart[near].max()))
    step = descent_kernel(model, solver.frame, task.rows, solver.columns)
    own = None if step is None else step.numbers[0].reshape(len(numbers), -1)[member[some]]
    follow = Follow(lambda q, rows: poses(q, some[rows]), step, own)
    found, sure = followed(problem.part(some), known, follow)
    good = np.flatnonzero(sure & np.isfinite(found.miss).any(axis=-1))
    if not len(good):
        return [], every
    part = replace(found, q=found.q[good], miss=found.miss[good], notes=[*found.notes, _of(known)])
    solved = gathered(problem.part(some[good]), known.form, part, (len(good),))
    return [(some[good], solved)], np.setdiff1d(every, some[good])


def _of(known: NearbyForm) -> str:
    return (
        f"Members differ by up to {known.differs:.2g} (rad, arm lengths) from the arm whose "
        f"branches were followed."
    )


def _joined(
    pieces: list[Piece], batch: tuple[int, ...], nq: int, notes: tuple[str, ...]
) -> Solutions:
    """What was found for all rows of a batch."""
    M = int(np.prod(batch))
    k = max((len(s) for _, s in pieces), default=0)
    q, residual = np.full((M, k, nq), np.nan), np.full((M, k), np.nan)
    within, names = np.zeros((M, k), dtype=bool), np.full((M, k), "", dtype=object)
    distance = np.zeros(M)
    for rows, s in pieces:
        for whole, part in (
            (q, s.q),
            (residual, s.residual),
            (within, s.within_limits),
            (names, s.branches),
        ):
            whole[rows, : len(s)] = part
        distance[rows] = s.distance
    return Solutions(
        q.reshape(*batch, k, nq),
        names.astype(str).reshape(*batch, k),
        residual.reshape(*batch, k),
        within.reshape(*batch, k),
        distance.reshape(batch),
        "; ".join(dict.fromkeys(s.method for _, s in pieces)) or "no targets",
        notes,
    )
