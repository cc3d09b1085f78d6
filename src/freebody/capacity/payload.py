"""`payload`: the largest mass that a robot carries along a motion, or holds at postures.

At given positions, rates and accelerations the torque that a joint transmits is affine in the mass
of a load of given shape and place, t = t₀ + m t₁: t₁ is what a kilogram adds. The drive gives in
addition what friction and rotor take, which no mass changes, and what the gear loses of t, a part
that depends on the way of the power alone. So the torque of the drive rises or falls with m all the
way, and the mass at which it reaches its limit has a closed form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.capacity.time_scaling import effort_limits, pace
from freebody.capacity.torque_parts import torque_parts
from freebody.errors import FreebodyError, listed
from freebody.labels import refuse_labelled
from freebody.model.doubt_rules.aspects import DYNAMIC, EFFORTS, INERTIAL
from freebody.model.doubts import Doubt, attribute, barring, doubts_on, in_one_line
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.motion.motion import Motion, require_motion
from freebody.motion.planning.planning_limits import SLACK
from freebody.motion.ranges import CLOSE, position_columns, ranges
from freebody.motion.smooth_friction import lost_torque, motor_springs, rotor_torque
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import rounded_down
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.reach.payload_map import NO_SLOPE, given_efforts, refuse_passive
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    finite_vector,
    wrenches_by_frame,
)

if TYPE_CHECKING:
    import xarray as xr

_ROUNDING = 1e-13
"""Change of a torque, as a part of it, that is none."""
_BETWEEN = 65
"""Instants that are looked at in the two intervals beside the one that limits."""
_BESIDE = 1e-6
"""Share of an interval: so far from a jump of the accelerations its two sides are looked at."""
_FEW = 8
"""Samples for each break of a motion with few breaks."""
_BLOCK = 65536
"""Samples at once."""

_MotionStates = tuple[Array, Array, Array]
"""Positions, rates and accelerations of samples."""


@dataclass(frozen=True, eq=False, repr=False)
class LargestPayload(Tabled, ByValue):
    """The largest payload along each motion, or at each posture (...), besides what the robot
    carries already.

    mass: (...), kg; 0 where a drive is overloaded without any, infinite where none limits it.
    by_joint: (..., nv), the mass at which each drive alone reaches its limit. joint: (...), index
    of the one that limits, -1 without one. time: (...), s, when it does; NaN for postures.
    overloaded: (...), whether a drive is overloaded without payload. too_fast: names of joints
    whose speed exceeds its limit on a motion, whatever the mass. outside: names of joints that
    leave their ranges on a motion or at a posture. faster: how many times as fast one
    motion may be run without payload; NaN for several, and for postures. joint_names: (nv,). frame:
    where the payload is. doubts: those on the robot's masses, drives and effort limits.
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
    frame: str
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)

    @property
    def told(self) -> bool:
        """Whether a mass can be told of: no doubt bars it, and no joint is too fast or beyond its
        range."""
        beyond = self.too_fast or self.outside or barring(self.doubts)
        return bool(self.mass.size) and not beyond

    @property
    def carries(self) -> bool:
        """Whether something is carried everywhere, no joint is too fast or beyond its range, and no
        doubt bars to say so."""
        return self.told and bool((self.mass > 0.0).all())

    @property
    def remark(self) -> str:
        """What limits the least of the masses and when, or why none is told of."""
        if not self.mass.size:
            return "nothing is carried anywhere: there are no postures"
        if found := barring(self.doubts):
            return f"not judged: {'; '.join(doubt.clause for doubt in found)}"
        if self.outside:
            return f"not {self._where()}: {listed(self.outside, 4)} would leave the position range"
        if self.too_fast:
            return f"not at this speed: {listed(self.too_fast, 4)} would exceed the speed limit"
        at = self._least
        if self.joint[at] < 0:
            return "no drive limits it"
        name, time = self.joint_names[self.joint[at]], float(self.time[at])
        when = "" if np.isnan(time) else f" at t = {time:.3g} s"
        if self.overloaded[at]:
            return f"{name} is overloaded without payload{when}"
        return f"{name} limits{when}"

    @property
    def card(self) -> str:
        """One line: how much is carried, what limits it, and how much faster without it; of several
        motions or postures the least."""
        if not self.told:
            return self.remark
        where, at = self._where(), self._least
        if self.joint[at] < 0:
            return f"carries any mass {where}: {self.remark}"
        if self.overloaded[at]:
            return f"carries nothing {where} · {self.remark}"
        told = [f"carries {rounded_down(float(self.mass[at]))} kg {where}", self.remark]
        if np.isfinite(self.faster) and self.faster >= 1.0:
            told.append(f"{rounded_down(self.faster, 2)} times as fast possible without it")
        return " · ".join(told)

    @property
    def _least(self) -> tuple[np.intp, ...]:
        """Where the least of the masses is."""
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
        names = np.array([*self.joint_names, ""])[self.joint]
        each = "mass at which the drive reaches its limit"
        return labelled(
            {
                "mass": (dims, self.mass, "kg", f"largest payload at {self.frame}"),
                "by_joint": ((*dims, "coordinate"), self.by_joint, "kg", each),
                "joint": (dims, names, "1", "joint that limits it"),
                "time": (dims, self.time, "s", "when it does"),
                "overloaded": (dims, self.overloaded, "1", "overloaded without payload"),
            },
            {"coordinate": (("coordinate",), np.array(self.joint_names), "1", "coordinate")},
            {"frame": self.frame, "card": self.card, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        return f"Payload: {self.card}"

    def _table(self) -> TextTable:
        least = self.by_joint.reshape(-1, len(self.joint_names)).min(axis=0, initial=np.inf)
        rows = [
            (name, f"{mass:.4g} kg" if np.isfinite(mass) else "no limit")
            for name, mass in zip(self.joint_names, least, strict=True)
        ]
        notes = [in_one_line(self.doubts)] if self.doubts else []
        return TextTable(("drive", "carries alone"), rows, notes)


def payload(
    model: Model,
    motion: Motion | Sequence[Motion] | JointVector,
    *,
    com: Sequence[float] | None = None,
    box: Sequence[float] | None = None,
    cylinder: Sequence[float] | None = None,
    frame: str | None = None,
    wrenches: FrameWrenchTable = None,
    effort: JointVector | None = None,
) -> LargestPayload:
    """The largest payload that a robot carries along a motion, or holds at postures, besides what
    it carries already.

    Parameters
    ----------
    model
        An open chain with a drive in every joint, or a closed one.
    motion
        A Motion, several of them in a list, or positions q (..., nq) at which the robot stands.
    com, box, cylinder
        Where the payload's centre of mass is in the frame's axes, (dim,) m, default its origin, and
        its shape, as for `Model.with_payload`; its inertia grows with its mass.
    frame
        Default: the tip.
    wrenches
        Constant ones exerted on the robot, {frame: (six,)}, world axes.
    effort
        (nv,), the largest torques and forces of the drives, N m and N, infinite where there is no
        limit; default the joints' effort limits.

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
        No drive has an effort limit; a family.
    PassiveJointError
        An open chain with a joint that nothing drives.
    ShapeError, NotFiniteError, UnknownNameError
    """
    function = "payload"
    model.require_values("the payload")
    if model.passive and not model.loops:
        refuse_passive(function, model)
    name = model.frame(frame).name
    shape = {"com": com, "box": box, "cylinder": cylinder}
    for what, given in shape.items():
        refuse_labelled(f"{function}: {what}", given)
    kilogram = {"mass": 1.0, **shape}
    limits = _efforts(model, effort)
    loads = wrenches_by_frame(function, model, wrenches, single=True) or None
    case = _Case(model, _carrying(model, kilogram, name), limits, loads)
    motions = _motions(model, motion)
    if motions is None:
        q = finite_vector(function, model, "q", motion)
        rest = np.zeros((*q.shape[:-1], model.nv))
        mass, over = case.masses((q, rest, rest))
        beyond = _outside(model, q.reshape(-1, model.nq))
        time, fast, faster = np.full(q.shape[:-1], np.nan), (), np.nan
    else:
        mass, over, time = _along(case, motions)
        fast, beyond = _too_fast(model, motions), _leave(model, motions)
        faster = _faster(model, motions[0], limits, loads) if isinstance(motion, Motion) else np.nan
        if isinstance(motion, Motion):
            mass, over, time = mass[0], over[0], time[0]
    joint = np.argmin(np.where(over, -1.0, mass), axis=-1)
    least = np.asarray(mass.min(axis=-1))
    free = np.isinf(least)
    return LargestPayload(
        least,
        mass,
        np.where(free, -1, joint).astype(int),
        np.where(free, np.nan, np.take_along_axis(time, joint[..., None], axis=-1)[..., 0])
        if motions is not None
        else time,
        np.asarray(over.any(axis=-1)),
        fast,
        tuple(name for name, bad in zip(model.velocity_names, beyond, strict=True) if bad),
        faster,
        model.velocity_names,
        name,
        doubts_on(
            model,
            *(INERTIAL if motions is None else DYNAMIC),
            *([EFFORTS] if effort is None else ()),
        ),
    )


@dataclass(frozen=True)
class _Case:
    """A robot without and with a kilogram, the limits of its drives (nv,), and wrenches on it."""

    model: Model
    carrying: Model
    effort: Array
    wrenches: Mapping[str, Array] | None

    def masses(self, states: _MotionStates) -> tuple[Array, np.ndarray]:
        """(masses (..., nv) at which each drive reaches its limit, 0 of one that is overloaded
        without, infinite where a mass changes nothing; whether it is overloaded)."""
        shape, n = states[0].shape[:-1], self.model.nv
        flat = [x.reshape(-1, x.shape[-1]) for x in states]
        mass, over = np.empty((len(flat[0]), n)), np.empty((len(flat[0]), n), dtype=bool)
        for first in range(0, len(flat[0]), _BLOCK):
            some = slice(first, first + _BLOCK)
            mass[some], over[some] = self._masses(*(x[some] for x in flat))
        return mass.reshape(*shape, n), over.reshape(*shape, n)

    def _masses(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, np.ndarray]:
        model, at, loads = self.model, (q, qd, qdd), self.wrenches
        tau = inverse_dynamics(model, *at, loads)
        lossy = bool(lossy_joints(model.bodies))
        sent, rest = tau, np.zeros_like(tau)
        carrying = self.carrying
        if lossy:
            bare, carrying = model.without("friction"), carrying.without("friction")
            whole = inverse_dynamics(bare, *at, loads)
            sent = whole - rotor_torque(model, q, qd, qdd) - motor_springs(model, q, qd)
            rest = tau - sent - lost_torque(model, qd, sent)
            slope = inverse_dynamics(carrying, *at, loads) - whole
        else:
            whole = tau
            slope = inverse_dynamics(carrying, *at, loads) - tau
        rounding = _ROUNDING * np.abs(whole).max(axis=-1, keepdims=True)
        slope[np.abs(slope) <= np.maximum(rounding, NO_SLOPE)] = 0.0
        bound = np.where(np.isfinite(self.effort), self.effort, 0.0)
        most = np.sign(slope) * bound - rest
        if lossy:  # of what is transmitted at the limit, by the way of its power
            lost = lost_torque(model, qd, most)
            most = most / (1.0 + lost / np.where(most == 0.0, 1.0, most))
        with np.errstate(divide="ignore", invalid="ignore"):
            mass = np.where(slope == 0.0, np.inf, (most - sent) / slope)
        over = np.isfinite(self.effort) & (np.abs(tau) > bound * (1.0 + CLOSE))
        mass = np.where(np.isfinite(self.effort), np.maximum(mass, 0.0), np.inf)
        return np.where(over, 0.0, mass), over


def _carrying(model: Model, kilogram: Mapping[str, Any], frame: str) -> Model:
    name = "carried"
    taken = {part.link for body in model.bodies for part in body.inertias}
    while name in taken:
        name += "_"
    return model.with_payload(**kilogram, frame=frame, name=name)


def _efforts(model: Model, effort: JointVector | None) -> Array:
    """(nv,) limits of the drives, infinite where there is none."""
    if effort is not None:
        given = given_efforts("payload", model, effort)
        driven = np.isin(np.arange(model.nv), model.driven)
        return np.where(driven, given, np.inf)
    found = effort_limits(model, ranges(model))
    if not np.isfinite(found).any():
        raise FreebodyError(
            f"payload: no joint of {model.name!r} has an effort limit. Give effort= (--effort), "
            f"the largest torque or force of each joint ({listed(model.driven_names, 8)})."
        )
    return found


def _motions(model: Model, motion: Any) -> list[Motion] | None:
    """The motions; None for postures."""
    if isinstance(motion, Motion):
        return [require_motion("payload", model, motion)]
    if isinstance(motion, list | tuple) and motion and all(isinstance(x, Motion) for x in motion):
        return [require_motion("payload", model, one) for one in motion]
    return None


def _along(case: _Case, motions: Sequence[Motion]) -> tuple[Array, np.ndarray, Array]:
    """(masses (P, nv), whether a drive is overloaded without (P, nv), when (P, nv)) of motions."""
    samples = [_samples(one) for one in motions]
    mass, over, time = _least(case, samples)
    if case.model.loops:  # between samples its positions are not closed
        return mass, over, time
    least = np.take_along_axis(time, np.argmin(mass, axis=-1)[:, None], axis=-1)[:, 0]
    closer = [_beside(one, float(at)) for one, at in zip(motions, least, strict=True)]
    near, worse, when = _least(case, closer)
    return np.minimum(mass, near), over | worse, np.where(near < mass, when, time)


_TimedStates = tuple[Array, _MotionStates]
"""Times and states of samples."""


def _least(case: _Case, samples: Sequence[_TimedStates]) -> tuple[Array, np.ndarray, Array]:
    """The least masses among samples of each motion, whether a drive is overloaded in one, and the
    times of the least."""
    q, qd, qdd = (np.concatenate(parts) for parts in zip(*(x[1] for x in samples), strict=True))
    every, loaded = case.masses((q, qd, qdd))
    found = []
    ends = np.cumsum([len(t) for t, _ in samples])
    for (t, _), end in zip(samples, ends, strict=True):
        part = slice(end - len(t), end)
        k = np.argmin(every[part], axis=0)
        found.append(
            (np.take_along_axis(every[part], k[None], axis=0)[0], loaded[part].any(axis=0), t[k])
        )
    mass, over, time = zip(*found, strict=True)
    return np.array(mass), np.array(over), np.array(time)


def _samples(motion: Motion) -> _TimedStates:
    """The samples of a motion, and both sides of each jump of its accelerations: of all breaks of
    its pieces where these are few, which takes less than to find the jumps."""
    if motion.pieces is None:
        return motion.t, (motion.q, motion.qd, motion.qdd)
    breaks = motion.pieces.breaks
    jumps = breaks[1:-1] if _FEW * len(breaks) <= len(motion.t) else motion.jumps
    step = _BESIDE * float(np.diff(breaks).min())
    sides = [motion.at(jumps, jumps + sign * step) for sign in (-1.0, 1.0)]
    own = (motion.q, motion.qd, motion.qdd)
    states = tuple(np.concatenate([x, *pair]) for x, *pair in zip(own, *sides, strict=True))
    return np.concatenate([motion.t, jumps, jumps]), (states[0], states[1], states[2])


def _beside(motion: Motion, time: float) -> _TimedStates:
    """Instants between the samples on either side of one."""
    k = int(np.argmin(np.abs(motion.t - time)))
    ends = motion.t[max(k - 1, 0)], motion.t[min(k + 1, len(motion.t) - 1)]
    t = np.linspace(*ends, _BETWEEN)
    return t, motion.at(t)


def _too_fast(model: Model, motions: Sequence[Motion]) -> tuple[str, ...]:
    """Names of joints whose speed exceeds its limit on some motion."""
    limits = ranges(model).velocity * (1.0 + CLOSE)
    beyond = np.zeros(model.nv, dtype=bool)
    for one in motions:
        rise = 0.5 * np.abs(one.qdd).max(axis=0) * float(np.diff(one.t).max())
        if (np.abs(one.qd).max(axis=0) + 2.0 * rise > limits).any():  # else none is near
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


def _faster(
    model: Model, motion: Motion, effort: Array, wrenches: Mapping[str, Array] | None
) -> float:
    data = torque_parts(model, motion, wrenches)
    return pace(model, motion, data, ranges(model).velocity, effort).factor
