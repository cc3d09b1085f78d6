"""The card of a study: what the robot carries on this path, how much faster it can go, and what
gives out first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.capacity.fitted_parts import NO_PARTS, FittedParts
from freebody.capacity.payload import LargestPayload, largest_payload
from freebody.design.duty_cycle import DutyCycle
from freebody.errors import listed
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import ranges, with_drive
from freebody.outputs.display import Tabled, TextTable
from freebody.outputs.number_text import rounded_down
from freebody.report.load_case import carried_mass
from freebody.report.results import LimitUse, MotionVerdict, instant

_UNKNOWN = "–"


class CardRow(NamedTuple):
    """A row of a card: what it is, its value as text ("–" where it is not known) with the unit, and
    what else is to be said."""

    label: str
    value: str
    unit: str
    remark: str


@dataclass(frozen=True, repr=False)
class Card(Tabled):
    """The answers on a robot along the motion of a study: how much it carries, how fast it goes,
    which limit gives out."""

    payload: float
    """The largest mass at the tip, besides what is carried (kg); infinite where nothing limits it,
    NaN where it is not known."""
    payload_joint: str
    """The joint that limits it; empty without one."""
    payload_time: float
    """When it does (s); NaN without."""
    payload_remark: str
    """Words on what limits the payload, or why it is not known."""
    faster: float
    """How many times as fast the motion can be run, as it is loaded; below 1 it has to be slower, 0
    where no slowing helps, infinite where no limit depends on it, NaN where it is not known."""
    faster_joint: str
    """The joint that is then at its limit; empty without one."""
    faster_quantity: str
    """The quantity that is: speed, torque or force; of a brake or bearing as of `LimitUse`."""
    faster_remark: str
    """Words on what then is at its limit, or why nothing is known."""
    first: LimitUse | None
    """The limit of speed, torque, power, brake or bearing that the motion uses most, or exceeds
    most, or a range that it leaves; None where none can be told of."""
    payload_by: str = ""
    """Words on the limits that judge the payload, "by its effort limits" and whatever else is
    given; empty where no mass is told of."""
    partly: bool = False
    """Whether some limits are not judged, so that another may give out before."""

    @property
    def rows(self) -> tuple[CardRow, ...]:
        """The card as rows of texts: label, value, unit, remark."""
        first = self.first
        return (
            CardRow(
                f"carries {self.payload_by}".rstrip(),
                *_number(self.payload, "kg"),
                self.payload_remark,
            ),
            CardRow(
                "has to be slowed down to" if self.faster < 1.0 else "can be run",
                *_number(self.faster, "times as fast"),
                self.faster_remark,
            ),
            CardRow("gives out first", _UNKNOWN, "", "no limit can be told of")
            if first is None
            else CardRow(
                "gives out first, of what can be judged" if self.partly else "gives out first",
                f"{first.coordinate}, {first.quantity}",
                "",
                first.text,
            ),
        )

    def _title(self) -> str:
        return "Card: " + " · ".join(_line(row) for row in self.rows)

    def _table(self) -> TextTable:
        return TextTable(("", "value", "unit", "remark"), self.rows)


def _line(row: CardRow) -> str:
    return " ".join(x for x in (row.label, row.value, row.unit) if x)


def _number(x: float, unit: str) -> tuple[str, str]:
    if np.isnan(x):
        return _UNKNOWN, ""
    return ("any", "") if np.isinf(x) else (rounded_down(x), unit)


def card(
    model: Model,
    motion: Motion | DutyCycle,
    judged: MotionVerdict,
    wrenches: Mapping[str, Array] | None,
    parts: FittedParts = NO_PARTS,
) -> Card:
    """The card of a motion, or of a duty cycle, with its verdict, under constant wrenches on the
    robot by frame, with the brakes and bearings that it has."""
    reason = _no_payload(model)
    found = None if reason else largest_payload(model, motion, wrenches or {}, parts)
    mass, joint, time = (np.nan, "", np.nan) if found is None else _carried(found)
    remark = reason
    if found is not None:
        besides = _besides(model, motion) if found.told else ""
        remark = besides + found.remark + _in_segment(found)
    limit = judged.factor_limit
    return Card(
        payload=mass,
        payload_joint=joint,
        payload_time=time,
        payload_remark=remark,
        payload_by=found.by if found is not None and np.isfinite(mass) else "",
        faster=np.nan if _unlimited(judged) else judged.factor,
        faster_joint=limit.coordinate if limit else "",
        faster_quantity=limit.quantity if limit else "",
        faster_remark=_pace_words(judged),
        first=next((use for use in judged.uses if _gives_out(use)), None),
        partly=judged.outcome == "not judged",
    )


def _gives_out(use: LimitUse) -> bool:
    """Whether a limit is one that gives out: within its range no position does."""
    return use.exceeded or use.quantity != "position"


def _carried(found: LargestPayload) -> tuple[float, str, float]:
    """(mass, the joint that limits it, when), where a mass is to be told of."""
    if not found.told:
        return np.nan, "", np.nan
    at = found.least
    k = int(found.joint[at])
    joint = "" if k < 0 else found.joint_names[k]
    return float(found.mass[at]), joint, float(found.time[at])


def _in_segment(found: LargestPayload) -> str:
    """Which segment of a duty cycle the least of the masses is of; empty for a motion."""
    if not (found.told and found.mass.ndim):
        return ""
    return f" of segment {int(found.least[0]) + 1}"


def _besides(model: Model, motion: Motion | DutyCycle) -> str:
    """Words on what the robot carries already; empty where it is nothing."""
    if isinstance(motion, DutyCycle) and any(x.payload is not None for x in motion.segments):
        return "in every segment, besides what it carries there; "
    carried = carried_mass(model)
    return f"besides the {carried:.4g} kg that it carries; " if carried else ""


def _no_payload(model: Model) -> str:
    """Why no largest payload is known; empty where one is."""
    if model.tip is None:
        return "not known: the robot has no single tip; name one"
    if model.passive and not model.loops:
        return f"not known: nothing drives {listed(map(repr, model.passive_names), 4)}"
    if not (np.isfinite(ranges(model).effort) & with_drive(model)).any():
        return "not known: no drive has an effort limit"
    return ""


def _unlimited(judged: MotionVerdict) -> bool:
    """Whether no limit ends the pace only because limits are lacking."""
    return judged.outcome == "not judged" and bool(np.isinf(judged.factor))


def _pace_words(judged: MotionVerdict) -> str:
    limit, factor = judged.factor_limit, judged.factor
    if np.isnan(factor) or _unlimited(judged):
        return "not known: see the verdict"
    if limit is None:
        return "no limit depends on the speed"
    when = instant(limit.time, limit.segment)
    if factor == 0.0:
        return (
            f"no slowing helps: held still, {limit.coordinate} is beyond its limit of "
            f"{limit.quantity}{when}"
        )
    share = "" if judged.outcome != "not judged" else ", of the limits that are given"
    return f"{limit.coordinate} is then at its limit of {limit.quantity}{when}{share}"
