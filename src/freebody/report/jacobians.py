"""Singular values of the tip's Jacobian: how near the arm comes to a singular pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.singular_thresholds import CALLED_SINGULAR, RANK
from freebody.arrays import Array
from freebody.loops.closure_checks import scaled_jacobian
from freebody.loops.scaled_equations import null_space, rate_scale
from freebody.model.model import Model
from freebody.model.shafts import shafts
from freebody.motion.ranges import angular
from freebody.report.results import Singularity
from freebody.trees import kinematics

if TYPE_CHECKING:
    import xarray as xr


def _bodies_before(model: Model, frame: str) -> list[int]:
    """The body that carries a frame, followed by the bodies between it and the ground."""
    found, body = [], model.frame(frame).body
    while body >= 0:
        found.append(body)
        body = model.bodies[body].parent
    return found


def _coordinates_before(model: Model, frame: str) -> list[int]:
    """Indices of the velocity coordinates that move a frame, in the order of q̇; shafts of flexible
    joints are none."""
    gone = shafts(model)
    bodies = (i for i in _bodies_before(model, frame) if i not in gone)
    return sorted({k for i in bodies for k in model.coordinates[i].v})


def task(model: Model, tip: str, q: Array) -> tuple[int, str]:
    """The number of rows of the Jacobian that are used along q (T, nq), and their name.

    All of them if the tip has that many coordinates to move it; else the rows of position alone,
    unless the tip's position leaves some coordinate unseen all the time (a tip on the last axis).
    """
    six, d = (6, 3) if model.dim == 3 else (3, 2)
    columns = _coordinates_before(model, tip)
    everything = six, "position and orientation"
    if model.loops:
        freedom = null_space(scaled_jacobian(model, q[len(q) // 2]), RANK)[0].shape[1]
        return everything if freedom >= six else (d, "position")
    if len(columns) >= six or not columns:
        return everything
    ranks = np.linalg.matrix_rank(kinematics.jacobian(model, q, tip)[..., :d, columns], rtol=1e-9)
    return (d, "position") if int(ranks.max()) == min(d, len(columns)) else everything


def characteristic_length(model: Model, tip: str, q: Array) -> float:
    """Root mean square of the tip's distance from the first joint's origin over q (T, nq) (m); 1
    where that is zero."""
    d = model.dim
    T = kinematics.forward_kinematics(model, q, tip)[..., :d, d]
    bodies = _bodies_before(model, tip)
    first = model.bodies[bodies[-1]].name if bodies else tip
    base = kinematics.forward_kinematics(model, q[:1], first)[..., :d, d]
    length = float(np.sqrt(np.mean(np.sum((T - base) ** 2, axis=-1))))
    return length if length > 1e-9 else 1.0


def scaled(model: Model, tip: str, q: Array) -> Array:
    """The used rows of the Jacobian (..., rows, n) without units: lengths divided by the
    characteristic length.

    Columns are those that move the tip; sliding ones are multiplied by the length, so that all are
    per radian. Of a closed chain they are the motions that the loops allow.
    """
    rows, _ = task(model, tip, q)
    length = characteristic_length(model, tip, q)
    columns = _coordinates_before(model, tip)
    if model.loops:
        J = kinematics.jacobian(model, q, tip)[..., :rows, :] * rate_scale(model)
        J[..., : model.dim, :] /= length
        return np.stack(
            [j @ null_space(A, RANK)[0] for j, A in zip(J, scaled_jacobian(model, q), strict=True)]
        )
    J = kinematics.jacobian(model, q, tip)[..., :rows, columns].copy()
    J[..., : model.dim, :] /= length
    J[..., :, ~angular(model)[columns]] *= length
    return J


def measures(model: Model, tip: str, q: Array) -> dict[str, Any]:
    """Singular values of the scaled Jacobian along q (T, nq), and their product (Yoshikawa's
    manipulability)."""
    J = scaled(model, tip, q) if _coordinates_before(model, tip) else np.zeros((len(q), 1, 0))
    values = np.linalg.svd(J, compute_uv=False) if J.shape[-1] else np.zeros((len(q), 1))
    return {
        "smallest_singular_value": values[:, -1],
        "largest_singular_value": values[:, 0],
        "manipulability": values.prod(axis=-1),
    }


def singularity(model: Model, tip: str, data: xr.Dataset) -> Singularity:
    """The instant of the motion at which the smallest singular value is least."""
    smallest = data["smallest_singular_value"].values
    k = int(np.argmin(smallest))
    low, high = float(smallest[k]), float(data["largest_singular_value"].values[k])
    q = data["q"].values
    _, rows = task(model, tip, q)
    time = float(data["time"].values[k])
    length = characteristic_length(model, tip, q)
    if (smallest <= CALLED_SINGULAR * data["largest_singular_value"].values).all():
        text = (
            "The tip's Jacobian is rank-deficient throughout the motion: some joint never moves "
            "the tip."
        )
    elif low <= CALLED_SINGULAR * high:
        text = (
            f"At t = {time:.3g} s the tip cannot move in some direction: "
            "the arm is at or very near a singularity."
        )
    else:
        text = f"The motion stays clear of singularities; it is nearest to one at t = {time:.3g} s."
    return Singularity(k, time, low, high, rows, length, text)
