"""`drive_loads`: what given motors and gears must give over duty cycles, how much of each limit
that is, how long the gears live, and the model that carries them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array, as_floats
from freebody.by_value import ByValue
from freebody.design.duty_cycle import Cycles, DutyCycle, duty_cycles
from freebody.design.loads import (
    CycleLoads,
    DriveJoint,
    RestLoads,
    cycle_loads,
    drive_joints,
    rest_loads,
)
from freebody.design.notices import noise_notices, unmended
from freebody.design.pairs import (
    LIMITS,
    Demand,
    PairTable,
    gear_lives,
    margin_of,
    motor_torque,
    used,
    used_of,
    uses,
)
from freebody.design.parts import Gear, Motor
from freebody.errors import FreebodyError, KindError, listed, shown
from freebody.lazy import cached_property
from freebody.model.doubt_rules.aspects import FRICTION, INERTIAL
from freebody.model.doubts import doubts_used
from freebody.model.drives import LAWS
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import lifetime

if TYPE_CHECKING:
    import xarray as xr

ChosenDrives = Mapping[str, tuple[Motor, Gear]]
"""The motor and the gear of each joint, by its name."""
Mounts = Mapping[str, str | None] | None
"""The frame on which the drive of a joint rides, by the joint's name; None: on the ground."""


@dataclass(frozen=True, eq=False, repr=False)
class DriveLoads(Tabled, ByValue):
    """The torques, speeds, powers and lives of motors and gears over duty cycles.

    Dimensions: `cycle`, `joint` (those that were given a drive), `limit`, `sample` (of all cycles,
    one after another; where a robot rests, one for the whole rest).
    """

    robot: Model
    """The robot without the drives."""
    joints: tuple[DriveJoint, ...]
    drives: Mapping[str, tuple[Motor, Gear]]
    data: xr.Dataset
    """Along (sample, joint): torque, speed, power and, where the torque constant is known, current
    of each motor, and the torque that its gear transmits; `seconds` that each sample stands for."""
    summary: xr.Dataset
    """Along (cycle, joint): peaks, RMS values and means of motors and gears, lives of gears, work
    and braking of motors in one cycle (J)."""
    uses: xr.DataArray
    """Along (limit, joint): the share that is used of each limit, 1 being all of it; NaN where the
    part has no such limit, or nobody asked for it, such as a life."""
    notices: tuple[str, ...] = ()

    @cached_property
    def model(self) -> Model:
        """The robot with the drives: their masses as loads, their rotors, gears and, but in closed
        chains, losses in its joints; and as limits of the joints what the drives give at most."""
        return _fitted(self.robot, self.joints, self.drives)

    @property
    def margin(self) -> float:
        """The smallest ratio of what is allowed to what is used, over all joints and limits."""
        return margin_of(float(self.uses.max()))

    @property
    def passed(self) -> bool:
        """Whether every limit that the parts have is kept."""
        return bool(self.uses.max() <= 1.0)

    def _title(self) -> str:
        joint, limit = _worst(self.uses)
        words = f"{used_of(float(self.uses.max()), f'the {limit}')} of {joint}"
        kept = "every limit given is kept" if self.passed else "not every limit is kept"
        return (
            f"Drives of {self.robot.name!r}, {counted(len(self.drives), 'joint')}: {kept}; {words}"
        )

    def _table(self) -> TextTable:
        return limit_table(self)


def limit_table(found: DriveLoads) -> TextTable:
    """For each joint its motor and gear, the limit that is used most, and how long the gear
    lives."""
    rows = []
    for name, (motor, gear) in found.drives.items():
        shares = np.nan_to_num(found.uses.sel(joint=name).values)
        k = int(np.argmax(shares))
        life = float(found.summary["gear_life"].sel(joint=name).min())
        lasts = "" if np.isnan(life) else lifetime(life)
        rows.append((name, motor.name, gear.name, LIMITS[k].name, used(shares[k]), lasts))
    head = ("joint", "motor", "gear", "limit used most", "used", "life of the gear")
    return TextTable(head, rows, found.notices)


def _worst(used: Any) -> tuple[str, str]:
    shares = np.nan_to_num(used.values)
    limit, joint = np.unravel_index(np.argmax(shares), shares.shape)
    return str(used.joint.values[joint]), str(used.limit.values[limit])


def drive_loads(
    model: Model,
    cycles: Cycles,
    drives: ChosenDrives,
    *,
    mounts: Mounts = None,
    life: float = 0.0,
    hold: bool = False,
) -> DriveLoads:
    """The torques, speeds and powers that motors and gears of a robot must give over duty cycles,
    and how much of their limits that is.

    Parameters
    ----------
    model
        The robot without these drives: their masses, rotors and losses are added. Rotors and losses
        of gears that these joints have in its file do not count; friction does, on the motors'
        side.
    cycles
        A DutyCycle or a Motion, or a list of those that the robot has to be able to do alike.
    drives : {joint: (Motor, Gear)}
        Of all driven joints, or of some.
    mounts : {joint: frame}, optional
        On which frame, at its origin, the mass of a joint's drive rides, None being the ground.
        Default: the link before the joint, at the joint.
    life : h
        How long gears have to last; 0: not asked.
    hold
        Whether every motor must have a brake that holds its joint, as for `fb.size`.

    Returns
    -------
    DriveLoads
        Samples are those of the motions: what is higher between them is not seen.

    Raises
    ------
    FreebodyError, KindError, UnknownNameError

    References
    ----------
    Harmonic Drive AG, Engineering Data, 1019659 11/2014, section 4.1; ISO 281.
    """
    chosen = checked_drives("drive_loads", "drives", drives)
    life = checked_life("drive_loads", life)
    done = duty_cycles("drive_loads", model, cycles)
    joints = fitting_joints("drive_loads", model, chosen, mounts)
    loads = cycle_loads(model, done, joints)
    masses = np.array([sum(part.mass for part in chosen[x.name]) for x in joints])
    rest = rest_loads(model, done, joints) if hold else None
    demands = [demand_of(loads, k, masses, life, rest) for k in range(len(joints))]
    return assembled(model, done, joints, loads, demands, chosen)


def checked_drives(function: str, argument: str, drives: Any) -> dict[str, tuple[Motor, Gear]]:
    """The motor and gear of each joint that a function was given as an argument of that name."""
    if not isinstance(drives, Mapping) or not drives:
        raise KindError(function, argument, drives, "a dict {joint: (motor, gear)}")
    for name, pair in drives.items():
        good = isinstance(pair, tuple | list) and len(pair) == 2
        if not (good and isinstance(pair[0], Motor) and isinstance(pair[1], Gear)):
            raise KindError(function, f"{argument}[{name!r}]", pair, "a pair (fb.Motor, fb.Gear)")
    return {name: (motor, gear) for name, (motor, gear) in drives.items()}


def fitting_joints(
    function: str, model: Model, drives: ChosenDrives, mounts: Mounts = None
) -> tuple[DriveJoint, ...]:
    """The joints that drives were chosen for, each with a gear of its kind; where the drives ride
    as `drive_joints` has it."""
    joints = drive_joints(function, model, tuple(drives), mounts)
    for joint in joints:
        _refuse_misfit(joint, drives[joint.name][1])
    return joints


def checked_life(function: str, life: float) -> float:
    """The hours that gears have to last, else FreebodyError."""
    hours = as_floats(function, "life", life)
    if hours.ndim or not 0.0 <= hours < np.inf:
        said = f"{float(hours):g} h" if hours.ndim == 0 else shown(life)
        raise FreebodyError(f"{function}: life is {said}, expected 0 or more.")
    return float(hours)


def _refuse_misfit(joint: DriveJoint, gear: Gear) -> None:
    """Refuse a screw at a joint that turns, and a gear with a ratio at one that slides."""
    if joint.turns != (gear.lead is None):
        does, has = ("turns", "a lead") if joint.turns else ("slides", "a ratio")
        raise gear.refusal(f"joint {joint.name!r} {does}, and this gear has {has}")


def demand_of(
    loads: CycleLoads, k: int, masses: Array, life: float, rest: RestLoads | None = None
) -> Demand:
    """The load of joint k, where the drives have masses (n,) kg; rest: what a brake has to hold,
    None where none has to."""
    holding = 0.0 if rest is None else rest.holding(k, masses)
    return Demand(
        loads.shares, loads.spans, loads.torque(k, masses), loads.friction[:, k],
        loads.speed[:, k], loads.acceleration[:, k], life, holding,
    )  # fmt: skip


def assembled(
    model: Model,
    cycles: Sequence[DutyCycle],
    joints: Sequence[DriveJoint],
    loads: CycleLoads,
    demands: Sequence[Demand],
    drives: ChosenDrives,
) -> DriveLoads:
    """The loads of chosen drives over duty cycles, put together from the demands on the single
    joints."""
    import xarray as xr

    shares_of, series, found = [], [], []
    for joint, demand in zip(joints, demands, strict=True):
        motor, gear = drives[joint.name]
        shares = uses(demand, PairTable([motor], [gear]))[:, 0, 0]
        given = [limit.asked(demand) and limit.checks(motor, gear) for limit in LIMITS]
        shares_of.append(np.where(given, shares, np.nan))
        series.append(_series(demand, motor, gear))
        found.append(_summary(demand, motor, gear, series[-1], loads.periods))
    names = {"joint": [joint.name for joint in joints]}
    stacked = {key: np.stack([one[key] for one in series], axis=-1) for key in series[0]}
    data = xr.Dataset(
        {key: (("sample", "joint"), x, _attributes(key)) for key, x in stacked.items()},
        {**names, "seconds": ("sample", loads.shares.T @ loads.periods, {"units": "s"})},
    )
    by_cycle = {key: np.stack([one[key] for one in found], axis=-1) for key in found[0]}
    summary = xr.Dataset(
        {key: (("cycle", "joint"), x, _attributes(key)) for key, x in by_cycle.items()}, names
    )
    limits = [limit.name for limit in LIMITS]
    told = (*doubt_notices(model), *unmended(model, cycles), *noise_notices(model, cycles),
            *cycle_notices(cycles), *_lossless(model, joints))  # fmt: skip
    return DriveLoads(
        model, tuple(joints), dict(drives), data, summary,
        xr.DataArray(np.stack(shares_of, axis=-1), {"limit": limits, **names}, ("limit", "joint")),
        (*told, *_unchecked(drives, demands)),
    )  # fmt: skip


_UNITS = {
    "torque": "N m", "speed": "rad/s", "power": "W", "current": "A", "life": "h", "work": "J",
    "braking": "J",
}  # fmt: skip


def _attributes(name: str) -> dict[str, str]:
    unit = next(unit for word, unit in _UNITS.items() if name.endswith(word))
    unit = f"{unit}|N" if name.startswith("gear_") and unit == "N m" else unit
    return {"units": unit, "long_name": name.replace("_", " ")}


def _series(demand: Demand, motor: Motor, gear: Gear) -> dict[str, Array]:
    torque = motor_torque(
        demand.torque, demand.friction, demand.speed, demand.acceleration,
        gear.factor, gear.efficiencies, motor.inertia + gear.inertia,
    )  # fmt: skip
    speed = demand.speed * gear.factor
    constant = np.nan if motor.torque_constant is None else motor.torque_constant
    return {
        "motor_torque": torque,
        "motor_speed": speed,
        "motor_power": torque * speed,
        "motor_current": torque / constant,
        "gear_torque": demand.torque,
    }


def _summary(
    demand: Demand, motor: Motor, gear: Gear, series: dict[str, Array], periods: Array
) -> dict[str, Array]:
    """Peak and mean loads of one joint's motor and gear by name, arrays (C,) with one entry for
    each cycle."""
    inside = demand.shares > 0.0

    def peak(x: Array) -> Array:
        return np.where(inside, np.abs(x), 0.0).max(axis=1)

    def rms(x: Array) -> Array:
        return np.sqrt(demand.shares @ x**2)

    power = series["motor_power"]
    return {
        "peak_motor_torque": peak(series["motor_torque"]),
        "rms_motor_torque": rms(series["motor_torque"]),
        "peak_motor_speed": peak(series["motor_speed"]),
        "mean_motor_speed": demand.mean_speed * gear.factor,
        "peak_motor_power": peak(power),
        "peak_motor_current": peak(series["motor_current"]),
        "rms_motor_current": rms(series["motor_current"]),
        "peak_gear_torque": peak(demand.torque),
        "mean_gear_torque": demand.mean_torque(gear.life_exponent or 3.0),
        "gear_life": gear_lives(demand, gear),
        "motor_work": demand.shares @ np.maximum(power, 0.0) * periods,
        "motor_braking": demand.shares @ np.maximum(-power, 0.0) * periods,
    }


def _fitted(model: Model, joints: Sequence[DriveJoint], drives: ChosenDrives) -> Model:
    """The model with drives: their masses where they ride, rotors, gears and, in open chains,
    losses; the motor's peak torque as limit of effort, and the slower of file and drive as limit of
    speed, so that a study of the robot judges the drives."""
    found = model
    for joint in joints:
        motor, gear = drives[joint.name]
        mass = motor.mass + gear.mass
        if joint.frame is not None and mass > 0.0:
            found = found.with_payload(mass, com=joint.at, frame=joint.frame, name=joint.load)
        forward, back = (0.0, 0.0) if _keeps_no_losses(model, joint) else gear.efficiencies
        geared = {"efficiency": forward, "back_efficiency": back}
        found = found.with_drive(
            joint.name, rotor=motor.inertia + gear.inertia, gear=gear.factor, **_LOSSLESS | geared
        )
        fastest = min(motor.max_speed, gear.max_speed or math.inf) / gear.factor
        limits = {
            "effort": motor.peak_torque * gear.factor,
            "velocity": min(fastest, float(model.limits.velocity[joint.column])),
        }
        found = found.bind({f"{joint.name}.limits.{name}": x for name, x in limits.items()})
    return found


_LOSSLESS = {
    name: off for law in LAWS.values() if law.losses is not None for name, off in law.off.items()
}
"""Numbers of a drive that loses nothing of what it transmits."""


def _keeps_no_losses(model: Model, joint: DriveJoint) -> bool:
    """Whether a model cannot have the losses of a joint's gear: see `model.losses`."""
    followed = {body.joint.mimic.joint for body in model.bodies if body.joint.mimic}
    return bool(model.loops) or joint.name in followed


def doubt_notices(model: Model) -> tuple[str, ...]:
    """Sentences on what is doubtful about the robot's masses and friction."""
    return tuple(map(str, doubts_used(model, *INERTIAL, FRICTION)))


def cycle_notices(cycles: Sequence[DutyCycle]) -> tuple[str, ...]:
    """Sentences on cycles that do not end where they begin, and on rates that jump."""
    jumps = tuple(
        words if len(cycles) == 1 else f"Cycle {k}: {words}"
        for k, cycle in enumerate(cycles, 1)
        for words in cycle.jumps
    )
    open_ones = [str(k) for k, cycle in enumerate(cycles, 1) if not cycle.closes]
    if not open_ones:
        return jumps
    which = "The duty cycle ends" if len(cycles) == 1 else f"Cycles {', '.join(open_ones)} end"
    return (
        *jumps,
        f"{which} elsewhere than it begins: the way back is not in what is said of lives, RMS "
        f"values and energies.",
    )


def _lossless(model: Model, joints: Sequence[DriveJoint]) -> tuple[str, ...]:
    """Sentences on gears whose losses are counted here and are not in the model with drives."""
    names = [joint.name for joint in joints if _keeps_no_losses(model, joint)]
    if not names:
        return ()
    return (
        f"The losses of the gears of {', '.join(names)} are counted here, but the model with its "
        f"drives has none: a closed chain, or a joint that others follow, cannot have them.",
    )


def _unchecked(drives: ChosenDrives, demands: Sequence[Demand]) -> tuple[str, ...]:
    """Sentences on limits that parts do not give, which nothing was compared with."""
    found = []
    for limit in LIMITS:
        if not any(map(limit.asked, demands)):
            continue
        parts = sorted(
            {(m if limit.part == "motor" else g).name for m, g in drives.values()
             if not limit.checks(m, g)}
        )  # fmt: skip
        if parts:
            give = "gives" if len(parts) == 1 else "give"
            found.append(
                f"Not checked: {limit.name} of {listed(parts)}, which {give} no {limit.number}."
            )
    return tuple(found)


def refuse_no_gear(function: str, joint: DriveJoint, gears: Sequence[Gear]) -> list[Gear]:
    """The gears that suit a joint; FreebodyError where there is none."""
    found = [gear for gear in gears if joint.turns == (gear.lead is None)]
    if not found:
        needs = "a ratio" if joint.turns else "a lead (m a turn), for a joint that slides"
        raise FreebodyError(
            f"{function}: no gear of the catalogue suits joint {joint.name!r}; add one with "
            f"{needs}."
        )
    return found
