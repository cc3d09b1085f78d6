"""Findings that are doubts of the model: each kind of doubt that a file is to be corrected for,
told at the links and joints that it is about."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from freebody.diagnosis.facts import RobotFacts
from freebody.diagnosis.finding import FindingKind, FoundFault
from freebody.model.doubts import IMPLAUSIBLE, NO_MASSES, PLACEHOLDERS


def _of(kind: str) -> Callable[[RobotFacts], Iterator[FoundFault]]:
    def find(facts: RobotFacts) -> Iterator[FoundFault]:
        for doubt in facts.model.doubts if facts.model else ():
            if doubt.kind != kind:
                continue
            names = (*doubt.joints, *(name for name, _ in doubt.about))
            lines = [x for name in names if (x := facts.line_of(name)) is not None]
            yield FoundFault(doubt.clause.partition(" (--estimate")[0], next(iter(lines), None))

    return find


NO_MASS = FindingKind(
    NO_MASSES, "warning", "give them mass, or estimate it with estimate_inertia=", _of(NO_MASSES)
)
MASSES = FindingKind(IMPLAUSIBLE, "warning", "give the robot's own numbers", _of(IMPLAUSIBLE))
LIMITS = FindingKind(PLACEHOLDERS, "warning", "give the motors' own limits", _of(PLACEHOLDERS))
