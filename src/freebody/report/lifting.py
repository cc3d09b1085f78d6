"""The largest payload that a robot holds at rest: along the motion of a study, and over the upright
plane of its worst instant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.algorithms.screws import chain_to
from freebody.arrays import Array
from freebody.figures.layers.bare_robot import sticks
from freebody.figures.plane_map import PlaneMap
from freebody.figures.snapshot import snapshot
from freebody.inverse.inverse_kinematics import inverse_kinematics
from freebody.inverse.problem.closed_form_arm import ClosedFormArm, closed_form_for
from freebody.inverse.problem.task import Task
from freebody.model.doubt_rules.aspects import EFFORTS, MASSES
from freebody.model.doubts import doubts_on
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.reach.payload_map import payload_map
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.positions import random_state

if TYPE_CHECKING:
    from freebody.report.study import Study

_CELLS = 61
"""Cells of the map, along each side."""
_SAMPLES = 400
"""Postures that tell how far the tip comes."""
_NEARLY_ALL = 0.75
"""Share of a side of the map: where less of it is reached, the map is made anew over that part."""
_THIN = 1e-6
"""Ratio of the sides of an area that is no more than a line."""


def lifting_along(study: Study) -> Array | None:
    """The largest payload (T,) at the tip at each posture of the motion; None without a tip, or
    where gravity or efforts set no limit."""
    model = study.model
    if not _mapped(study):
        return None
    mass = payload_map(model, study.motion.q).mass
    return mass if np.isfinite(mass).all() else None


@dataclass(frozen=True)
class UprightPlane:
    """An upright plane through the tip, as an even grid of points."""

    foot: Array
    """(dim,), the first body's origin, world axes: distances across are from there."""
    across: Array
    """(dim,), unit vector."""
    up: Array
    """(dim,), unit vector against gravity."""
    side: Array
    """(n,), m, of the columns."""
    height: Array
    """(m,), m, of the rows, above the world's origin."""
    points: Array
    """(m, n, dim), m, world axes."""

    def project(self, point: Array) -> Array:
        """The place (2,) of a point in the drawing, m: its distance across, and its height."""
        return np.array([(point - self.foot) @ self.across, point @ self.up])


@dataclass(frozen=True)
class PlaneOfPayloads:
    """The largest payload (m, n), kg, over a plane, the best of all postures at each point; NaN
    where none reaches it within the joint limits."""

    plane: UprightPlane
    mass: Array
    words: str
    """How the tip is oriented."""


def lifting_over_plane(study: Study) -> PlaneOfPayloads | None:
    """The largest payload over the upright plane of the worst instant; None for an arm without a
    closed form, or where nothing sets a limit."""
    if not _mapped(study):
        return None
    model, q = study.model, study.motion.q[study.worst.index]
    tip = model.frame().name
    form = _form(model, tip)
    if form is None:
        return None
    plane = _plane(model, tip, q)
    if plane is None:
        return None
    mass = _held(model, form, q, tip, plane)
    reached = np.isfinite(mass)
    if not reached.any():
        return None
    closer = _closer(plane, reached)
    if closer is not None:
        finer = _held(model, form, q, tip, closer)
        if np.isfinite(finer).any():
            plane, mass = closer, finer
    words = "oriented as at the worst instant" if form.task.angular else "in any orientation"
    if form.held is not None:
        words += f", {model.position_names[form.held]} as at that instant"
    return PlaneOfPayloads(plane, mass, words)


def _held(model: Model, form: ClosedFormArm, q: Array, tip: str, plane: UprightPlane) -> Array:
    """The largest payload (m, n), kg, at each point of a plane; NaN where there is none."""
    target = plane.points
    if form.task.angular:
        pose = forward_kinematics(model, q, tip)
        target = np.broadcast_to(pose, (*target.shape[:-1], *pose.shape)).copy()
        target[..., : model.dim, model.dim] = plane.points
    found = inverse_kinematics(
        model, target, tip, q0=q, redundancy=None if form.held is None else q[form.held]
    )
    good = found.valid & found.within_limits
    if not good.any():
        return np.full(plane.points.shape[:2], np.nan)
    mass = payload_map(model, np.nan_to_num(found.q), tip).mass
    best = np.where(good, mass, -1.0).max(axis=-1)
    return np.where((best < 0) | ~np.isfinite(best), np.nan, best)


def _closer(plane: UprightPlane, reached: Array) -> UprightPlane | None:
    """The plane over the part of it that is reached, with as many cells; None where that is nearly
    all."""
    ends = []
    for values, axis in ((plane.side, 0), (plane.height, 1)):
        there = np.flatnonzero(reached.any(axis=axis))
        step = values[1] - values[0]
        ends.append((values[there[0]] - step, values[there[-1]] + step))
    shares = [
        (high - low) / np.ptp(values)
        for (low, high), values in zip(ends, (plane.side, plane.height), strict=True)
    ]
    if min(shares) > _NEARLY_ALL:
        return None
    side, height = (np.linspace(low, high, _CELLS) for low, high in ends)
    across = side[:, None] - plane.side[0]
    up = height[:, None, None] - plane.height[0]
    return replace(
        plane,
        side=side,
        height=height,
        points=plane.points[0, 0] + across * plane.across + up * plane.up,
    )


def chart(study: Study, found: PlaneOfPayloads) -> PlaneMap:
    """The chart of payloads over a plane, with the robot at the worst instant."""
    model, plane = study.model, found.plane
    seen = snapshot(model, study.motion.q[study.worst.index])
    tip = study.data["tip_position"].values[study.worst.index]
    x, y = plane.project(tip)
    return PlaneMap(
        "Largest payload at rest, kg",
        "kg",
        plane.side,
        plane.height,
        found.mass,
        f"m from {model.bodies[0].joint.name}",
        "m above the origin",
        [(plane.project(a), plane.project(b)) for a, b in sticks(seen.pose)],
        (float(x), float(y)),
    )


def _mapped(study: Study) -> bool:
    """Whether a payload map tells something of a study's robot: one of open chains with a tip and a
    drive in every joint, under gravity, efforts limited, and no wrenches, of which it knows
    nothing."""
    model = study.model
    if model.tip is None or model.loops or model.passive or study.wrenches:
        return False
    limited = np.isfinite(ranges(model).effort).any()
    return bool(model.gravity.any()) and bool(limited) and not _wrong(model)


def _wrong(model: Model) -> bool:
    """Whether the model's masses or effort limits cannot be trusted."""
    return any(doubt.of.mend for doubt in doubts_on(model, MASSES, EFFORTS))


def _form(model: Model, tip: str) -> ClosedFormArm | None:
    """Closed form of the arm's inverse kinematics: for whole poses where there is one, else for
    points."""
    chain = chain_to(model.tree, tip)
    if chain is None or not len(chain.screws):
        return None
    every = Task(model.dim, tuple(range(3 * model.dim - 3)))
    enough = len(chain.screws) >= len(every.rows)
    task = every if enough else Task(model.dim, tuple(range(model.dim)))
    return closed_form_for(model, tip, task)


def _plane(model: Model, tip: str, q: Array) -> UprightPlane | None:
    """The upright plane through the first body's origin and the tip, as far as the tip comes; None
    where that stays on a line."""
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
    plane = at - (away @ across) * across - (away @ up) * up
    points = plane + side[:, None] * across + height[:, None, None] * up
    return UprightPlane(foot, across, up, side, height + foot @ up, points)
