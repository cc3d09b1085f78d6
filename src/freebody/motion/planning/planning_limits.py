"""The limits that a planned motion keeps, and a check whether a motion keeps them, between its
samples too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.arrays import Array, as_array, as_floats
from freebody.errors import FreebodyError, MissingArgumentError, ShapeError
from freebody.model.doubt_rules.aspects import EFFORTS, RANGES, SPEEDS
from freebody.model.doubts import doubts_used
from freebody.model.model import Model
from freebody.motion.motion import Motion, require_motion
from freebody.motion.ranges import Ranges, position_columns, ranges
from freebody.outputs.number_text import compared
from freebody.trees.public_calls import JointVector, finite_vector, vector

SLACK = 1e-9
"""Excess over a limit, as a part of it (or rad, m), that rounding makes of a motion planned along
it."""
SAME = 1e-12
"""Distance, rad or m, below which two waypoints count as one."""
_LEAST, _MOST = 1e-9, 1e12
"""Smallest and largest limits that a robot can move under."""
Limit = JointVector | float | None


@dataclass(frozen=True)
class LimitExcess:
    """A limit that a motion exceeds, at the place where it exceeds it most."""

    name: str
    """Name of the coordinate that exceeds its limit."""
    quantity: str
    """The limited quantity: "position", "velocity" or "acceleration"."""
    value: float
    limit: float
    time: float
    """Time of the largest excess, s."""
    unit: str

    @property
    def text(self) -> str:
        """The excess as a clause of a sentence."""
        value, limit = compared(self.value, self.limit, digits=5)
        end = ""
        if self.quantity == "position":
            end = "lower " if self.value < self.limit else "upper "
        return (
            f"the {self.quantity} of {self.name} is {value} {self.unit} at t = {self.time:.4g} s, "
            f"its {end}limit {limit} {self.unit}"
        )


@dataclass(frozen=True, eq=False)
class PlanningLimits:
    """Limits of rates and torques (nv,), infinite where there are none, and of positions
    (`allowed`). rests: which of them are the model's own, as aspects that may be doubtful."""

    allowed: Ranges
    velocity: Array
    acceleration: Array
    jerk: Array
    torque: Array
    rests: tuple[str, ...]


def planning_limits(
    function: str,
    model: Model,
    velocity: Limit = None,
    acceleration: Limit = None,
    jerk: Limit = None,
    torque: Limit = None,
) -> PlanningLimits:
    """The limits given, one number for all coordinates (of a closed chain the driven ones) or one
    each (nv,), with the model's own."""
    allowed = ranges(model)
    given = {
        name: _read(function, model, name, value)
        for name, value in (
            ("velocity", velocity),
            ("acceleration", acceleration),
            ("jerk", jerk),
            ("torque", torque),
        )
    }
    given["velocity"] = np.minimum(given["velocity"], allowed.velocity)
    given["torque"] = np.minimum(given["torque"], allowed.effort)
    rests = [RANGES]
    for name, own, aspect in (
        ("velocity", allowed.velocity, SPEEDS),
        ("torque", allowed.effort, EFFORTS),
    ):
        if (np.isfinite(own) & (given[name] == own)).any():
            rests.append(aspect)
    return PlanningLimits(allowed, **given, rests=tuple(rests))


def _read(function: str, model: Model, name: str, value: Limit) -> Array:
    if value is None:
        return np.full(model.nv, np.inf)
    if not isinstance(value, Mapping) and as_array(function, name, value).ndim == 0:
        led = np.isin(np.arange(model.nv), model.passive if model.loops else ())
        value = np.where(led, np.inf, as_floats(function, name, value))
    array = vector(function, model, name, value)
    if array.ndim != 1:
        raise FreebodyError(
            f"{function}: {name} has shape {array.shape}, expected one number for all joints or "
            f"({model.nv},)."
        )
    small = ~(array >= _LEAST)  # NaN too
    if small.any():
        k = int(np.argmax(small))
        given, least = compared(array[k], _LEAST, digits=6)
        raise FreebodyError(
            f"{function}: {name} of {model.velocity_names[k]} is {given}, expected a limit above "
            f"0, of at least {least}."
        )
    large = np.isfinite(array) & (array > _MOST)
    if large.any():
        k = int(np.argmax(large))
        given, most = compared(array[k], _MOST, digits=6)
        raise FreebodyError(
            f"{function}: {name} of {model.velocity_names[k]} is {given}, expected at most {most}; "
            f"infinity means no limit."
        )
    return array


def exceeded_limits(
    model: Model, motion: Motion, velocity: Limit = None, acceleration: Limit = None
) -> tuple[LimitExcess, ...]:
    """The limits of position and speed that a motion exceeds, also between its samples; empty where
    it keeps all.

    velocity, acceleration: further limits, one number or (nv,), rad/s, m/s and rad/s², m/s². Those
    of the model count too (zero means not given, see `Limits`). Torques are judged by `study`.
    """
    limits = planning_limits("exceeded_limits", model, velocity, acceleration)
    return tuple(excesses(model, require_motion("exceeded_limits", model, motion), limits))


def excesses(model: Model, motion: Motion, limits: PlanningLimits) -> Iterator[LimitExcess]:
    """All limits that a motion exceeds; see `exceeded_limits`."""
    names, found = model.velocity_names, motion.peaks
    units = np.where(limits.allowed.turns, "rad", "m")
    for iq, iv in zip(*position_columns(model), strict=True):
        of = found.position
        for beyond, value, limit, time in (
            (-1.0, of.low[iq], limits.allowed.lower[iv], of.low_at[iq]),
            (1.0, of.high[iq], limits.allowed.upper[iv], of.high_at[iq]),
        ):
            if beyond * (value - limit) > SLACK * max(1.0, abs(limit)):
                yield LimitExcess(
                    names[iv], "position", float(value), float(limit), float(time), str(units[iv])
                )
    for quantity, of, most, per in (
        ("velocity", found.velocity, limits.velocity, "/s"),
        ("acceleration", found.acceleration, limits.acceleration, "/s²"),
    ):
        for k in np.flatnonzero(of.size > most * (1.0 + SLACK)):
            size, limit, time = float(of.size[k]), float(most[k]), float(of.size_at[k])
            yield LimitExcess(names[k], quantity, size, limit, time, f"{units[k]}{per}")


def quickest(
    function: str,
    model: Model,
    velocity: Array,
    acceleration: Array,
    limits: PlanningLimits,
    *sought: str,
) -> float:
    """The factor by which a motion with these peak velocities and accelerations (nv,) may be run
    faster.

    sought: arguments that say how fast. Raises MissingArgumentError where nothing limits it.
    """
    by_size = np.sqrt(_within(limits.acceleration, acceleration))
    factor = float(min(_within(limits.velocity, velocity), by_size))
    if not np.isfinite(factor):
        raise pace_unknown(function, model, *sought, "velocity", "acceleration")
    return factor


def pace_unknown(function: str, model: Model, *needed: str) -> MissingArgumentError:
    """The error for a motion whose duration nothing determines; needed: the arguments that
    would."""
    return MissingArgumentError(
        f"{function}: how fast {model.name!r} may move is not known",
        needed,
        " (robot descriptions give at most speed limits)",
    )


def within_limits(function: str, model: Model, motion: Motion, limits: PlanningLimits) -> Motion:
    """The motion, with the doubts about its limits; refuses one that exceeds a limit."""
    found = list(excesses(model, motion, limits))
    if not found:
        aspects = (aspect for aspect in limits.rests if aspect != EFFORTS)
        return replace(motion, doubts=doubts_used(model, *aspects))
    found.sort(key=lambda x: (x.quantity != "position", -x.value / x.limit if x.limit else 0.0))
    remedies = []
    if any(x.quantity == "position" for x in found):
        remedies.append("move the waypoints away from the limit")
    rates = [x for x in found if x.quantity != "position"]
    if rates:
        slow = max((x.value / x.limit) ** (1.0 if x.quantity == "velocity" else 0.5) for x in rates)
        remedies.append(f"take {np.ceil(slow * 1000) / 1000:.4g} times as long")
    more = f" ({len(found) - 1} more limits are exceeded)" if len(found) > 1 else ""
    raise FreebodyError(f"{function}: {found[0].text}{more}; {' and '.join(remedies)}.")


def checked_waypoints(
    function: str,
    model: Model,
    given: Any,
    limits: PlanningLimits,
    one: str = "",
    name: str = "waypoints",
) -> Array:
    """Waypoints (k, nq), k > 1, within the limits; refuses robots for which such motions cannot be
    planned. name: what the waypoints are called in messages. one: whether a single position is
    enough."""
    model.require_values("a motion")
    model.require_tree(function, "fb.Motion.of with the positions of the driven joints")
    if model.nq != model.nv:
        raise FreebodyError(
            f"{function}: {model.name!r} has joints whose positions are quaternions, for which "
            f"this is not available; give samples to fb.Motion.of."
        )
    q = finite_vector(function, model, one or name, given)
    if one and q.ndim != 2:
        raise ShapeError(function, one, q.shape[1:], f"({model.nq},)", "one position")
    if q.ndim != 2 or len(q) < 2:
        raise FreebodyError(
            f"{function}: {name} has shape {q.shape}, expected at least two rows: (k, {model.nq})."
        )
    refuse_beyond(function, model, q, range(model.nv), limits, one, name)
    return q


def refuse_beyond(
    function: str,
    model: Model,
    q: Array,
    columns: Sequence[int],
    limits: PlanningLimits,
    one: str = "",
    name: str = "waypoints",
) -> None:
    """Refuse waypoints (k, n) of given coordinates, each of which has a position of its own, that
    are out of range."""
    low, high = (x[list(columns)] for x in (limits.allowed.lower, limits.allowed.upper))
    beyond = np.maximum(low - q, q - high)
    if not beyond.size:
        return
    k, j = np.unravel_index(np.argmax(beyond), beyond.shape)
    if beyond[k, j] > SLACK * max(1.0, abs(q[k, j])):
        there, least, most = compared(q[k, j], low[j], high[j], digits=5)
        joint = model.velocity_names[columns[int(j)]]
        raise FreebodyError(
            f"{function}: {one or _numbered(int(k), name)} has {joint} at "
            f"{there}, outside its range from {least} to {most}."
        )


def _numbered(k: int, name: str) -> str:
    return f"waypoint {k}" if name == "waypoints" else f"waypoint {k} of {name}"


def slowed(motion: Motion, limits: PlanningLimits) -> float:
    """The factor on a motion's speed, at most 1, that keeps it within limits of rates (nv,)."""
    found = motion.peaks
    return min(
        1.0,
        _within(limits.velocity, found.velocity.size),
        np.sqrt(_within(limits.acceleration, found.acceleration.size)),
    )


def _within(limit: Array, size: Array) -> float:
    """The smallest ratio of a limit to the value that is used; infinite where there is no limit."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(size > 0.0, limit / size, np.inf).min())
