"""What the robot can lift where: along the motion, and over an upright plane through its tip."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from freebody.algorithms.screws import chain_to
from freebody.arrays import Array
from freebody.figures.drawing import Drawing
from freebody.figures.map_diagram import map_diagram
from freebody.inverse.kinematics import inverse_kinematics
from freebody.inverse.problem.closed_form import ClosedFormArm, closed_form_for
from freebody.inverse.problem.task import Task
from freebody.model.doubts import EFFORTS, MASSES, doubts_on
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.reach.payload_map import payload_map
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.states import random_state

if TYPE_CHECKING:
    from freebody.report.study import Study

_CELLS = 41
"""Of the map, along each side."""
_SAMPLES = 400
"""Postures that tell how far the tip comes."""
_THIN = 1e-6
"""Of an area that is no more than a line."""
TITLE = "Largest payload at rest (kg)"


def along(study: Study) -> Array | None:
    """The largest mass (T,) at the tip at each posture of the motion; None without a tip, and where
    gravity or efforts say nothing of it."""
    model = study.model
    if model.tip is None or model.loops or model.passive or not model.gravity.any():
        return None
    if not np.isfinite(ranges(model).effort).any() or _wrong(model):
        return None
    mass = payload_map(model, study.motion.q).mass
    return mass if np.isfinite(mass).all() else None


def over_plane(study: Study) -> tuple[Drawing, str] | None:
    """The map, of all branches the best, and words on how the tip is turned in it; None for an arm
    without a closed form."""
    model, q = study.model, study.motion.q[study.worst.index]
    tip = model.frame().name
    form = None if _wrong(model) else _form(model, tip)
    if form is None:
        return None
    points = _plane(model, tip, q)
    if points is None:
        return None
    oriented, held = bool(form.task.angular), form.held
    target = points
    if oriented:
        pose = forward_kinematics(model, q, tip)
        target = np.broadcast_to(pose, (*points.shape[:-1], *pose.shape)).copy()
        target[..., : model.dim, model.dim] = points
    found = inverse_kinematics(
        model, target, tip, q0=q, redundancy=None if held is None else q[held]
    )
    good = found.valid & found.within_limits
    if not good.any():
        return None
    mass = payload_map(model, np.nan_to_num(found.q), tip).mass
    best = np.where(good, mass, -1.0).max(axis=-1)
    best[(best < 0) | ~np.isfinite(best)] = np.nan
    words = "oriented as at the worst instant" if oriented else "in any orientation"
    if held is not None:
        words += f", {model.position_names[held]} as at that instant"
    return map_diagram(model, points, best, q, title=TITLE).drawing, words


def _wrong(model: Model) -> bool:
    """Whether its masses or effort limits cannot be trusted."""
    return any(doubt.of.mend for doubt in doubts_on(model, MASSES, EFFORTS))


def _form(model: Model, tip: str) -> ClosedFormArm | None:
    """For whole poses, else for points."""
    chain = chain_to(model.tree, tip)
    if chain is None or not len(chain.screws):
        return None
    every = Task(model.dim, tuple(range(3 * model.dim - 3)))
    enough = len(chain.screws) >= len(every.rows)
    task = every if enough else Task(model.dim, tuple(range(model.dim)))
    return closed_form_for(model, tip, task)


def _plane(model: Model, tip: str, q: Array) -> Array | None:
    """An even grid of points (n, n, dim): across, and up against gravity; None where the tip stays
    on a line."""
    up = -np.asarray(model.gravity) / np.linalg.norm(model.gravity)
    some, _, _ = random_state(model, 0, _SAMPLES)
    places = forward_kinematics(model, some, tip)[:, : model.dim, model.dim]
    at = forward_kinematics(model, q, tip)[: model.dim, model.dim]
    foot = forward_kinematics(model, q, model.bodies[0].name)[: model.dim, model.dim]
    away = at - foot
    across = away - (away @ up) * up
    if np.linalg.norm(across) < 1e-6 * max(1.0, float(np.linalg.norm(away))):
        across = np.eye(model.dim)[int(np.argmin(np.abs(up)))]
        across = across - (across @ up) * up
    across /= np.linalg.norm(across)
    ways = places - foot
    heights = ways @ up
    radius = float(np.linalg.norm(ways - heights[:, None] * up, axis=-1).max())
    side = np.linspace(-1.05 * radius, 1.05 * radius, _CELLS)
    span = float(np.ptp(heights))
    if min(radius, span) <= _THIN * max(radius, span):
        return None
    height = np.linspace(heights.min() - 0.05 * span, heights.max() + 0.05 * span, _CELLS)
    plane = foot + (at - foot) - (away @ across) * across - (away @ up) * up
    return plane + side[:, None] * across + height[:, None, None] * up
