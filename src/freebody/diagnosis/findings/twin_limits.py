"""Findings on pairs of left and right joints that differ."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.diagnosis.facts import JointFacts, RobotFacts
from freebody.diagnosis.finding import FindingKind, FoundFault
from freebody.diagnosis.findings.inertias import twins

_SAME = 0.02


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


DIFFER = FindingKind("left and right limits differ", "notice", "correct them if they are alike",
                     _differ)  # fmt: skip
