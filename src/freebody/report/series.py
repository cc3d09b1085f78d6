"""The time series of a study: torques with their parts, powers, reactions, energies, the tip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.kinematics import joint_poses, world_poses
from freebody.arrays import Array
from freebody.loops.dynamics import drive_torques
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.motion.motion import Motion
from freebody.motion.ranges import angular
from freebody.report import energy, jacobians
from freebody.report.bearings import bearing_loads
from freebody.spatial import add, scale, times
from freebody.trees import dynamics, kinematics

if TYPE_CHECKING:
    import xarray as xr

_TORQUE = "N m|N"


def series(model: Model, tip: str, motion: Motion) -> xr.Dataset:
    """The dataset that `Study.data` describes."""
    import xarray as xr

    variables: dict[str, Any] = {}
    for part in (_motion, torques, _reactions, _bodies, energy.energies):
        variables |= part(model, motion)
    variables |= _tip(model, tip, motion) | jacobians.measures(model, tip, motion.q)
    variables |= energy.powers(model, variables, motion)
    return xr.Dataset(
        _variables(variables),
        coordinates(model, motion.t),
        {
            "title": f"Dynamic study of {model.name}",
            "robot": model.name,
            "tip": tip,
            "motion": motion.source,
            "conventions": "SI units; world axes unless said; reactions act on the child, "
            "by the parent, at the "
            "child's joint origin",
        },
    )


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
    return (
        named if t is None else {"time": ("time", t, {"units": "s", "long_name": "time"}), **named}
    )


def torque_parts(model: Model, motion: Motion) -> xr.Dataset:
    """Of the dataset that `Study.data` describes: motion and torques with their parts."""
    import xarray as xr

    found = _motion(model, motion) | torques(model, motion)
    return xr.Dataset(_variables(found), coordinates(model, motion.t))


def _variables(found: dict[str, Any]) -> dict[str, Any]:
    return {
        name: (dims, value, {"units": units, "long_name": text})
        for name, (dims, value, units, text) in found.items()
    }


def _motion(model: Model, motion: Motion) -> dict[str, Any]:
    at = ("time", "coordinate")
    return {
        "q": (("time", "position"), motion.q, "rad|m|1", "position"),
        "qd": (at, motion.qd, "rad/s|m/s", "rate"),
        "qdd": (at, motion.qdd, "rad/s²|m/s²", "acceleration"),
    }


def torques(model: Model, motion: Motion) -> dict[str, Any]:
    """The drives' torque, and the parts that sum to it, each computed by a formula of its own."""
    q, qd, qdd = motion.q, motion.qd, motion.qdd
    viscous, _, rotor = drive_arrays(model)
    M = dynamics.mass_matrix(model, q)
    C = dynamics.coriolis_matrix(model, q, qd)
    gravity = dynamics.gravity_torque(model, q)
    springs = dynamics.static_torque(model.opened, q) - gravity
    rotors = rotor * qdd
    parts = {
        "tau": (dynamics.inverse_dynamics(model, q, qd, qdd), "torque or force of the drive"),
        "tau_inertial": (
            np.einsum("tij,tj->ti", M, qdd) - rotors,
            "inertia of the bodies, M q̈ without rotors",
        ),
        "tau_coriolis": (np.einsum("tij,tj->ti", C, qd), "Coriolis and centrifugal part, C q̇"),
        "tau_gravity": (gravity, "gravity part, g"),
        "tau_friction": (viscous * qd + _coulomb(model, qd), "friction, viscous and Coulomb"),
        "tau_viscous": (viscous * qd, "viscous friction, which tau_friction includes"),
        "tau_springs": (springs, "springs"),
        "tau_rotors": (rotors, "inertia of the rotors seen through their gears"),
    }
    if model.loops:  # what the drives feel of each part through the loops
        parts |= {
            name: (drive_torques("study", model, q, value), text)
            for name, (value, text) in parts.items()
            if name != "tau"
        }
    return {
        name: (("time", "coordinate"), value, _TORQUE, text)
        for name, (value, text) in parts.items()
    }


def drive_arrays(model: Model) -> tuple[Array, Array, Array]:
    """Viscous and Coulomb friction and rotor inertia of each coordinate (nv,); what followers add
    is included.

    The Coulomb entry is the largest that the coordinate can feel.
    """
    arrays = np.zeros((3, model.nv))
    for body in model.tree.bodies:
        if body.drive is not None:
            at, d = body.coordinates, body.drive
            arrays[:, at.v[0]] += (
                d.viscous * at.ratio**2,
                d.coulomb * abs(at.ratio),
                d.rotor * at.ratio**2,
            )
    return arrays[0], arrays[1], arrays[2]


def _coulomb(model: Model, qd: Array) -> Array:
    """Σ ratio c sign(ratio q̇) = |ratio| c sign(q̇)."""
    return drive_arrays(model)[1] * np.sign(qd)


def _reactions(model: Model, motion: Motion) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for reference, suffix, axes in (
        ("world", "", "world axes"),
        ("child", "_child", "axes of the child"),
    ):
        w = dynamics.joint_wrenches(model, motion.q, motion.qd, motion.qdd, reference=reference)  # type: ignore[arg-type]
        for name, dim, part, units in (
            ("reaction_force", "axis", w[..., : model.dim], "N"),
            ("reaction_moment", "moment_axis", w[..., model.dim :], "N m"),
        ):
            what = f"{name.replace('_', ' ')} on the child at its joint, {axes}"
            found[name + suffix] = (("time", "joint", dim), part, units, what)
    child = (found[f"reaction_{what}_child"][1] for what in ("force", "moment"))
    return found | bearing_loads(model, *child)


def _bodies(model: Model, motion: Motion) -> dict[str, Any]:
    tree: Tree = model.tree
    world = world_poses(tree, joint_poses(tree, tuple(motion.q.T)))
    origins, centres = [], []
    for i in tree.body_of:
        R, p = world[i]
        masses = tree.bodies[i].masses
        total = sum(mass.m for mass in masses)
        c = p
        if total:
            moment = add(*(scale(mass.m, mass.c) for mass in masses))
            c = add(p, times(R, scale(1.0 / total, moment)))
        origins.append(_columns(p, len(motion.t)))
        centres.append(_columns(c, len(motion.t)))
    at = ("time", "body", "axis")
    return {
        "body_origin": (at, np.stack(origins, axis=1), "m", "origin of the body's joint"),
        "body_com": (
            at,
            np.stack(centres, axis=1),
            "m",
            "centre of mass of the body (its origin if massless)",
        ),
    }


def _columns(vector: tuple[Any, ...], samples: int) -> Array:
    return np.stack([np.broadcast_to(x, (samples,)) for x in vector], axis=-1)


def _tip(model: Model, tip: str, motion: Motion) -> dict[str, Any]:
    d = model.dim
    T = kinematics.forward_kinematics(model, motion.q, tip)
    V = kinematics.velocity(model, motion.q, motion.qd, tip)
    return {
        "tip_position": (("time", "axis"), T[..., :d, d], "m", f"position of {tip}"),
        "tip_velocity": (("time", "axis"), V[..., :d], "m/s", f"velocity of {tip}"),
        "tip_angular_velocity": (
            ("time", "moment_axis"),
            V[..., d:],
            "rad/s",
            f"angular velocity of {tip}",
        ),
    }
