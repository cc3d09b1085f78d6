"""`emergency_stops`: how long and how far joints go on when the power fails and their brakes act,
and what their gears carry meanwhile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.design.drive_loads import ChosenDrives, DriveLoads, Mounts, drive_loads
from freebody.design.duty_cycle import Cycles, Segment, duty_cycles
from freebody.design.loads import DriveJoint, without_drives
from freebody.design.pairs import holding_torque, used
from freebody.design.parts import Gear, Motor
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable
from freebody.outputs.number_text import percent
from freebody.trees.dynamics import mass_matrix

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class EmergencyStops(Tabled, ByValue):
    """How joints come to rest by their brakes, at the worst instant of duty cycles."""

    loads: DriveLoads
    """Loads of the drives; its uses tell how much of their brakes holding takes."""
    data: xr.Dataset
    """Along (sample, joint): `time` (s) and `way` (rad, m) until the joint stands, infinite where
    its brake does not stop it, and the largest torque behind the gear meanwhile."""
    summary: xr.Dataset
    """Along (joint): the worst of these, and the share of the gear's momentary torque; NaN where it
    gives none."""
    notices: tuple[str, ...] = ()

    def _title(self) -> str:
        times = self.summary["time"].values
        k = int(np.argmax(times))
        name = str(self.summary.joint.values[k])
        robot = repr(self.loads.robot.name)
        if np.isinf(times[k]):
            return f"Stops of {robot}: the brake of {name} does not stop it"
        return f"Stops of {robot}: {name} takes longest, {times[k]:.3g} s"

    def _table(self) -> TextTable:
        rows = []
        for joint in self.loads.joints:
            of = self.summary.sel(joint=joint.name)
            share, brake = (
                float(x)
                for x in (of.momentary_share, self.loads.uses.sel(limit="brake", joint=joint.name))
            )
            rows.append(
                (
                    joint.name,
                    used(brake),
                    f"{of.time:.3g} s",
                    f"{of.way:.3g} {'rad' if joint.turns else 'm'}",
                    f"{of.gear_torque:.4g} {'N m' if joint.turns else 'N'}",
                    "" if np.isnan(share) else percent(share),
                )
            )
        head = ("joint", "of its brake to hold", "stops in", "way", "load", "of momentary torque")
        return TextTable(head, rows, self.notices)


def emergency_stops(
    model: Model, cycles: Cycles, drives: ChosenDrives, *, mounts: Mounts = None
) -> EmergencyStops:
    """How long and how far the joints of an open chain go on when the power fails at any instant of
    duty cycles, until their brakes have stopped them.

    Each joint is looked at by itself, with the inertia and the load that it has at that instant,
    the others keeping their posture; friction is left out. Until the brake acts the motor is
    without torque, so that a load may stop the joint and drive it back. A joint that the brake
    cannot hold against its load does not stop.

    Parameters
    ----------
    model
        The robot without these drives.
    cycles
        A DutyCycle or a Motion, or a list of those.
    drives : {joint: (Motor, Gear)}
        A motor without a brake does not stop, unless it stands and nothing loads it.
    mounts : {joint: frame}, optional
        As for `drive_loads`.

    Returns
    -------
    EmergencyStops
        Holding is looked at too, as `drive_loads(..., hold=True)` does.

    Raises
    ------
    FreebodyError, KindError, UnknownNameError
    """
    import xarray

    model.require_tree("emergency_stops", "drive_loads(..., hold=True) for what brakes hold")
    done = duty_cycles("emergency_stops", model, cycles)
    loads = drive_loads(model, done, drives, mounts=mounts, hold=True)
    bare = without_drives(loads.model, loads.joints).without("friction")
    parts = [_stopped(bare, segment, loads.joints, drives) for x in done for segment in x.segments]
    series = {
        name: np.concatenate([part[name] for part in parts])
        for name in ("time", "way", "gear_torque")
    }
    names = [joint.name for joint in loads.joints]
    limits = [drives[name][1].momentary_torque for name in names]
    worst = {name: x.max(axis=0) for name, x in series.items()}
    worst["momentary_share"] = worst["gear_torque"] / np.array(
        [np.nan if x is None else x for x in limits]
    )
    units = {"time": "s", "way": "rad|m", "gear_torque": "N m|N", "momentary_share": "1"}
    return EmergencyStops(
        loads,
        xarray.Dataset(
            {k: (("sample", "joint"), x, {"units": units[k]}) for k, x in series.items()},
            {"joint": names},
        ),
        xarray.Dataset(
            {k: ("joint", x, {"units": units[k]}) for k, x in worst.items()}, {"joint": names}
        ),
        _unknown(drives, limits),
    )


def _unknown(drives: ChosenDrives, limits: Sequence[float | None]) -> tuple[str, ...]:
    """Sentences on numbers that the parts do not give."""
    delays = [
        motor.name
        for motor, _ in drives.values()
        if motor.brake_torque and motor.brake_delay is None
    ]
    found = []
    if delays:
        found.append(
            f"Brakes of {', '.join(dict.fromkeys(delays))} are taken to act at once: they give no "
            f"brake_delay."
        )
    if None in limits:
        found.append(
            "Not every gear gives a momentary_torque that its load could be compared with."
        )
    return tuple(found)


def _stopped(
    bare: Model,
    segment: Segment,
    joints: Sequence[DriveJoint],
    drives: Mapping[str, tuple[Motor, Gear]],
) -> dict[str, Array]:
    """Times (s), ways (rad, m) and loads of the gears (T, joints) of the stops that begin at each
    sample of a segment."""
    q, qd, qdd, wrenches, _ = segment.states()
    loaded = segment.carried_by(bare)
    M, load = mass_matrix(loaded, q), inverse_dynamics(loaded, q, qd, 0.0 * qdd, wrenches)
    rest = inverse_dynamics(loaded, q, 0.0 * qd, 0.0 * qdd, wrenches)
    for torque in (load, rest):
        torque[np.abs(torque) <= _NOTHING * np.abs(torque).max(initial=0.0)] = 0.0
    found: dict[str, list[Array]] = {"time": [], "way": [], "gear_torque": []}
    for joint in joints:
        k = joint.column
        against = load[:, k] * np.where(qd[:, k] < 0.0, -1.0, 1.0)
        stop = braked(np.abs(qd[:, k]), M[:, k, k], against, rest[:, k], *drives[joint.name])
        for name, value in zip(found, stop, strict=True):
            found[name].append(value)
    return {name: np.stack(columns, axis=-1) for name, columns in found.items()}


_NOTHING = 1e-12
"""Share of the largest load that is there by rounding alone."""


def braked(
    speed: Array, inertia: Array, load: Array, held: Array, motor: Motor, gear: Gear
) -> tuple[Array, Array, Array]:
    """(time, way there and back, largest torque behind the gear) of a joint that moves at `speed`
    (T,) with an inertia behind the gear and a load that resists it (negative: that drives it), both
    constant; infinite where the brake cannot hold the torque `held` (T,) once the joint stands."""
    delay, brake = motor.brake_delay or 0.0, motor.brake_torque or 0.0
    free = _gone_on(speed, inertia, load, 0.0, np.asarray(delay), motor, gear)
    # a load that has stopped the joint before the brake acts drives it back
    load = np.where(free.speed > 0.0, load, -load)
    back = _gone_on(free.speed, inertia, load, 0.0, delay - free.time, motor, gear)
    last = _gone_on(back.speed, inertia, load, brake, np.asarray(np.inf), motor, gear)
    parts, holds = (
        (free, back, last),
        np.abs(held) <= holding_torque(motor, gear) * (1.0 + _NOTHING),
    )
    return (
        np.where(holds, sum(part.time for part in parts), np.inf),
        np.where(holds, sum(part.way for part in parts), np.inf),
        np.max([part.torque for part in parts], axis=0),
    )


class _StopPart(NamedTuple):
    """A part of a stop: its time and way, the speed at its end, and the torque behind the gear."""

    time: Array
    way: Array
    speed: Array
    torque: Array


def _gone_on(
    speed: Array, inertia: Array, load: Array, brake: float, most: Array, motor: Motor, gear: Gear
) -> _StopPart:
    """How a joint goes on until it stands, for at most so many seconds."""
    a, carried = _slowed(inertia, load, brake, motor, gear)
    stands = (speed == 0.0) & (a >= 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        stop = np.where(stands, 0.0, np.where(a > 0.0, speed / a, np.inf))
        time = np.minimum(stop, most)
        way = np.where(np.isinf(time), np.inf, speed * time - 0.5 * a * time**2)
        left = np.where(stop <= most, 0.0, speed - a * time)
    return _StopPart(time, way, left, np.abs(carried) * (time > 0.0))


def _slowed(
    inertia: Array, load: Array, brake: float, motor: Motor, gear: Gear
) -> tuple[Array, Array]:
    """(deceleration, torque that the gear transmits against the motion), with a brake torque at the
    motor: J N² a + k T = N T_brake with T = M a - load, k being η' where the load drives the motor
    and 1/η where the rotor drives the load."""
    N, J = gear.factor, motor.inertia + gear.inertia
    forward, back = gear.efficiencies

    def with_loss(k: float) -> Array:
        return (N * brake + k * load) / (J * N**2 + k * inertia)

    driven = with_loss(back)
    a = np.where(inertia * driven - load >= 0.0, driven, with_loss(1.0 / forward))
    return a, inertia * a - load
