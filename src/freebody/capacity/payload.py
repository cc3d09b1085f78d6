"""`payload`: the largest mass that a robot carries along a motion, in a duty cycle, or at
postures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.any_chain.effort_limits import chosen_efforts
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.capacity.fitted_parts import FittedParts
from freebody.capacity.loaded_case import LoadedCase
from freebody.capacity.part_loads import part_loads
from freebody.capacity.payload_limits import LIMIT_OF_NAME, by_limits, limited_parts
from freebody.capacity.reached_masses import along, reached_masses
from freebody.capacity.segments import LoadedSegment, loaded_segments
from freebody.capacity.time_scaling import motion_pace
from freebody.capacity.torque_parts import torque_parts
from freebody.design.drive_loads import ChosenDrives
from freebody.design.duty_cycle import DutyCycle
from freebody.design.parts import Bearing
from freebody.errors import KindError, listed
from freebody.labels import refuse_labelled
from freebody.model.doubt_rules.aspects import DYNAMIC, EFFORTS, INERTIAL
from freebody.model.doubts import Doubt, attribute, barring, doubts_on, in_one_line
from freebody.model.model import Model
from freebody.motion.files.measured_motions import loudest, smoothed
from freebody.motion.motion import Motion, require_motion
from freebody.motion.planning.planning_limits import SLACK
from freebody.motion.ranges import CLOSE, position_columns, ranges
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import rounded_down
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.reach.payload_map import refuse_passive
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    finite_vector,
    wrenches_by_frame,
)

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class LargestPayload(Tabled, ByValue):
    """The largest payload along each motion, or at each posture (...), besides what the robot
    carries already.

    mass: (...), kg; 0 where a limit is exceeded without any, infinite where none limits it.
    by_joint: (..., K), the mass at which each joint alone reaches its limit: coordinates, then
    joints that follow others and have limits of their own, then brakes, then bearings, by static
    load and by tilting moment. joint: (...), index of the one that
    limits, -1 without one. time: (...), s, when it does; NaN for postures.
    overloaded: (...), whether a limit is exceeded without payload. too_fast: names of joints
    whose speed exceeds its limit on a motion, whatever the mass. outside: names of joints that
    leave their ranges on a motion or at a posture. faster: how many times as fast one motion may be
    run without payload; NaN for several, for postures, and where it is not known what bearings bear
    at other speeds. joint_names, limits: (K,), the joint of each limit, and which
    it is: "effort", "brake", "static load" or "tilting moment". parts: (K,), words for what reaches
    it. frame: where the payload is. doubts: those on the robot's masses, drives and effort limits.
    noise: sentences on the noise of a measured motion, which counts as torque; otherwise empty.
    """

    mass: Array
    by_joint: Array
    joint: np.ndarray
    time: Array
    overloaded: np.ndarray
    too_fast: tuple[str, ...]
    outside: tuple[str, ...]
    faster: float
    joint_names: tuple[str, ...]
    limits: tuple[str, ...]
    parts: tuple[str, ...]
    frame: str
    doubts: tuple[Doubt, ...] = ()
    noise: str = ""
    _aside = ("doubts", "noise")

    @property
    def told(self) -> bool:
        """Whether a mass can be told of: no doubt bars it, and no joint is too fast or beyond its
        range."""
        beyond = self.too_fast or self.outside or barring(self.doubts)
        return bool(self.mass.size) and not beyond

    @property
    def carries(self) -> bool:
        """Whether the payload is above 0 for every motion or posture, no joint is too fast or
        beyond its range, and no doubt about the model prevents a verdict."""
        return self.told and bool((self.mass > 0.0).all())

    @property
    def remark(self) -> str:
        """Words on what limits the least of the masses and when, or why none is told of."""
        if not self.mass.size:
            return "nothing is carried anywhere: there are no postures"
        if found := barring(self.doubts):
            return f"not judged: {'; '.join(doubt.clause for doubt in found)}"
        if self.outside:
            return f"not {self._where()}: {listed(self.outside, 4)} would leave the position range"
        if self.too_fast:
            return f"not at this speed: {listed(self.too_fast, 4)} would exceed the speed limit"
        at = self.least
        if self.joint[at] < 0:
            kinds = dict.fromkeys(LIMIT_OF_NAME[name].what for name in self.limits)
            return f"no {' or '.join(kinds)} is in the way"
        k, time = self.joint[at], float(self.time[at])
        when = "" if np.isnan(time) else f" at t = {time:.3g} s"
        does = LIMIT_OF_NAME[self.limits[k]].beyond if self.overloaded[at] else "limits"
        return f"{self.parts[k]} {does}{when}"

    @property
    def by(self) -> str:
        """Words on what is counted: nothing else, such as bearings that nobody gave, limits the
        masses."""
        return by_limits(self.limits)

    @property
    def card(self) -> str:
        """One line: how much is carried by what is counted, what limits it, and how much faster
        without it; of several motions or postures the least."""
        if not self.told:
            return self.remark
        where, at = self._where(), self.least
        noisy = ["the noise of the motion counts"] if self.noise else []
        if self.joint[at] < 0:
            return f"carries any mass {where}: {self.remark}"
        if self.overloaded[at]:
            return " · ".join([f"carries nothing {where}", self.remark, *noisy])
        told = [f"carries {rounded_down(float(self.mass[at]))} kg {self.by} {where}", self.remark]
        if np.isfinite(self.faster) and self.faster >= 1.0:
            pace = rounded_down(self.faster, 2)
            told.append(
                "no faster without it" if pace == "1" else f"without it {pace} times as fast"
            )
        return " · ".join([*told, *noisy])

    @property
    def least(self) -> tuple[np.intp, ...]:
        """The indices of the smallest of the payloads."""
        return np.unravel_index(np.argmin(self.mass), self.mass.shape)

    def _where(self) -> str:
        motions = not np.isnan(self.time).all()
        if self.mass.ndim == 0:
            return "on this path" if motions else "at this posture"
        count = self.mass.size
        return (
            f"on each of {counted(count, 'path')}"
            if motions
            else (f"at each of {counted(count, 'posture')}")
        )

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the motions or postures."""
        dims = axes_of("case", self.mass.ndim) if self.mass.ndim else ()
        names, limits = (np.array([*x, ""])[self.joint] for x in (self.joint_names, self.limits))
        each = "mass at which it reaches its limit"
        return labelled(
            {
                "mass": (dims, self.mass, "kg", f"largest payload at {self.frame}"),
                "by_joint": ((*dims, "coordinate"), self.by_joint, "kg", each),
                "joint": (dims, names, "1", "joint that limits it"),
                "limit": (dims, limits, "1", "limit that it reaches there"),
                "time": (dims, self.time, "s", "when it does"),
                "overloaded": (dims, self.overloaded, "1", "a limit exceeded without payload"),
            },
            {"coordinate": (("coordinate",), np.array(self.parts), "1", "what has a limit")},
            {"frame": self.frame, "card": self.card, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        return f"Payload: {self.card}"

    def _table(self) -> TextTable:
        least = self.by_joint.reshape(-1, len(self.joint_names)).min(axis=0, initial=np.inf)
        rows = [
            (name, f"{mass:.4g} kg" if np.isfinite(mass) else "no limit")
            for name, mass in zip(self.parts, least, strict=True)
        ]
        notes = [in_one_line(self.doubts)] if self.doubts else []
        notes += [self.noise] if self.noise else []
        return TextTable(("limit", "carries alone"), rows, notes)


def payload(
    model: Model,
    motion: Motion | DutyCycle | Sequence[Motion] | JointVector,
    *,
    com: Sequence[float] | None = None,
    box: Sequence[float] | None = None,
    cylinder: Sequence[float] | None = None,
    frame: str | None = None,
    wrenches: FrameWrenchTable = None,
    effort: JointVector | None = None,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
) -> LargestPayload:
    """The largest payload that a robot carries along a motion, or holds at postures, besides what
    it carries already.

    Parameters
    ----------
    model
        An open chain with a drive in every joint, or a closed one; with its drives, such as
        `drive_loads(...).model`.
    motion
        A Motion, several of them in a list, or positions q (..., nq) at which the robot stands; or
        a DutyCycle: for each segment, what it carries besides its payload, its rest included.
    com, box, cylinder
        Where the payload's centre of mass is in the frame's axes, (dim,) m, default its origin, and
        its shape, as for `Model.with_payload`; its inertia grows with its mass.
    frame
        Default: the tip.
    wrenches
        Constant ones exerted on the robot, {frame: (six,)}, world axes.
    effort
        (nv,), the largest torques and forces of the drives, N m and N, infinite where there is no
        limit; default the joints' effort limits. Those of joints that follow others count in any
        case.
    brakes : {joint: (Motor, Gear)}, optional
        Drives whose brakes have to hold the robot still wherever it is at a sample of the motion or
        at a posture, with the wrenches and without, by what `drive_loads(..., hold=True)` counts;
        such as its `drives`. Their masses are the model's already.
    bearings : {joint: Bearing}, optional
        Of joints that turn, as for `bearing_loads`: a crossed roller bearing is judged by its
        static equivalent load, times its static_factor, against its static_load; each by its
        moment_limit. How long they live is not asked.

    Returns
    -------
    LargestPayload
        With `.card` in a line. Torques are looked at at the samples of a motion, on both sides of
        jumps of its accelerations and, of open chains, closely beside the instant that limits. What
        gears lose is in them. Speeds and positions limit no mass: joints beyond theirs
        are named.

    Raises
    ------
    FreebodyError
        No drive has an effort limit; a family; a bearing without a limit, or whose load rigid
        bodies do not determine.
    PassiveJointError
        An open chain with a joint that nothing drives.
    KindError, ShapeError, NotFiniteError, UnknownNameError
    """
    function = "payload"
    model.require_values("the payload")
    if model.passive and not model.loops:
        refuse_passive(function, model)
    shape = {"com": com, "box": box, "cylinder": cylinder}
    for what, given in shape.items():
        refuse_labelled(f"{function}: {what}", given)
    loads = wrenches_by_frame(function, model, wrenches, single=True)
    parts = FittedParts.of(function, model, brakes, bearings)
    found = largest_payload(model, motion, loads, parts, shape, frame, effort)
    noise = loudest(model, _motions(model, motion) or ())
    if noise is not None:
        found = replace(found, noise=noise.counted)
    if not isinstance(motion, Motion):
        return found
    if noise is not None:
        clean = smoothed(model, motion, noise.cutoff)
        other = largest_payload(model, clean, loads, parts, shape, frame, effort)
        found = replace(found, noise=f"{noise.counted} Then: {other.card}.")
    states = motion.q, motion.qd, motion.qdd
    limits = chosen_efforts(function, model, effort)
    fitted = part_loads(function, model, parts, motion.t, states, loads)
    data = torque_parts(model, motion, loads)
    return replace(found, faster=motion_pace(model, motion, data, loads, limits, fitted).factor)


def largest_payload(
    model: Model,
    motion: Motion | DutyCycle | Sequence[Motion] | JointVector,
    loads: Mapping[str, Array],
    parts: FittedParts,
    shape: Mapping[str, Any] | None = None,
    frame: str | None = None,
    effort: JointVector | None = None,
) -> LargestPayload:
    """The largest payload, its arguments checked as `payload` does; how much faster without it is
    left open (NaN)."""
    function, name = "payload", model.frame(frame).name
    kilogram = {"mass": 1.0, **(shape or {})}
    limits = chosen_efforts(function, model, effort)
    case = LoadedCase.of(model, kilogram, name, limits, loads or None, parts)
    motions, doubted = _motions(model, motion), (model,)
    if isinstance(motion, DutyCycle):
        segments = loaded_segments(function, model, motion, loads)
        doubted = tuple(segment.model for segment in segments)
        each = [_in_segment(x, kilogram, name, limits, parts) for x in segments]
        mass, over, time = (np.stack(x) for x in zip(*each, strict=True))
    elif motions is None:
        positions = isinstance(motion, Mapping | Sequence) or hasattr(motion, "__array__")
        if isinstance(motion, str) or not positions:
            raise KindError(
                function, "motion", motion, "a Motion, a DutyCycle, or positions q (..., nq)"
            )
        q = finite_vector(f"{function}: motion", model, "q", motion)
        rest = np.zeros((*q.shape[:-1], model.nv))
        mass, over = reached_masses(case, (q, rest, rest))
        time = np.full(mass.shape, np.nan)
    else:
        mass, over, time = along(case, motions)
        if isinstance(motion, Motion):
            mass, over, time = mass[0], over[0], time[0]
    names, kinds, words = zip(*limited_parts(case), strict=True)
    beyond = _outside(model, q.reshape(-1, model.nq)) if motions is None else _leave(model, motions)
    joint = np.argmin(np.where(over, -1.0, mass), axis=-1)
    least = np.asarray(mass.min(axis=-1))
    free = np.isinf(least)
    aspects = (
        *(INERTIAL if motions is None else DYNAMIC),
        *([EFFORTS] if effort is None else ()),
    )
    return LargestPayload(
        least,
        mass,
        np.where(free, -1, joint).astype(int),
        np.where(free, np.nan, np.take_along_axis(time, joint[..., None], axis=-1)[..., 0]),
        np.asarray(over.any(axis=-1)),
        () if motions is None else _too_fast(model, motions),
        tuple(name for name, bad in zip(model.velocity_names, beyond, strict=True) if bad),
        np.nan,
        names,
        kinds,
        words,
        name,
        tuple(dict.fromkeys(x for one in doubted for x in doubts_on(one, *aspects))),
    )


def _in_segment(
    segment: LoadedSegment,
    kilogram: Mapping[str, Any],
    frame: str,
    limits: Array,
    parts: FittedParts,
) -> tuple[Array, np.ndarray, Array]:
    """(masses (K,), whether a joint is overloaded without, when) in a segment of a duty cycle,
    moving and at rest behind it."""
    case = LoadedCase.of(segment.model, kilogram, frame, limits, segment.wrenches or None, parts)
    mass, over, time = (x[0] for x in along(case, [segment.motion]))
    if segment.dwell == 0.0:
        return mass, over, time
    rest = np.zeros(segment.model.nv)
    held, worse = reached_masses(case, (segment.motion.q[-1], rest, rest))
    end = segment.motion.t[-1]
    return np.minimum(mass, held), over | worse, np.where(held < mass, end, time)


def _motions(model: Model, motion: Any) -> list[Motion] | None:
    """The motions that a payload is asked for, of a duty cycle those of its segments; None where
    postures are given."""
    if isinstance(motion, DutyCycle):
        return [require_motion("payload", model, x.motion) for x in motion.segments]
    if isinstance(motion, Motion):
        return [require_motion("payload", model, motion)]
    if isinstance(motion, list | tuple) and motion and all(isinstance(x, Motion) for x in motion):
        return [require_motion("payload", model, one) for one in motion]
    return None


def _too_fast(model: Model, motions: Sequence[Motion]) -> tuple[str, ...]:
    """Names of joints whose speed exceeds its limit on some motion."""
    limits = ranges(model).velocity * (1.0 + CLOSE)
    beyond = np.zeros(model.nv, dtype=bool)
    for one in motions:
        rise = np.abs(one.qdd).max(axis=0) * float(np.diff(one.t).max())
        if (np.abs(one.qd).max(axis=0) + rise > limits).any():  # else none is near
            beyond |= one.peaks.velocity.size > limits
    return tuple(name for name, bad in zip(model.velocity_names, beyond, strict=True) if bad)


def _outside(model: Model, q: Array) -> np.ndarray:
    """Whether each coordinate (nv,) leaves its range at positions (m, nq)."""
    (iq, iv), allowed = position_columns(model), ranges(model)
    beyond = np.zeros(model.nv, dtype=bool)
    for sign, limit, most in (
        (1.0, allowed.upper[iv], q[:, iq].max(axis=0, initial=-np.inf)),
        (-1.0, allowed.lower[iv], q[:, iq].min(axis=0, initial=np.inf)),
    ):
        beyond[iv] |= sign * most > sign * limit + SLACK * np.maximum(1.0, np.abs(limit))
    return beyond


def _leave(model: Model, motions: Sequence[Motion]) -> np.ndarray:
    """Whether each coordinate (nv,) leaves its range on some motion."""
    (iq, iv), beyond = position_columns(model), np.zeros(model.nv, dtype=bool)
    for one in motions:
        ends = np.stack([one.q.min(axis=0), one.q.max(axis=0)])
        between = np.zeros(ends.shape)
        between[:, iq] = np.abs(one.qd).max(axis=0)[iv] * float(np.diff(one.t).max())
        if _outside(model, ends + between * [[-1.0], [1.0]]).any():  # else none is near
            found = one.peaks.position
            beyond |= _outside(model, np.stack([found.low, found.high]))
    return beyond
