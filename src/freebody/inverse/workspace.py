"""How far a target is out of reach, and what to say about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from freebody.arrays import Array
from freebody.inverse.closed_form import ClosedFormArm
from freebody.inverse.numerical_solver import NumericalSolver
from freebody.inverse.problem import Problem
from freebody.inverse.reach_distance import exact_distances
from freebody.inverse.solutions import turning_coordinates
from freebody.inverse.task import Task
from freebody.trees.states import random_state

_STARTS = 48
_KEPT = 12
"""Of the starts those that are nearest when each has gone most of its way are followed to the
end."""
_AT_ONCE = 256
"""Targets looked at side by side, which bounds the memory."""
_NEAR = 1e-7  # nearer than this (in arm lengths) is reached

Away = tuple[Array, Callable[[int], str]]
"""Distances (N,) of targets from what can be reached, and a sentence for each."""


def distances(problem: Problem, form: ClosedFormArm | None) -> Away:
    """Of the targets of a problem, which have no solution; the distance is 0 where only the
    orientation is wrong."""
    solver, count = problem.solver, len(problem.target)
    if not solver.task.linear:
        return np.zeros(count), lambda _: "The frame cannot reach this orientation."
    away = exact_distances(problem, form)
    how = "" if away is not None else "about "
    if away is None:
        parts = range(0, count, _AT_ONCE)
        away = np.concatenate([_searched(solver, problem.target[k : k + _AT_ONCE]) for k in parts])
    out = away > _NEAR * solver.length
    given = None if form is None or problem.held is None else form.held
    also = "" if given is None else f" and {solver.model.position_names[given]!r} where it is given"

    def sentence(k: int) -> str:
        return _sentence(solver, away[k], out[k], how, also)

    return np.where(out, away, 0.0), sentence


def _searched(solver: NumericalSolver, target: Array) -> Array:
    """Distances by many descents; of the position alone where the orientation cannot be had."""
    away, turned = _nearest(solver, target)
    if solver.task.angular and (turned > 1e-6).any():
        places = replace(solver, task=Task(solver.task.dim, solver.task.linear))
        away = np.where(turned > 1e-6, _nearest(places, target)[0], away)
    return away


def _sentence(solver: NumericalSolver, distance: float, out: bool, how: str, also: str) -> str:
    frame = f"frame {solver.frame!r} of {solver.model.name!r}"
    unseen = beyond_the_starts(solver)
    if unseen:
        return f"No solution was found for {frame}, at best {distance:.6g} m from it. {unseen}"
    if out:
        oriented = f" with this orientation{also}" if solver.task.angular else ""
        return (
            f"Out of reach: the target is {how}{distance:.6g} m from the nearest point that "
            f"{frame} can reach{oriented}."
        )
    if solver.task.angular:
        return (
            f"The position is within reach of {frame}, but not with this orientation{also}; "
            'task="position" leaves the orientation free.'
        )
    return f"No solution was found for {frame}, though the target lies at the edge of its reach."


def beyond_the_starts(solver: NumericalSolver) -> str:
    """What to say of angles whose turns differ and have no limits, as those of screws: starts lie
    within one turn of them, so that what is not found may be there; "" without such."""
    model, again = solver.model, turning_coordinates(solver.model)
    limited = np.logical_and(*map(np.isfinite, solver.bounds))
    names = [
        model.position_names[k]
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None and body.kind.nq == body.kind.nv
        for k, angular in zip(at.q, body.kind.angular, strict=True)
        if angular and not again[k] and not limited[k]
    ]
    if not names:
        return ""
    return (
        f"Starts lie within ±π of {', '.join(names)}, where each turn leads elsewhere: set limits, "
        "or give q0= near a solution."
    )


def _nearest_rows(cost: Array) -> np.ndarray:
    """Of the costs of all starts, target by target, the rows of the least of each target."""
    by_target = cost.reshape(-1, _STARTS)
    best = np.argpartition(by_target, _KEPT, axis=-1)[:, :_KEPT]
    return (best + _STARTS * np.arange(len(by_target))[:, None]).ravel()


def _nearest(solver: NumericalSolver, target: Array) -> tuple[Array, Array]:
    """(distance, angle) left (N,) by the best of many descents in which an angle counts a
    thousandfold."""
    q, _, _ = random_state(solver.model, 1, _STARTS)
    starts, goals = np.tile(q, (len(target), 1)), np.repeat(target, _STARTS, axis=0)
    q, cost = solver.solve(goals, starts, weight=30.0, iterations=30)
    rows, goals = _nearest_rows(cost), np.repeat(target, _KEPT, axis=0)
    q, _ = solver.solve(goals, q[rows], weight=30.0, iterations=60)
    q, cost = solver.solve(goals, q, weight=1000.0, iterations=100)
    best = np.argmin(cost.reshape(len(target), _KEPT), axis=-1)
    q = q.reshape(len(target), _KEPT, -1)[np.arange(len(target)), best]
    error = solver.task.error(solver.pose_and_jacobian(q)[0], target)
    k = len(solver.task.linear)
    return np.linalg.norm(error[:, :k], axis=-1), np.linalg.norm(error[:, k:], axis=-1)
