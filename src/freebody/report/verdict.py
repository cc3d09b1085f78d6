"""The verdict on a motion: feasible, not feasible, or not judged, and the limit that decides.

A verdict is never kinder than the truth. A doubt on the robot that bars the verdict (`doubts`:
masses that are none, limits that are placeholders or not given, estimates) makes void what rests on
it, is named, and nothing is then called feasible; what is left is judged all the same. A limit of 0
counts as not given (`motion.ranges`). Files give no continuous rating and no power, so that the RMS
torque is held against the effort limit and the power against effort times speed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.any_chain.effort_limits import followers
from freebody.arrays import Array
from freebody.capacity.fitted_parts import BEARING_LIMITS, NO_PARTS, FittedParts
from freebody.capacity.limited_loads import EFFORTS, LimitedLoads
from freebody.capacity.part_loads import part_loads
from freebody.capacity.time_scaling import LimitedMotion, Pace, limited, pace, parts
from freebody.errors import listed
from freebody.model.doubt_rules.aspects import EFFORTS as EFFORT_LIMITS
from freebody.model.doubt_rules.aspects import MASSES, RANGES, ROTORS, SPEEDS
from freebody.model.doubts import Doubt, barring, capital
from freebody.model.drives import DriveLaw
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries, shaft_names
from freebody.motion.motion import Motion
from freebody.motion.ranges import CLOSE, Ranges, angular, position_columns, ranges
from freebody.outputs.number_text import rounded_down
from freebody.report.results import (
    LimitUse,
    MotionVerdict,
    PaceLimit,
    VerdictOutcome,
    instant,
    percent,
)

if TYPE_CHECKING:
    import xarray as xr

_UNDRIVEN = 1e-2
"""Share of what acts at a passive joint that differentiating a file's digits leaves there."""
_NAMES = 4  # in a list of joints
_TIGHT = 1.001  # a pace below it is called "as fast as it goes"


@dataclass(frozen=True, eq=False)
class JudgedMotion:
    """The grounds of a verdict on a motion, or on one of several."""

    model: Model
    data: xr.Dataset
    limited: LimitedMotion
    uses: tuple[LimitUse, ...]


def judged_motion(
    model: Model,
    motion: Motion,
    data: xr.Dataset,
    found: xr.Dataset,
    wrenches: Mapping[str, Array] | None = None,
    segment: int = 0,
    parts: FittedParts = NO_PARTS,
) -> JudgedMotion:
    """A motion to be judged, from `Study.data` and `Study.summary`, under constant wrenches by
    frame; segment: of a duty cycle, from 1."""
    states = motion.q, motion.qd, motion.qdd
    fitted = part_loads("study", model, parts, motion.t, states, wrenches)
    uses = (
        *_uses(model, motion, ranges(model), found),
        *_followers_uses(model, motion, wrenches),
        *part_uses(fitted),
    )
    return JudgedMotion(
        model,
        data,
        limited(model, motion, data, wrenches, segment=segment, fitted=fitted),
        tuple(replace(use, segment=segment) for use in uses),
    )


def verdict(
    motions: Sequence[JudgedMotion],
    noisy: bool = False,
    uses: Iterable[LimitUse] | None = None,
    rests: Sequence[LimitedMotion] = (),
) -> MotionVerdict:
    """The verdict on a motion, or on all segments of a duty cycle together.

    noisy: whether the noise of a motion is part of its torques. uses: of limits, default those of
    all motions. rests: between segments.
    """
    doubts = _WeighedDoubts.of(motions)
    every = _most_used_first(motions, uses)
    told = [use for use in every if not _rests(use, doubts.wrong)]
    over = [use for use in told if use.exceeded and not doubtful(use, doubts.every)]
    undriven = _of_all(_undriven, motions) if doubts.masses_known else ()
    loose = _of_all(_own_pace, motions) if doubts.torques_meant else ()
    outcome = doubts.outcome(bool(over or undriven))
    sentences = [*_reasons(outcome, told, over, undriven, barring(doubts.every))]
    factor, limit = float("nan"), None
    if loose:
        sentences.append(_no_other_pace(motions[0].model, loose, slower=bool(over or undriven)))
    elif told and not doubts.wrong:
        run = pace([*(one.limited for one in motions), *rests])
        sentences += _paces(motions[0].model, run, told, bool(undriven), doubts.partly)
        factor, limit = run.factor, PaceLimit.of(run)
    if noisy and doubts.torques_meant:
        sentences.append(_NOISY)
    sentences += [capital(doubt.text) for doubt in doubts.every if not doubt.of.bars]
    return MotionVerdict(outcome, " ".join(sentences), tuple(told), doubts.every, factor, limit)


_OTHER_LOADS = (
    "At which other speed its bearings would keep their limits is not known: friction in its loops "
    "changes with the speed."
)
_NOISY = "The noise of the motion counts as torque here; --smooth auto (smooth=True) takes it out."


def _most_used_first(
    motions: Sequence[JudgedMotion], uses: Iterable[LimitUse] | None
) -> list[LimitUse]:
    """The uses of limits, by default those of all motions, the largest share first."""
    every = [use for one in motions for use in one.uses] if uses is None else uses
    return sorted(every, key=lambda use: -use.fraction)


def _of_all(
    find: Callable[[Model, xr.Dataset], Sequence[str]], motions: Sequence[JudgedMotion]
) -> tuple[str, ...]:
    """The findings of all motions, each once."""
    return tuple(dict.fromkeys(x for one in motions for x in find(one.model, one.data)))


class _WeighedDoubts:
    """The doubts about a robot sorted: those due to something wrong in its file, those that leave
    something unknown, and what can be judged all the same."""

    def __init__(self, every: tuple[Doubt, ...]):
        self.every = every
        self.wrong = [doubt for doubt in every if doubt.of.mend]
        self.unknown = [doubt for doubt in barring(every) if not doubt.of.mend]
        self.torques_meant = not any({MASSES, ROTORS} & {*x.of.touches} for x in self.wrong)
        """Whether torques say something, be it by estimates."""
        estimated = any(MASSES in x.of.touches for x in self.unknown)
        self.masses_known = self.torques_meant and not estimated
        self.partly = any(doubt.of.absent for doubt in self.unknown)
        """Whether some limits are not given."""

    @staticmethod
    def of(motions: Sequence[JudgedMotion]) -> _WeighedDoubts:
        """The doubts about the robot as it is loaded in all motions, each once."""
        every = (doubt for one in motions for doubt in one.model.doubts)
        return _WeighedDoubts(tuple(dict.fromkeys(every)))

    def outcome(self, failed: bool) -> VerdictOutcome:
        """The outcome of the verdict; failed: whether something that can be judged fails."""
        if failed:
            return "not feasible"
        return "not judged" if self.wrong or self.unknown else "feasible"


_PART_LIMITS = {
    "brake torque": "what {joint}'s brake holds",
    "brake force": "what {joint}'s brake holds",
    **{limit.name: f"the {limit.name} of {{joint}}'s bearing" for limit in BEARING_LIMITS},
}
"""Limits of brakes and bearings in words, by the quantity that has them."""


def _rests(use: LimitUse, doubts: Sequence[Doubt]) -> bool:
    """Whether the use of a limit depends on something doubtful."""
    aspects = _ASPECTS.get(use.quantity, (MASSES, ROTORS, EFFORT_LIMITS))
    return any(
        set(aspects) & set(doubt.of.touches)
        for doubt in doubts
        if not doubt.of.absent and (not doubt.joints or use.coordinate in doubt.joints)
    )


def doubtful(use: LimitUse, doubts: Iterable[Doubt]) -> bool:
    """Whether the use of a limit depends on something that is not known, so that no motion is
    refused for it."""
    return _rests(use, [doubt for doubt in barring(doubts) if not doubt.of.mend])


_ASPECTS = {
    "position": (RANGES,),
    "speed": (SPEEDS,),
    "power": (MASSES, ROTORS, EFFORT_LIMITS, SPEEDS),
    **dict.fromkeys(_PART_LIMITS, (MASSES,)),
}
"""Aspects that the use of a limit rests on, where that is not a torque."""


# ------------------------------------------------------------ what is used of each limit
def _uses(model: Model, motion: Motion, allowed: Ranges, found: xr.Dataset) -> Iterator[LimitUse]:
    driven = set(model.driven_names)
    iq, iv = position_columns(model)
    column = dict(zip(iv.tolist(), iq.tolist(), strict=True))
    for k, name in enumerate(model.velocity_names):
        unit, effort_unit = str(found["unit"].values[k]), str(found["effort_unit"].values[k])
        what = "torque" if effort_unit == "N m" else "force"
        top, most = float(allowed.velocity[k]), float(allowed.effort[k])
        if k in column:
            share = float(found["position_fraction"].values[k])
            yield from _position(motion, allowed, k, column[k], name, unit, share)
        for quantity, limit, used, value, time, of in (
            ("speed", top, "velocity", "peak_speed", "peak_speed_time", f"{unit}/s"),
            (what, most, "effort", "peak_torque", "peak_torque_time", effort_unit),
            (f"RMS {what}", most, "rms", "rms_torque", None, effort_unit),
            ("power", most * top, "power", "peak_power", "peak_power_time", "W"),
        ):
            if np.isfinite(limit) and (quantity == "speed" or name in driven):
                size, share = (float(found[x].values[k]) for x in (value, f"{used}_fraction"))
                when = float(found[time].values[k]) if time else float("nan")
                yield LimitUse(quantity, name, size, limit, share, when, of)


def _followers_uses(
    model: Model, motion: Motion, wrenches: Mapping[str, Array] | None
) -> Iterator[LimitUse]:
    """The torques and forces that reach joints which follow others and have limits of their own;
    their speeds and ranges are in those of the joints that they follow."""
    following = followers(model)
    if following is None:
        return
    tau = following.torques(motion.q, motion.qd, motion.qdd, wrenches)
    turns = angular(following.freed)[following.columns]
    for name, turning, limit, x in zip(
        following.names, turns, following.limits, tau.T, strict=True
    ):
        k, (what, unit) = int(np.argmax(np.abs(x))), EFFORTS[bool(turning)]
        share, time = abs(float(x[k])) / float(limit), float(motion.t[k])
        yield LimitUse(what, name, float(x[k]), float(limit), share, time, unit)


def part_uses(fitted: Iterable[LimitedLoads]) -> Iterator[LimitUse]:
    """The uses of the limits of brakes and bearings."""
    for part in fitted:
        loads, shares = np.abs(part.at(1.0)), part.shares(1.0)
        for j, k in enumerate(np.argmax(shares, axis=0)):
            yield LimitUse(
                part.quantities[j],
                part.names[j],
                float(loads[k, j]),
                float(part.limits[j]),
                float(shares[k, j]),
                float(part.time[k]),
                part.units[j],
            )


def _position(
    motion: Motion, allowed: Ranges, k: int, column: int, name: str, unit: str, fraction: float
) -> Iterator[LimitUse]:
    """The nearest approach to a position limit, or the largest excess of one; of one-sided ranges
    only an excess counts."""
    found, lower, upper = motion.peaks.position, float(allowed.lower[k]), float(allowed.upper[k])
    low, high = float(found.low[column]), float(found.high[column])
    to_lower, to_upper = low - lower, upper - high
    at, when, limit, end = high, float(found.high_at[column]), upper, "upper"
    if to_lower < to_upper:
        at, when, limit, end = low, float(found.low_at[column]), lower, "lower"
    if not np.isfinite(limit):
        return
    if np.isnan(fraction):  # the other end is open: within, or beyond by more than rounding
        beyond = -min(to_lower, to_upper)
        if beyond <= CLOSE * max(1.0, abs(limit)):
            return
        fraction = 1.0 + beyond / (2 * np.pi if allowed.turns[k] else 1.0)
    yield LimitUse("position", name, at, limit, fraction, when, unit, end)


# ------------------------------------------------------------ what is not there
def _undriven(model: Model, data: xr.Dataset) -> tuple[str, ...]:
    """Sentences on passive joints of an open chain at which the motion needs a torque."""
    if model.loops:
        return ()
    tau, acting = np.abs(data["tau"].values).max(axis=0), _acting(model, data)
    found, twists = [], shaft_entries(model)
    for k in model.passive:
        if tau[k] > _UNDRIVEN * acting[k]:
            unit = str(data["effort_unit"].values[k])
            name = model.velocity_names[k]
            text = f"{name} is passive, and the motion needs {tau[k]:.3g} {unit} there"
            if k in twists:
                text = (
                    f"{name} is the shaft of a flexible joint, and the motion does not twist it by "
                    f"what it carries: it is off by {tau[k]:.3g} {unit}"
                )
            found.append(text)
    return tuple(found)


def _own_pace(model: Model, data: xr.Dataset) -> tuple[str, ...]:
    """Names of passive joints of an open chain moved by gravity, springs or friction, which would
    not follow at another pace."""
    if model.loops:
        return ()
    _, viscous, held = (np.abs(part).max(axis=0) for part in parts(model, data))
    acting = _acting(model, data)
    return tuple(
        model.velocity_names[k]
        for k in model.passive
        if max(viscous[k], held[k]) > _UNDRIVEN * acting[k]
    )


def _acting(model: Model, data: xr.Dataset) -> np.ndarray:
    """The size (nv,) of the efforts at each coordinate: of the parts of its torque, or of its
    joint's load times its body's arm."""
    size = np.sum([np.abs(part) for part in parts(model, data)], axis=0).max(axis=0)
    load = np.linalg.norm(data["reaction_force"].values, axis=-1).max(axis=0)
    arm = np.linalg.norm(data["body_com"].values - data["body_origin"].values, axis=-1).max(axis=0)
    for i, at in enumerate(model.coordinates):
        for k in at.v:
            lever = arm[i] if str(data["effort_unit"].values[k]) == "N m" else 1.0
            size[k] = max(size[k], np.nan_to_num(load[i] * lever))
    return size


# ------------------------------------------------------------ in words
def _reasons(
    outcome: VerdictOutcome,
    uses: Sequence[LimitUse],
    over: Sequence[LimitUse],
    undriven: Sequence[str],
    doubts: Sequence[Doubt],
) -> Iterator[str]:
    """Sentences on the reason for a verdict, the first of which continues the outcome."""
    if over:
        more = len(over) - 1
        others = f"; {more} more limit{'s are' if more > 1 else ' is'} exceeded" if more else ""
        yield f"{over[0].text}{others}."
    for sentence in undriven:
        yield f"{sentence}."
    if outcome == "feasible":
        yield f"the motion stays within every limit; nearest: {uses[0].text}."
    first = outcome == "not judged"
    for sentence in _doubted(doubts):
        yield sentence if first else capital(sentence)
        first = False
    if outcome == "not judged" and uses and not any(doubt.of.mend for doubt in doubts):
        yield _but_for_doubts(uses, doubts)


def _but_for_doubts(uses: Sequence[LimitUse], doubts: Sequence[Doubt]) -> str:
    """A sentence on a motion that is not judged: the verdict if nothing were unknown."""
    beyond = [use for use in uses if use.exceeded]
    estimated = "" if all(doubt.of.absent for doubt in doubts) else " by the estimates"
    if beyond:
        return f"It would not be feasible{estimated}: {beyond[0].text}."
    if any(doubt.of.absent for doubt in doubts):
        return f"The limits that are given are kept{estimated}; nearest: {uses[0].text}."
    return f"Every limit is kept{estimated}; nearest: {uses[0].text}."


def _doubted(doubts: Sequence[Doubt]) -> Iterator[str]:
    """Sentences on what prevents a verdict: first what is wrong with the torques, in one, then the
    rest."""
    torques = [x for x in doubts if x.of.mend and {MASSES, ROTORS} & {*x.of.touches}]
    if torques:
        yield f"the torques cannot be trusted: {'; '.join(x.clause for x in torques)}."
    yield from (x.text for x in doubts if x not in torques)


def _paces(
    model: Model, run: Pace, uses: Sequence[LimitUse], undriven: bool, partly: bool
) -> list[str]:
    """Sentences on how much faster the motion could be run, or how much slower it has to be."""
    out = any(use.exceeded and use.quantity == "position" for use in uses)
    if run.factor == 0.0:
        return [_held_too_much(model, run)]
    if np.isnan(run.factor):
        return [_OTHER_LOADS]
    if any(use.exceeded and use.quantity != "position" for use in uses):
        rest = "; the other problems remain" if out or undriven else ""
        parts = any(use.quantity in _PART_LIMITS for use in uses)
        kinds = "speed, torque, brakes and bearings" if parts else "speed and torque"
        return [
            f"It would keep the limits of {kinds} at {rounded_down(run.factor)} times its "
            f"speed ({1 / run.factor:.3g} times the duration){rest}."
        ]
    if out or undriven:
        return ["Slowing down does not help."]
    if not np.isfinite(run.factor):
        return []
    if run.factor < _TIGHT:
        return [
            "At a higher speed a limit would be exceeded."
            if partly
            else "It cannot be run any faster."
        ]
    if partly:  # what is not given may well be exceeded before
        return [f"They would be kept up to {rounded_down(run.factor)} times that speed."]
    return [f"It could be run up to {rounded_down(run.factor)} times as fast."]


def _held_too_much(model: Model, run: Pace) -> str:
    """A sentence on torques that exceed a limit however slow the motion is."""
    what = "gravity" if not _holds_more(model) else "gravity, springs and friction"
    limit = _PART_LIMITS.get(run.quantity, "{joint}'s limit").format(joint=run.joint)
    return (
        f"Slowing down does not help: {what} alone require{'s' if what == 'gravity' else ''} "
        f"{percent(run.share)} of {limit}"
        f"{instant(run.time, run.segment)}."
    )


def _no_other_pace(model: Model, names: Sequence[str], slower: bool) -> str:
    if set(names) <= set(shaft_names(model)):
        return (
            "At another speed the shafts of its flexible joints would twist otherwise: how much "
            'faster the links could move, model.without("shafts") tells nearly.'
        )
    several = len(names) > 1
    opening = "Slowing down does not help" if slower else "It cannot be run at another speed"
    return (
        f"{opening}: {listed(names, _NAMES)} {'have' if several else 'has'} no motor and would "
        "not follow."
    )


def _holds_more(model: Model) -> bool:
    """Whether torques other than gravity's are independent of the pace: springs, dry friction."""
    if any(strut.stiffness or strut.preload for strut in model.struts):
        return True
    laws = (x for b in model.tree.bodies if b.drive is not None for x in b.drive.laws)
    return any(bool(x.p[0]) and _holds(x.law) for x in laws)


def _holds(law: DriveLaw) -> bool:
    return law.energy is not None or law.losses is not None or law.power == 0
