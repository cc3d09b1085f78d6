"""The variables of a study: dimensions, unit and meaning of each, for data, files and page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.design.joint_loads import JOINT_LOADS

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Variable:
    """A variable of a dataset: the names of its dimensions, its unit and its meaning.

    A unit such as "rad|m" is the first for a turning joint and the second for a sliding one. A
    name that ends in _fraction is that of a share of a limit, one in _share that of another share.
    """

    dims: tuple[str, ...]
    unit: str
    meaning: str


_EFFORT, _SPEED, _POSITION = "N m|N", "rad/s|m/s", "rad|m"
PARTS = {
    "tau_inertial": "inertia",
    "tau_coriolis": "Coriolis",
    "tau_gravity": "gravity",
    "tau_friction": "friction",
    "tau_springs": "springs",
    "tau_rotors": "rotors",
    "tau_wrenches": "wrenches",
}
"""The parts that a torque is the sum of, and what they are called in a legend; that of wrenches is
there where a wrench is."""

_CONDITION = "singular value of the tip's Jacobian, lengths over the characteristic length"

_BY_DIMENSIONS: dict[str, dict[str, tuple[str, str]]] = {
    "time position": {"q": ("rad|m|1", "position")},
    "time coordinate": {
        "qd": (_SPEED, "rate"),
        "qdd": ("rad/s²|m/s²", "acceleration"),
        "tau": (_EFFORT, "torque or force of the drive"),
        "tau_inertial": (_EFFORT, "inertia of the bodies, M q̈ without rotors"),
        "tau_coriolis": (_EFFORT, "Coriolis and centrifugal part, C q̇"),
        "tau_gravity": (_EFFORT, "gravity part, g"),
        "tau_friction": (_EFFORT, "friction, of all its laws"),
        "tau_viscous": (_EFFORT, "viscous friction, which tau_friction includes"),
        "tau_springs": (_EFFORT, "springs"),
        "tau_rotors": (_EFFORT, "inertia of the rotors seen through their gears"),
        "tau_wrenches": (_EFFORT, "what balances the wrenches on the robot, -Jᵀ w"),
        "power": ("W", "mechanical power of the drive"),
        "tau_measured": (_EFFORT, "torque or force as it was measured"),
    },
    "time joint axis": {
        "reaction_force": ("N", "reaction force on the child at its joint, world axes"),
        "reaction_force_child": ("N", "reaction force on the child at its joint, child's axes"),
    },
    "time joint moment_axis": {
        "reaction_moment": ("N m", "reaction moment on the child at its joint, world axes"),
        "reaction_moment_child": ("N m", "reaction moment on the child at its joint, child's axes"),
    },
    "time joint": JOINT_LOADS,
    "time body axis": {
        "body_origin": ("m", "origin of the body's joint"),
        "body_com": ("m", "centre of mass of the body (its origin if massless)"),
    },
    "time axis": {
        "tip_position": ("m", "position of {tip}"),
        "tip_velocity": ("m/s", "velocity of {tip}"),
    },
    "time moment_axis": {"tip_angular_velocity": ("rad/s", "angular velocity of {tip}")},
    "time": {
        "kinetic_energy": ("J", "kinetic energy, rotors included"),
        "potential_energy": ("J", "potential energy of gravity and springs"),
        "supplied_work": (
            "J",
            "work of the torques and of wrenches less friction losses",
        ),
        "energy_residual": ("J", "supplied work less the gain in energy"),
        "motor_power": ("W", "mechanical power of all drives"),
        "friction_power": ("W", "power dissipated by friction"),
        "smallest_singular_value": ("1", f"smallest {_CONDITION}"),
        "largest_singular_value": ("1", f"largest {_CONDITION}"),
        "manipulability": ("1", "product of the singular values"),
    },
    "coordinate": {
        "peak_torque": (_EFFORT, "largest torque or force in magnitude, with its sign"),
        "peak_torque_time": ("s", "when the torque is largest"),
        "peak_torque_segment": ("1", "segment of a duty cycle in which the torque is largest"),
        "measured_rms_difference": (_EFFORT, "root mean square of computed less measured torque"),
        "measured_difference_share": ("1", "that difference over the RMS of the measured torque"),
        "rms_torque": (_EFFORT, "root mean square of the torque: the measure of motor heating"),
        "peak_speed": (_SPEED, "largest speed, between samples too"),
        "peak_speed_time": ("s", "when the speed is largest"),
        "peak_speed_segment": ("1", "segment of a duty cycle in which the speed is largest"),
        "peak_power": ("W", "largest mechanical power; negative where the drive brakes"),
        "peak_power_time": ("s", "when the power is largest"),
        "peak_power_segment": ("1", "segment of a duty cycle in which the power is largest"),
        "mean_power": ("W", "mean mechanical power, braking counted as negative"),
        "gravity_torque_peak": (_EFFORT, "largest gravity part of the torque"),
        "work_done": ("J", "work that the drive does: torque and speed have the same sign"),
        "work_braked": ("J", "work that the drive absorbs in braking"),
        "net_work": ("J", "work done less braked: over a full cycle, what is lost to friction"),
        "regenerated_share": ("1", "work braked over work done: what could be fed back"),
        "lowest": (_POSITION, "least position"),
        "highest": (_POSITION, "greatest position"),
        "position_fraction": ("1", "distance from the middle of the range, 1 (100 %) at a limit"),
        "velocity_fraction": ("1", "peak speed over its limit, exceeded above 1 (100 %)"),
        "effort_fraction": ("1", "peak torque over its limit, exceeded above 1 (100 %)"),
        "rms_fraction": ("1", "RMS torque over the effort limit"),
        "power_fraction": ("1", "peak power over effort limit times speed limit"),
        "lower_limit": (_POSITION, "lower limit of the position"),
        "upper_limit": (_POSITION, "upper limit of the position"),
        "velocity_limit": (_SPEED, "speed limit"),
        "effort_limit": (_EFFORT, "effort limit"),
        "worst_gravity_torque": (_EFFORT, "largest gravity load in any pose within the limits"),
        "worst_gravity_fraction": ("1", "gravity load in the worst pose over the effort limit"),
    },
    "joint": {
        **{f"peak_{name}": (unit, f"largest {what}") for name, (unit, what) in JOINT_LOADS.items()},
        **{
            f"peak_{name}_time": ("s", f"when it is largest: {what}")
            for name, (_, what) in JOINT_LOADS.items()
        },
        "peak_force": ("N", "largest reaction force of the parent on the child, its magnitude"),
        "peak_force_time": ("s", "when the reaction force is largest"),
        "peak_moment": ("N m", "largest reaction moment at the joint's origin, its magnitude"),
        "peak_moment_time": ("s", "when the reaction moment is largest"),
    },
    "": {
        "total_work_done": ("J", "work done, each drive with a supply of its own"),
        "total_work_braked": ("J", "work braked, each drive with a supply of its own"),
        "total_net_work": ("J", "work done less work braked, all drives"),
        "shared_work_done": ("J", "work done, all drives on one supply"),
        "shared_work_braked": ("J", "work braked, all drives on one supply"),
        "total_regenerated_share": ("1", "work braked over work done"),
        "total_peak_power": ("W", "peak of the summed power"),
    },
    "body": {"body_mass": ("kg", "mass of the body{estimated}")},
    "body axis": {
        "body_com_local": ("m", "centre of mass from the joint, the body's axes at its joint"),
        "body_weight": ("N", "weight, world axes"),
    },
    "coordinate position": {"worst_gravity_pose": ("rad|m|1", "pose of the largest gravity load")},
    "check": {
        "check_value": ("1", "value of the check"),
        "check_bar": ("1", "largest value that passes"),
        "check_passed": ("1", "1 if the check passed, else 0"),
    },
    "edge": {"replay_edge": ("s", "where pieces of the replay meet")},
    "piece": {
        "replay_factor": ("1", "amplification in the piece"),
        "replay_miss": ("1", "deviation at the end of the piece, relative to the joint range"),
    },
    "drift_time coordinate": {"drift": (_POSITION, "distance from the motion, open loop")},
}

VARIABLES = {
    name: Variable(tuple(dims.split()), unit, meaning)
    for dims, group in _BY_DIMENSIONS.items()
    for name, (unit, meaning) in group.items()
}
"""All variables of a study, by name."""


def dataset(
    values: Mapping[str, Any],
    coordinates: Mapping[str, Any],
    about: Mapping[str, str] | None = None,
    **words: str,
) -> xr.Dataset:
    """A dataset of variables by name; words: the texts for the names in braces in their
    meanings."""
    import xarray as xr

    variables = {}
    for name, value in values.items():
        of = VARIABLES[name]
        attributes = {"units": of.unit, "long_name": of.meaning.format(**words)}
        variables[name] = (of.dims, np.asarray(value, dtype=float), attributes)
    return xr.Dataset(variables, coordinates, about)
