"""The time series of a study: torques with their parts, powers, reactions, energies, the tip.

Reactions are split in the axes of their joint: about (along) it the parent exerts on the child what
the drive gives, less what friction, spring and rotor take; all else is carried by the bearing, or
the guide.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.any_chain.dynamics import inverse_dynamics, joint_wrenches
from freebody.arrays import Array
from freebody.capacity.torque_parts import torques
from freebody.design.joint_loads import joint_loads
from freebody.figures.skeleton import mass_and_centre
from freebody.loops import forces as closed
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.doubts import attribute, doubts_used
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.motion.motion import Motion
from freebody.motion.ranges import angular, with_drive
from freebody.motion.smooth_friction import (
    without_friction,
)
from freebody.report import jacobians
from freebody.report.variables import dataset
from freebody.spatial import add, times
from freebody.trees import dynamics, kinematics

if TYPE_CHECKING:
    import xarray as xr

_ArraysByName = dict[str, Any]
"""Arrays by the names of variables."""


def series(model: Model, motion: Motion, wrenches: Mapping[str, Array] | None = None) -> xr.Dataset:
    """The dataset that `Study.data` describes, under constant wrenches on the robot, by frame."""
    found: _ArraysByName = {}
    for part in (_motion, _bodies, _energies):
        found |= part(model, motion)
    for loaded in (torques, _reactions):
        found |= loaded(model, motion, wrenches)
    if (tip := model.tip) is not None:
        found |= _tip(model, tip, motion) | jacobians.measures(model, tip, motion.q)
    found |= _powers(model, found, motion)
    about = {
        "title": f"Dynamic study of {model.name}",
        "robot": model.name,
        "tip": tip or "",
        "motion": motion.source,
        "conventions": "SI units; world axes unless said; reactions act on the child, by the "
        "parent, at the child's joint origin",
        **attribute(doubts_used(model, *DYNAMIC)),
    }
    return dataset(found, coordinates(model, motion.t), about, tip=tip or "")


def coordinates(model: Model, t: Array | None = None) -> dict[str, Any]:
    """The labels along each dimension, and the units that differ by coordinate."""
    turns = angular(model)
    axes = list("xyz"[: model.dim])
    named: dict[str, Any] = {
        "coordinate": list(model.velocity_names),
        "position": list(model.position_names),
        "joint": list(model.reaction_names),
        "body": [body.name for body in model.bodies],
        "axis": axes,
        "moment_axis": axes if model.dim == 3 else ["z"],
        "unit": ("coordinate", np.where(turns, "rad", "m")),
        "effort_unit": ("coordinate", np.where(turns, "N m", "N")),
    }
    times = {"time": ("time", t, {"units": "s", "long_name": "time"})}
    return named if t is None else {**times, **named}


def _motion(model: Model, motion: Motion) -> _ArraysByName:
    return {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd}


def _reactions(model: Model, motion: Motion, wrenches: Mapping[str, Array] | None) -> _ArraysByName:
    at, d = (motion.q, motion.qd, motion.qdd, wrenches), model.dim
    world = joint_wrenches(model, *at, reference="world")
    child = joint_wrenches(model, *at, reference="child")
    parts = world[..., :d], world[..., d:], child[..., :d], child[..., d:]
    names = "force", "moment", "force_child", "moment_child"
    found = {f"reaction_{name}": part for name, part in zip(names, parts, strict=True)}
    return found | joint_loads(model, *parts[2:])


def _bodies(model: Model, motion: Motion) -> _ArraysByName:
    tree: Tree = model.tree
    world = world_poses(tree, joint_poses(tree, tuple(motion.q.T)))
    origins, centres = [], []
    for i in tree.body_of:
        R, p = world[i]
        _, centre = mass_and_centre(tree.bodies[i].masses, model.dim)
        origins.append(_columns(p, len(motion.t)))
        centres.append(_columns(add(p, times(R, tuple(centre))), len(motion.t)))
    return {"body_origin": np.stack(origins, axis=1), "body_com": np.stack(centres, axis=1)}


def _columns(vector: tuple[Any, ...], samples: int) -> Array:
    return np.stack([np.broadcast_to(x, (samples,)) for x in vector], axis=-1)


def _tip(model: Model, tip: str, motion: Motion) -> _ArraysByName:
    d = model.dim
    T = kinematics.forward_kinematics(model, motion.q, tip)
    V = kinematics.velocity(model, motion.q, motion.qd, tip)
    return {
        "tip_position": T[..., :d, d],
        "tip_velocity": V[..., :d],
        "tip_angular_velocity": V[..., d:],
    }


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_MOST_PARTS = 64


def _energies(model: Model, motion: Motion) -> dict[str, Any]:
    """Kinetic and potential energy, and the error of the energy balance.

    The residual is ∫ (τ - τ_friction) · q̇ dt - (E(t) - E(0)), the integral by Gauss's rule with 6
    points in each interval of the motion's curve, or in parts of it.
    """
    kinetic = dynamics.kinetic_energy(model, motion.q, motion.qd)
    potential = dynamics.potential_energy(model, motion.q)
    total = kinetic + potential
    work = supplied_work(model, motion)
    return {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "supplied_work": work,
        "energy_residual": work - (total - total[0]),
    }


def supplied_work(model: Model, motion: Motion) -> Array:
    """The work ∫ (τ - τ_friction) · q̇ dt up to each sample (T,); intervals are halved until the
    integral no longer changes."""
    smooth = without_friction(model)  # τ - τ_friction, free of the jumps of sign(q̇)
    parts, coarse = 1, _integral(smooth, motion, 1)
    while parts < _MOST_PARTS:
        parts *= 2
        fine = _integral(smooth, motion, parts)
        change, size = np.abs(fine - coarse).max(), np.abs(fine).max()
        coarse = fine
        if change <= 1e-12 * size:
            break
    return coarse


def _integral(model: Model, motion: Motion, parts: int) -> Array:
    """The work up to each sample, by Gauss's rule with `parts` equal parts between knots."""
    knots = motion.knots
    h = np.diff(knots)[:, None] / parts
    starts = knots[:-1, None] + h * np.arange(parts)
    q, qd, qdd = motion.at(starts[..., None] + 0.5 * h[..., None] * (1.0 + _NODES))
    torques = closed.torques if model.loops else inverse_dynamics
    power = np.sum(torques(model, q, qd, qdd) * qd, axis=-1)
    work = np.concatenate([[0.0], np.cumsum(np.sum(0.5 * h * (power @ _WEIGHTS), axis=-1))])
    return work[np.searchsorted(knots, motion.t)]


def _powers(model: Model, found: dict[str, Any], motion: Motion) -> dict[str, Any]:
    """The mechanical power of each drive, their sum, and the power lost in friction, from the
    torques found; joints without a drive have none."""
    power = np.where(with_drive(model), found["tau"] * motion.qd, 0.0)
    friction = np.sum(found["tau_friction"] * motion.qd, axis=-1)
    return {"power": power, "motor_power": power.sum(axis=-1), "friction_power": friction}
