"""The torques of drives along a motion, split into parts that each have a formula of their own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics, static_torque
from freebody.arrays import Array
from freebody.loops.forces import drive_torques
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.smooth_friction import (
    friction_torque,
    lost_torque,
    motor_springs,
    rotor_torque,
    strut_damping,
    viscous_torque,
)
from freebody.trees import dynamics, kinematics


def torque_parts(
    model: Model, motion: Motion, wrenches: Mapping[str, Array] | None = None
) -> dict[str, Any]:
    """The time, q, qd, qdd and `torques` of a motion, by their names in a study's data."""
    states = {"time": motion.t, "q": motion.q, "qd": motion.qd, "qdd": motion.qdd}
    return states | torques(model, motion, wrenches)


def torques(
    model: Model, motion: Motion, wrenches: Mapping[str, Array] | None = None
) -> dict[str, Any]:
    """The drives' torque, and the parts that sum to it, each computed by a formula of its own;
    wrenches: constant ones on the robot, by frame."""
    q, qd, qdd = motion.q, motion.qd, motion.qdd
    M = dynamics.mass_matrix(model, q)
    C = dynamics.coriolis_matrix(model, q, qd)
    gravity = dynamics.gravity_torque(model, q)
    springs = static_torque(model.opened, q) - gravity - friction_torque(model, q, 0.0 * qd)
    # of followers with a ratio that changes a rotor turns faster also at constant rates
    rotors, swung = rotor_torque(model, q, 0.0 * qd, qdd), rotor_torque(model, q, qd, 0.0 * qdd)
    inertial = np.einsum("tij,tj->ti", M, qdd) - rotors
    coriolis = np.einsum("tij,tj->ti", C, qd) - swung
    viscous, dampers = viscous_torque(model, q, qd), np.zeros(qd.shape)
    if model.struts:
        dampers = strut_damping(model, q, qd)
    sent = inertial + coriolis + gravity + springs - motor_springs(model, q, qd) + dampers
    pulls = {"tau_wrenches": pull_torque(model, q, wrenches)} if wrenches else {}
    lost = lost_torque(model, qd, sum(pulls.values(), sent))
    parts = {
        "tau": inverse_dynamics(model, q, qd, qdd, wrenches),
        "tau_inertial": inertial,
        "tau_coriolis": coriolis,
        "tau_gravity": gravity,
        "tau_friction": friction_torque(model, q, qd) + lost,
        "tau_viscous": viscous + dampers,
        "tau_springs": springs,
        "tau_rotors": rotors + swung,
        **pulls,
    }
    if model.loops:  # what the drives feel of each part through the loops
        parts |= {
            name: drive_torques("study", model, q, value)
            for name, value in parts.items()
            if name != "tau"
        }
    return parts


def pull_torque(model: Model, q: Array, wrenches: Mapping[str, Array]) -> Array:
    """Torques that balance wrenches on a robot (..., nv), its loops cut: -Jᵀ w."""
    pulled = [
        np.einsum("...ij,i->...j", kinematics.jacobian(model.opened, q, frame), w)
        for frame, w in wrenches.items()
    ]
    return -np.sum(pulled, axis=0)
