"""`study`: the main job. A robot and a motion in; kinematics, loads, energies, checks and a replay out, as data."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.report.results import Check, Replay, Singularity, StaticPose, Worst

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[str, float], None]
"""Called with what is being done and the fraction that is done."""


@dataclass(frozen=True, eq=False)
class Study:
    """A robot's dynamic study: everything a report shows, as data.

    Names of dimensions: `time` (T samples), `coordinate` (nv; model.velocity_names), `position` (nq; position_names),
    `joint` (model.joint_names; joint i carries body i), `body` (names of the bodies), `axis` (x, y, z; x, y in the plane),
    `moment_axis` (x, y, z; z in the plane). Every variable has the attributes `units` and `long_name`; where units
    differ by coordinate they are "rad|m" and the like, and the coordinate arrays `unit` (rad or m) and `effort_unit`
    (N m or N) along `coordinate` say which.
    """

    model: Model
    tip: str
    """Frame whose position, velocity and Jacobian are studied."""
    tip_reason: str
    """One sentence: which frame is the tip and why."""
    motion: Motion
    data: xr.Dataset
    """Time series. (time, position): q. (time, coordinate): qd, qdd, tau and its parts tau_inertial (M q̈ of the bodies),
    tau_coriolis, tau_gravity, tau_friction, tau_springs, tau_rotors, which sum to tau; power. (time, joint, axis | moment_axis):
    reaction_force, reaction_moment (world axes, on the child, by the parent, at the child's joint origin), and with
    suffix _child in the child's axes. (time, body, axis): body_origin, body_com. (time, axis): tip_position, tip_velocity.
    (time,): kinetic_energy, potential_energy, motor_power, friction_power, energy_residual, smallest_singular_value,
    manipulability."""
    summary: xr.Dataset
    """(coordinate,): peak_torque, peak_torque_time, rms_torque, peak_speed, peak_power, peak_power_time, mean_power,
    lowest, highest, gravity_torque_peak, and with NaN where there is no limit: effort_fraction, velocity_fraction,
    position_fraction (how far from the middle of the range, 1 at a limit), rms_fraction. (joint,): peak_force, peak_force_time,
    peak_moment, peak_moment_time, the magnitudes of the reaction."""
    worst: Worst
    static: tuple[StaticPose, ...]
    """For each coordinate that gravity loads."""
    singularity: Singularity
    checks: tuple[Check, ...]
    replay: Replay | None
    replay_skipped: str
    """Why there is no replay; empty if there is one."""
    notices: tuple[str, ...]
    """What a reader must know: how the file was read, doubtful inertias, limits that the motion leaves."""
    seconds: dict[str, float] = field(default_factory=dict)
    """How long each part took (s)."""

    @property
    def passed(self) -> bool:
        """Whether all checks passed."""
        return all(check.passed for check in self.checks)

    def save(self, directory: str | os.PathLike[str]) -> list[Path]:
        """Write study.nc (time series and summary) and CSV tables; the files written. Units stand in the headers."""
        from freebody.report.files import save

        return save(self, Path(directory))

    def to_html(self, path: str | os.PathLike[str]) -> Path:
        """Write the report as one HTML file that opens offline."""
        from freebody.report.html import write

        return write(self, Path(path))
