"""Findings that are doubts of the model: each kind of doubt with a remedy in the file, told at the
links and joints that it is about."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from freebody.diagnosis.facts import RobotFacts
from freebody.diagnosis.finding import FindingKind, FoundFault
from freebody.model.doubts import DOUBT_KINDS


def _of(kind: str) -> Callable[[RobotFacts], Iterator[FoundFault]]:
    def find(facts: RobotFacts) -> Iterator[FoundFault]:
        for doubt in facts.model.doubts if facts.model else ():
            if doubt.kind != kind:
                continue
            names = (*doubt.joints, *(name for name, _ in doubt.about))
            lines = [x for name in names if (x := facts.line_of(name)) is not None]
            yield FoundFault(doubt.clause.partition(" (--estimate")[0], next(iter(lines), None))

    return find


def findings_on(aspect: str) -> tuple[FindingKind, ...]:
    """The kinds of doubts on an aspect that have a remedy in the file, as kinds of findings."""
    return tuple(
        FindingKind(kind.name, "warning", kind.remedy, _of(kind.name))
        for kind in DOUBT_KINDS.values()
        if kind.remedy and aspect in kind.touches
    )
