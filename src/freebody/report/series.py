"""The time series of a study: torques with their parts, powers, reactions, energies, the tip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.any_chain.dynamics import inverse_dynamics, joint_wrenches, static_torque
from freebody.arrays import Array
from freebody.figures.skeleton import mass_and_centre
from freebody.loops.drive_torques import drive_torques
from freebody.model.doubts import DYNAMIC, attribute, doubts_used
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.motion.friction import drive_arrays
from freebody.motion.motion import Motion
from freebody.motion.ranges import angular
from freebody.report import energy, jacobians
from freebody.report.bearings import bearing_loads
from freebody.report.variables import dataset
from freebody.spatial import add, times
from freebody.trees import dynamics, kinematics

if TYPE_CHECKING:
    import xarray as xr

Values = dict[str, Any]
"""Arrays by the names of variables."""


def series(model: Model, motion: Motion) -> xr.Dataset:
    """The dataset that `Study.data` describes."""
    found: Values = {}
    for part in (_motion, torques, _reactions, _bodies, energy.energies):
        found |= part(model, motion)
    if (tip := model.tip) is not None:
        found |= _tip(model, tip, motion) | jacobians.measures(model, tip, motion.q)
    found |= energy.powers(model, found, motion)
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
    """The names along each dimension, and the units that differ by coordinate."""
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


def torque_parts(model: Model, motion: Motion) -> xr.Dataset:
    """Of the dataset that `Study.data` describes: motion and torques with their parts."""
    return dataset(_motion(model, motion) | torques(model, motion), coordinates(model, motion.t))


def _motion(model: Model, motion: Motion) -> Values:
    return {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd}


def torques(model: Model, motion: Motion) -> Values:
    """The drives' torque, and the parts that sum to it, each computed by a formula of its own."""
    q, qd, qdd = motion.q, motion.qd, motion.qdd
    viscous, _, rotor = drive_arrays(model)
    M = dynamics.mass_matrix(model, q)
    C = dynamics.coriolis_matrix(model, q, qd)
    gravity = dynamics.gravity_torque(model, q)
    springs = static_torque(model.opened, q) - gravity
    rotors = rotor * qdd
    parts = {
        "tau": inverse_dynamics(model, q, qd, qdd),
        "tau_inertial": np.einsum("tij,tj->ti", M, qdd) - rotors,
        "tau_coriolis": np.einsum("tij,tj->ti", C, qd),
        "tau_gravity": gravity,
        "tau_friction": viscous * qd + _coulomb(model, qd),
        "tau_viscous": viscous * qd,
        "tau_springs": springs,
        "tau_rotors": rotors,
    }
    if model.loops:  # what the drives feel of each part through the loops
        parts |= {
            name: drive_torques("study", model, q, value)
            for name, value in parts.items()
            if name != "tau"
        }
    return parts


def _coulomb(model: Model, qd: Array) -> Array:
    """Σ ratio c sign(ratio q̇) = |ratio| c sign(q̇)."""
    return drive_arrays(model)[1] * np.sign(qd)


def _reactions(model: Model, motion: Motion) -> Values:
    at, d = (motion.q, motion.qd, motion.qdd), model.dim
    world = joint_wrenches(model, *at, reference="world")
    child = joint_wrenches(model, *at, reference="child")
    parts = world[..., :d], world[..., d:], child[..., :d], child[..., d:]
    names = "force", "moment", "force_child", "moment_child"
    found = {f"reaction_{name}": part for name, part in zip(names, parts, strict=True)}
    return found | bearing_loads(model, *parts[2:])


def _bodies(model: Model, motion: Motion) -> Values:
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


def _tip(model: Model, tip: str, motion: Motion) -> Values:
    d = model.dim
    T = kinematics.forward_kinematics(model, motion.q, tip)
    V = kinematics.velocity(model, motion.q, motion.qd, tip)
    return {
        "tip_position": T[..., :d, d],
        "tip_velocity": V[..., :d],
        "tip_angular_velocity": V[..., d:],
    }
