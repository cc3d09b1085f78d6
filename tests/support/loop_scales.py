"""Loop equations and rates in one unit: lengths are divided by the mechanism's longest part, so
that they compare with angles."""

from __future__ import annotations

import numpy as np

import freebody as fb
from support.helpers import numbers


def longest(model: fb.Model) -> float:
    """The farthest that a joint or frame is placed from the one before, or a rod is long (m)."""
    tree = model.tree
    offsets = [body.p for body in tree.bodies] + [p for _, _, p in tree.frames.values()]
    offsets += [(loop.distance,) for loop in tree.loops]
    return max(float(np.linalg.norm(np.array(p, dtype=float))) for p in offsets) or 1.0


def rate_scale(model: fb.Model) -> np.ndarray:
    """Divisors (nv,) that make angles of rates."""
    found = np.ones(model.nv)
    for body in model.tree.bodies:
        for k, (angular, _) in zip(body.coordinates.v, body.columns, strict=True):
            found[k] = 1.0 if np.any(angular) else longest(model)
    return found


def row_scale(model: fb.Model) -> np.ndarray:
    """Factors (m,) that make angles of loop equations."""
    of_length: list[bool] = []
    for loop in model.tree.loops:
        turns = len(loop.closure.turns)
        of_length += [True] * (loop.closure.size(model.tree.space) - turns) + [False] * turns
    return np.where(of_length, 1.0 / longest(model), 1.0)


def residual(model: fb.Model, q: np.ndarray) -> np.ndarray:
    """How far loops are open at q (..., nq), as angles (..., m)."""
    return row_scale(model) * numbers(model, "constraint", q)
