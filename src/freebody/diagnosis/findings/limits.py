"""Findings on limits and friction of joints, and on limits of left and right that differ."""

from __future__ import annotations

import math
from collections.abc import Iterator

from freebody.diagnosis.facts import FRICTIONS, JointFacts, RobotFacts, Written
from freebody.diagnosis.finding import AttributeChange, FindingKind, FoundFault
from freebody.diagnosis.findings.inertias import twins
from freebody.errors import listed
from freebody.model import refusal_rules
from freebody.model.drives import NUMBERS
from freebody.model.refusal_rules import is_not_given

_MANY_TURNS = 4.0 * math.pi * 1.01
"""rad: a range within this is one of radians."""
_MOST_DEGREES = 1080.0
_FAST = 40.0
"""rad/s that few motors of joints exceed, and many in degrees a second do."""
_DAMPED = 20.0
"""Share of a motor's effort that damping at the speed limit may take: such limits are the motor's,
not the joint's."""
_SAME = 0.02
"""Relative difference of the limits of left and right that is none."""


def _ranged(facts: RobotFacts) -> Iterator[JointFacts]:
    for joint in facts.joints:
        if joint.kind in ("revolute", "prismatic"):
            yield joint


def _swapped(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in _ranged(facts):
        lower, upper = joint.limits.get("lower"), joint.limits.get("upper")
        if lower is None or upper is None or lower.value is None or upper.value is None:
            continue
        if refusal_rules.SWAPPED.broken(lower.value, upper.value):
            changes = (*_changed(lower, upper.text), *_changed(upper, lower.text))
            reason = f"joint {joint.name!r}: its lower limit {lower.value:g} is above its upper"
            yield FoundFault(f"{reason} one, {upper.value:g}", joint.limit_line, changes)


def _changed(number: Written, text: str) -> tuple[AttributeChange, ...]:
    if number.element is None:
        return ()
    return (AttributeChange(number.element, number.attribute, text),)


def _negative(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        for rule in refusal_rules.NEGATIVE:
            (name,) = rule.about
            number = joint.limits.get(name)
            if number and number.value is not None and rule.broken(number.value):
                reason = f"joint {joint.name!r}: its {name} limit {number.value:g} is below 0"
                text = number.text.lstrip("-")
                yield FoundFault(reason, joint.limit_line, _changed(number, text))


def _missing(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in _ranged(facts):
        if joint.element is None:
            continue
        if not joint.element.all("limit"):
            yield FoundFault(f"{joint.kind} joint {joint.name!r} has no <limit>", joint.line)
            continue
        absent = [name for name in ("lower", "upper") if name not in joint.limits]
        if len(absent) == 1:
            reason = f"joint {joint.name!r} has no {absent[0]} limit, which URDF takes as 0"
            yield FoundFault(reason, joint.limit_line)


def _unstated(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        if joint.moves and joint.element is not None and joint.element.all("limit"):
            absent = [x for x in ("effort", "velocity") if x not in joint.limits]
            if absent:
                reason = f"joint {joint.name!r} has no {listed(absent)} limit"
                yield FoundFault(reason, joint.limit_line)


def _zero(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        zero = [x for x in ("effort", "velocity") if joint.moves and is_not_given(joint.limit(x))]
        if zero and not joint.mimics:
            reason = f"joint {joint.name!r}: its {listed(zero)} limit is 0, so that it cannot move"
            yield FoundFault(reason, joint.limit_line)


def _no_range(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in _ranged(facts):
        lower, upper = joint.limit("lower"), joint.limit("upper")
        if lower is not None and is_not_given(lower, upper):
            reason = f"joint {joint.name!r}: its limits are both {lower:g}, a range of no width"
            yield FoundFault(reason, joint.limit_line)


def _degrees(facts: RobotFacts) -> Iterator[FoundFault]:
    """Findings of turning joints whose limits are written in degrees: those too large for radians;
    all of the file's, where most are and none is too large for degrees. Numbers that slides have
    too, in metres, are no angles but stand for no limit."""
    ranges = {x.name: _bounds(x) for x in _ranged(facts) if _bounds(x)}
    lengths = [x for name, x in ranges.items() if not facts.joint[name].turns]
    turning = {
        name: max(map(abs, x))
        for name, x in ranges.items()
        if facts.joint[name].turns and x not in lengths
    }
    large = [name for name, x in turning.items() if _MANY_TURNS < x <= _MOST_DEGREES]
    most = len(large) > 1 and 2 * len(large) > len(turning)
    for name in turning if most and max(turning.values()) <= _MOST_DEGREES else large:
        joint = facts.joint[name]
        shown = " and ".join(f"{x:g}" for x in _bounds(joint))
        reason = f"joint {name!r}: its limits {shown} rad are many turns, as though in degrees"
        yield FoundFault(reason, joint.limit_line, _in_radians(joint))


def _in_radians(joint: JointFacts) -> tuple[AttributeChange, ...]:
    """Changes that convert a joint's range from degrees to radians, and its speed limit where that
    is too large for rad/s."""
    numbers = [joint.limits[key] for key in ("lower", "upper") if key in joint.limits]
    fast = joint.limits.get("velocity")
    if fast and fast.value is not None and _FAST < fast.value <= _MOST_DEGREES:
        numbers.append(fast)
    return tuple(
        change
        for number in numbers
        if number.value is not None
        for change in _changed(number, f"{math.radians(number.value):.9g}")
    )


def _bounds(joint: JointFacts) -> list[float]:
    values = (joint.limit("lower"), joint.limit("upper"))
    return [x for x in values if x is not None and math.isfinite(x)]


def _pushes(facts: RobotFacts) -> Iterator[FoundFault]:
    for joint in facts.joints:
        for name, number in joint.drive.items():
            refused = NUMBERS[FRICTIONS[name]].refused
            if number.value is not None and refused and refused(number.value):
                line = number.element.line if number.element else joint.line
                yield FoundFault(
                    f"joint {joint.name!r}: its {name} {number.value:g} is below 0", line
                )


def _holds(facts: RobotFacts) -> Iterator[FoundFault]:
    """Findings of joints whose motor cannot overcome their dry friction, or their damping at the
    highest speed allowed."""
    for joint in facts.joints:
        effort, speed = joint.limit("effort"), joint.limit("velocity")
        if not effort or effort < 0.0:
            continue
        friction, damping = (
            joint.drive[x].value if x in joint.drive else None for x in ("friction", "damping")
        )
        line = next((x.element.line for x in joint.drive.values() if x.element), joint.line)
        limit = f"its effort limit {effort:g}"
        if friction and friction > effort:
            reason = f"joint {joint.name!r}: its friction {friction:g} is more than {limit}"
            yield FoundFault(reason, line)
        taken = damping * speed if damping and speed and math.isfinite(speed) else 0.0
        if taken > _DAMPED * effort:
            reason = f"joint {joint.name!r}: its damping takes {taken:g} at its speed limit"
            yield FoundFault(f"{reason}, far more than {limit}", line)


def _differ(facts: RobotFacts) -> Iterator[FoundFault]:
    for left, right in twins(facts, [joint.name for joint in facts.joints]):
        a, b = facts.joint[left], facts.joint[right]
        if a.kind != b.kind or not a.moves:
            continue
        what = [x for x in ("velocity", "effort") if not _close(a.limit(x), b.limit(x))]
        if a.turns and not _mirrored(a, b):
            what.insert(0, "range")
        if what:
            reason = f"joints {left!r} and {right!r} are left and right, and differ in their limits"
            yield FoundFault(f"{reason} ({', '.join(what)})", b.limit_line)


def _close(x: float | None, y: float | None) -> bool:
    if x is None or y is None:
        return x is y
    return x == y or abs(x - y) <= _SAME * max(abs(x), abs(y))


def _mirrored(a: JointFacts, b: JointFacts) -> bool:
    (low, high), (lower, upper) = ((x.limit("lower"), x.limit("upper")) for x in (a, b))
    if low is None or high is None or lower is None or upper is None:
        return (low is None, high is None) == (lower is None, upper is None)
    width = max(high - low, upper - lower)
    return any(
        max(abs(low - x), abs(high - y)) <= _SAME * abs(width)
        for x, y in ((lower, upper), (-upper, -lower))
    )


SWAPPED = FindingKind("swapped limits", "error", "swap them", _swapped)
NEGATIVE = FindingKind("negative limit", "error", "give its size", _negative)
MISSING = FindingKind("missing limits", "warning", "give its range", _missing)
UNSTATED = FindingKind("limits not given", "notice", "give them where they are known", _unstated)
ZERO = FindingKind("zero limit", "warning", "give the motor's", _zero)
NO_RANGE = FindingKind("no range", "warning", "give a range, or make the joint fixed", _no_range)
DEGREES = FindingKind("limits in degrees", "warning", "give radians", _degrees)
PUSHES = FindingKind(
    "negative friction", "error", "friction opposes motion: give its size", _pushes
)
HOLDS = FindingKind("friction holds", "warning", "correct the friction or the limit", _holds)
DIFFER = FindingKind("left and right limits differ", "notice", "correct them if they are alike",
                     _differ)  # fmt: skip
